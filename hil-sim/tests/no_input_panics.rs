//! Whatever number stands in a scenario, the program refuses it or runs with
//! it: it never panics and never hangs.

mod rig;

use std::process::Child;
use std::time::{Duration, Instant};

use rig::Rig;

/// Values that are too large, too small, no number, or no number at all.
const VALUES: [&str; 18] = [
    "-1",
    "0",
    "1",
    "1000",
    "1e6",
    "1e-6",
    "1e20",
    "1e-20",
    "1e308",
    "-1e308",
    "1e-308",
    "nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "\"text\"",
    "[]",
    "{}",
];

/// A run that takes this long hangs: each simulates a few hundredths of a second.
const PATIENCE: Duration = Duration::from_secs(60);

#[test]
fn every_number_of_the_shipped_scenario_may_be_anything() {
    let keys = numeric_keys(include_str!("../scenarios/dac-friction.toml"));
    assert!(keys.len() > 30, "{keys:?}");
    for key in &keys {
        for value in VALUES {
            survives(&[&format!("{key}={value}")]);
        }
    }
}

#[test]
fn keys_that_the_shipped_scenario_leaves_out_may_be_anything() {
    let keys = [
        "safety.torque_limit_nm",
        "safety.torque_rate_nm_per_s",
        "safety.feedback_timeout_periods",
        "safety.heartbeat_timeout_s",
        "safety.damaged_frames",
        "safety.damaged_frames_window_s",
        "safety.encoder_jump_rad",
        "safety.following_error_rad",
        "safety.wheel_speed_limit_rad_s",
        "safety.saturation_timeout_s",
        "safety.overrun_periods",
        "safety.enable_timeout_s",
        "safety.stop_deceleration_rad_s2",
        "safety.stop_timeout_s",
        "safety.rest_speed_rad_s",
        "robot.friction.right.viscous_nm_s_per_rad",
        "robot.friction.left.static_nm",
        "controller.model.mass_kg",
        "controller.model.wheel_radius_m",
    ];
    for key in keys {
        for value in VALUES {
            survives(&[&format!("{key}={value}")]);
        }
    }
}

#[test]
fn the_other_laws_links_models_and_paths_survive_the_same() {
    let kanayama = r#"controller={law="dac-matched",kd_per_s=3.0,kp_per_s2=0.6,pose_loop="kanayama"}"#;
    let segments = r#"path={kind="segments",from_m=[0,0],heading_rad=0,speed_m_s=1,acceleration_m_s2=1,easing_m=0.1,segment=[{line_m=1},{arc_rad=1,radius_m=1}]}"#;
    let table: [(&[&str], &[&str]); 6] = [
        (&[r#"controller={law="pi-speed",kp=1.0,ki=3.0}"#], &["controller.kp", "controller.ki"]),
        (&[r#"bus.link="ideal""#], &["robot.half_track_m", "robot.wheel_radius_m", "controller.model.load.mass_kg"]),
        (&[r#"robot.model="rigid-body""#], &["robot.load.cog_distance_m", "robot.load.cog_angle_rad"]),
        (&[kanayama], &["controller.kanayama.kx_per_s", "controller.kanayama.speed_limit_m_s", "start.heading_rad"]),
        (&[r#"path={kind="figure-eight",center_m=[0,0],width_m=1,duration_s=1}"#], &["path.width_m", "path.axis_rad"]),
        (&[segments], &["path.speed_m_s", "path.acceleration_m_s2", "path.easing_m", "path.heading_rad"]),
    ];
    for (base, keys) in table {
        for key in keys {
            for value in VALUES {
                survives(&[base, &[&*format!("{key}={value}")]].concat());
            }
        }
    }
}

#[test]
fn a_bus_too_slow_for_its_period_ends_with_findings() {
    for (period, bitrate) in [("period_s=0.00001", "bus.bitrate_bit_s=10000"), ("period_s=0.0002", "seed=1")] {
        let rig = Rig::new();
        rig.run("dac-friction", &["expect=[]", period, bitrate]).expect_status(1);
        let summary = rig.summary("runs");
        assert_eq!(summary["end"], "blocked");
        let findings = rig::findings(&summary);
        assert!(findings.contains("blocked") && findings.contains("bus.bitrate_bit_s"), "{findings}");
        assert!(rig::number(&summary, "/bus/lost") > 0.0);
    }
}

/// Runs a few periods and wants one of the statuses that the program has.
#[track_caller]
fn survives(overrides: &[&str]) {
    let rig = Rig::new();
    let short = ["duration_s=0.05", "path.duration_s=0.05", "expect=[]"];
    let mut args = vec!["run", "dac-friction", "--no-log"];
    short.iter().chain(overrides).for_each(|set| args.extend(["--set", set]));
    // Not the length of a run, which would only be long.
    if overrides.iter().any(|set| *set == "duration_s=1000" || *set == "duration_s=1e6") {
        return;
    }
    let error = rig.path("stderr");
    let file = std::fs::File::create(&error).expect("the folder is writable");
    let child = rig.command(&args).stdout(std::process::Stdio::null()).stderr(file).spawn().expect("it starts");
    let status = wait(child).unwrap_or_else(|| panic!("{overrides:?} hangs"));
    let said = std::fs::read_to_string(error).expect("UTF-8");
    assert!(matches!(status, 0..=2), "{overrides:?} ended with {status}:\n{said}");
    assert_eq!(status == 2, said.starts_with("error: "), "{overrides:?} ended with {status}:\n{said}");
    assert_eq!(status == 2, !rig.files().contains(&"runs".to_owned()), "{overrides:?} ended with {status}:\n{said}");
}

/// The status of a program that ends in time.
#[allow(clippy::disallowed_methods, reason = "a program that hangs can only be told by the wall clock")]
fn wait(mut child: Child) -> Option<i32> {
    let started = Instant::now();
    loop {
        if let Some(status) = child.try_wait().expect("it is our child") {
            return Some(status.code().unwrap_or(-1));
        }
        if started.elapsed() > PATIENCE {
            child.kill().expect("it is our child");
            child.wait().expect("it is our child");
            return None;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// The dotted path of every key of a scenario that has a number or numbers.
fn numeric_keys(scenario: &str) -> Vec<String> {
    let mut section = String::new();
    let mut keys = Vec::new();
    for line in scenario.lines().map(|line| line.split('#').next().unwrap_or("").trim()) {
        if let Some(name) = line.strip_prefix('[').filter(|_| !line.starts_with("[[")) {
            section = format!("{}.", name.trim_end_matches(']'));
        } else if line.starts_with("[[") {
            break;
        } else if let Some((key, value)) = line.split_once('=').filter(|(_, value)| !value.contains('"')) {
            assert!(!value.trim().is_empty());
            keys.push(format!("{section}{}", key.trim()));
        }
    }
    keys
}
