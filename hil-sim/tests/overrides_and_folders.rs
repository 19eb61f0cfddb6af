//! What `hil-sim run` takes, and where it puts what it makes.

mod rig;

use rig::{Rig, figures, findings, number};
use serde_json::Value;

const SHORT: [&str; 3] = ["duration_s=0.5", "path.duration_s=10.0", "expect=[]"];

/// The hash of the frames of a short run with more overrides.
#[track_caller]
fn frames(overrides: &[&str]) -> Value {
    figures(&[&SHORT[..], overrides].concat())["frames_blake3"].clone()
}

/// Arguments of a short run.
fn short<'a>(args: &[&'a str]) -> Vec<&'a str> {
    let sets = SHORT.iter().flat_map(|set| ["--set", *set]);
    args.iter().copied().chain(sets).collect()
}

#[test]
fn a_run_leaves_its_log_its_summary_and_its_page_under_runs() {
    let rig = Rig::new();
    let run = rig.hil_sim(&short(&["run", "dac-friction"])).expect_status(0);
    assert_eq!(rig.files(), ["runs"]);
    assert_eq!(rig::files_in(&rig.path("runs")), ["report.html", "run.mcap", "summary.json"]);
    assert!(run.stdout.contains("runs/run.mcap") && run.stdout.contains("runs/summary.json"), "{}", run.stdout);
    assert_eq!(run.stderr, "");
}

#[test]
fn out_says_where_and_is_made_with_its_parents() {
    let rig = Rig::new();
    rig.hil_sim(&short(&["run", "dac-friction", "--out", "a/b c"])).expect_status(0);
    assert_eq!(rig::files_in(&rig.path("a/b c")), ["report.html", "run.mcap", "summary.json"]);
    assert_eq!(rig.files(), ["a"]);
}

#[test]
fn without_log_and_page_there_is_only_the_summary() {
    let rig = Rig::new();
    let run = rig.hil_sim(&short(&["run", "dac-friction", "--no-log", "--no-report"])).expect_status(0);
    assert_eq!(rig::files_in(&rig.path("runs")), ["summary.json"]);
    assert!(!run.stdout.contains("run.mcap") && !run.stdout.contains("report.html"), "{}", run.stdout);
}

#[test]
fn several_scenarios_get_a_folder_each() {
    let rig = Rig::new();
    rig.write("mine.toml", "base = \"dac-friction\"\nname = \"second\"\n");
    rig.hil_sim(&short(&["run", "dac-friction", "mine.toml", "--out", "out"])).expect_status(0);
    assert_eq!(rig::files_in(&rig.path("out")), ["dac-friction", "second"]);
    for name in ["dac-friction", "second"] {
        let folder = format!("out/{name}");
        assert_eq!(rig::files_in(&rig.path(&folder)), ["report.html", "run.mcap", "summary.json"]);
        assert_eq!(rig.summary(&folder)["scenario"], name);
    }
}

#[test]
fn of_several_scenarios_one_that_fails_is_enough_and_the_others_run_all_the_same() {
    let rig = Rig::new();
    let scenario = |name: &str, max: f64| {
        format!(
            "base = \"dac-friction\"\nname = \"{name}\"\nduration_s = 0.5\n\
             [[expect]]\nsignal = \"position_error_m\"\nmax = {max}\n"
        )
    };
    rig.write("a.toml", &scenario("fails", 0.0));
    rig.write("b.toml", &scenario("holds", 1.0));
    rig.hil_sim(&["run", "a.toml", "b.toml", "--no-log"]).expect_status(1);
    assert_eq!(rig.summary("runs/fails")["passed"], false);
    assert_eq!(rig.summary("runs/holds")["passed"], true);
}

#[test]
fn ten_lines_make_a_scenario_of_one_s_own() {
    let rig = Rig::new();
    let text = r#"base = "dac-friction"
name = "heavier-and-faster"
duration_s = 0.5
[robot.load]
mass_kg = 120.0
[path]
duration_s = 60.0
[[expect]]
signal = "position_error_m"
max = 0.5
"#;
    assert_eq!(text.lines().count(), 10);
    rig.write("own/mine.toml", text);
    rig.hil_sim(&["run", "own/mine.toml", "--no-log"]).expect_status(0);
    let summary = rig.summary("runs");
    assert_eq!(summary["scenario"], "heavier-and-faster");
    assert_eq!(summary["ticks"], 100);
    assert_eq!(summary["expectations"].as_array().map(Vec::len), Some(1), "its own, and not the base's");
    let same = ["duration_s=0.5", "expect=[]", "robot.load.mass_kg=120.0", "path.duration_s=60.0"];
    assert_eq!(summary["frames_blake3"], figures(&same)["frames_blake3"]);
}

#[test]
fn a_base_is_found_beside_the_file_that_names_it() {
    let rig = Rig::new();
    rig.write("deep/base.toml", "base = \"dac-friction\"\nname = \"base\"\nseed = 5\n");
    rig.write("deep/mine.toml", "base = \"base.toml\"\nname = \"mine\"\n");
    rig.run("deep/mine.toml", &SHORT).expect_status(0);
    assert_eq!(rig.summary("runs")["seed"], 5);
}

#[test]
fn the_shipped_scenario_is_the_file_that_ships() {
    let rig = Rig::new();
    rig.write("copy.toml", include_str!("../scenarios/dac-friction.toml"));
    rig.run("copy.toml", &SHORT).expect_status(0);
    assert_eq!(rig.summary("runs")["frames_blake3"], frames(&[]));
    let list = rig.hil_sim(&["run", "--list"]).expect_status(0);
    assert!(list.stdout.lines().any(|line| line == "dac-friction"), "{}", list.stdout);
}

#[test]
fn an_override_sets_a_key_that_is_there_and_one_that_is_not() {
    let summary = figures(&["duration_s=0.5", "expect=[]", "seed=42", "period_s=0.01"]);
    assert_eq!((&summary["seed"], &summary["ticks"]), (&42.into(), &50.into()));
    assert_eq!(summary["overrides"][2], "seed=42");
    assert_eq!(frames(&["safety.torque_limit_nm=90.0"]), frames(&[]), "the drive's limit is 90 N m anyway");
    assert_ne!(frames(&["safety.torque_limit_nm=10.0"]), frames(&[]));
    assert_ne!(frames(&["controller.model.gear_ratio=4.0"]), frames(&[]));
}

#[test]
fn a_later_override_wins_and_one_may_replace_a_whole_table() {
    assert_eq!(frames(&["robot.mass_kg=99.0", "robot.mass_kg=46.5"]), frames(&[]));
    assert_eq!(figures(&[&SHORT[..], &["controller={law=\"pi-speed\",kp=1,ki=3}"]].concat())["law"], "pi-speed");
    let none = "robot.friction={viscous_nm_s_per_rad=0,static_nm=0,coulomb_nm=0,stribeck_s_per_rad=0}";
    assert_ne!(frames(&[none]), frames(&[]));
}

#[test]
fn one_override_swaps_the_law_and_leaves_the_other_laws_keys_alone() {
    for law in ["dac", "dac-matched"] {
        assert_eq!(figures(&[&SHORT[..], &[&format!("controller.law={law:?}")]].concat())["law"], law);
    }
    for law in ["pi-speed", "pi-angle"] {
        let sets = [&format!("controller.law={law:?}"), "controller.kp=1.0", "controller.ki=3.0"];
        assert_eq!(figures(&[&SHORT[..], &sets].concat())["law"], law);
    }
}

#[test]
fn friction_can_be_set_for_one_wheel() {
    let (right, left) = ("robot.friction.right.coulomb_nm=20.0", "robot.friction.left.coulomb_nm=20.0");
    let both = "robot.friction.coulomb_nm=20.0";
    let all = [frames(&[]), frames(&[right]), frames(&[left]), frames(&[both])];
    for (index, one) in all.iter().enumerate() {
        assert!(!all[..index].contains(one), "run {index} is like another");
    }
    assert_eq!(frames(&[right, left]), all[3]);
}

#[test]
fn a_run_made_shorter_says_what_it_never_reached() {
    let rig = Rig::new();
    let run = rig.run("dac-friction", &["duration_s=2.0"]).expect_status(0);
    assert!(run.stdout.contains("from 30 s to 2 s: not reached"), "{}", run.stdout);
    let verdict = &rig.summary("runs")["expectations"][0];
    assert_eq!((&verdict["passed"], &verdict["worst"]), (&Value::Bool(true), &Value::Null));
    rig.write("short.toml", "base = \"dac-friction\"\nname = \"short\"\nduration_s = 2.0\n");
    rig.run("short.toml", &[]).expect_status(0);
}

#[test]
fn a_profile_lies_beside_the_file_that_names_it() {
    let rig = Rig::new();
    rig.write("robot/drive.toml", include_str!("../../dbc/wheel_drive.toml"));
    rig.write("robot/wheel_drive.dbc", include_str!("../../dbc/wheel_drive.dbc"));
    let text = "base = \"dac-friction\"\nname = \"own\"\nduration_s = 0.5\n[drive]\nprofile = \"drive.toml\"\n";
    rig.write("robot/own.toml", text);
    rig.run("robot/own.toml", &[]).expect_status(0);
    rig.run("dac-friction", &["duration_s=0.5", r#"drive.profile="robot/drive.toml""#]).expect_status(0);
}

#[test]
fn the_summary_has_every_figure_with_its_type() {
    let rig = Rig::new();
    rig.hil_sim(&["run", "dac-friction", "--set", "duration_s=31.0"]).expect_status(0);
    let summary = rig.summary("runs");
    assert_eq!(summary["scenario"], "dac-friction");
    assert_eq!(summary["seed"], 1);
    assert_eq!(summary["passed"], true);
    assert_eq!(summary["end"], "finished");
    assert_eq!(summary["simulated_s"], 31.0);
    assert_eq!(summary["ticks"], 6200);
    for pointer in [
        "/tracking/rms_m",
        "/tracking/max_m",
        "/tracking/final_m",
        "/tracking/final_heading_rad",
        "/tracking/max_after_30s_m",
        "/torque/max_nm",
        "/torque/chatter_nm",
        "/bus/load_percent",
    ] {
        assert!(number(&summary, pointer).is_finite(), "{pointer}");
    }
    assert_eq!(summary["bus"]["lost"], 0);
    assert!(summary["bus"]["frames"].as_u64().is_some_and(|frames| frames >= 5 * 6200));
    let hash = summary["frames_blake3"].as_str().expect("a hash");
    assert!(hash.len() == 64 && hash.bytes().all(|byte| byte.is_ascii_hexdigit()), "{hash}");
    let expectation = &summary["expectations"][0];
    assert_eq!(expectation["signal"], "position_error_m");
    assert_eq!((&expectation["from_s"], &expectation["max"]), (&30.0.into(), &0.01.into()));
    assert_eq!(expectation["passed"], true);
    assert!(number(&summary, "/expectations/0/worst") <= 0.01);
    assert!(number(&summary, "/expectations/0/worst_at_s") >= 30.0);
    assert!(summary["tracking"]["max_after_30s_m"].as_f64() <= summary["tracking"]["max_m"].as_f64());
}

#[test]
fn a_run_that_ends_before_30_s_has_no_error_after_it() {
    assert!(figures(&SHORT)["tracking"]["max_after_30s_m"].is_null());
}

#[test]
fn the_verdict_on_every_expectation_is_printed_and_decides_the_status() {
    let rig = Rig::new();
    let one = |bounds: &str| format!(r#"expect=[{{signal="position_error_m",from_s=0.1,until_s=0.4,{bounds}}}]"#);
    let run = rig.run("dac-friction", &[SHORT[0], &one("max=1.0")]).expect_status(0);
    assert!(run.stdout.contains("dac-friction: passed"), "{}", run.stdout);
    assert!(run.stdout.contains("position_error_m <= 1 from 0.1 s to 0.4 s: held, worst"), "{}", run.stdout);
    let run = rig.run("dac-friction", &[SHORT[0], &one("min=1.0")]).expect_status(1);
    assert!(run.stdout.contains("dac-friction: FAILED"), "{}", run.stdout);
    assert!(run.stdout.contains("position_error_m >= 1 from 0.1 s to 0.4 s: FAILED, worst"), "{}", run.stdout);
    let summary = rig.summary("runs");
    assert_eq!((&summary["passed"], &summary["expectations"][0]["passed"]), (&false.into(), &false.into()));
    assert!(number(&summary, "/expectations/0/worst_at_s") >= 0.1);
}

#[test]
fn a_signal_of_the_stack_can_be_expected_too() {
    let rig = Rig::new();
    let expect =
        r#"expect=[{signal="torque_sent_right_nm",max=90.0,min=-90.0},{signal="state",from_s=0.2,min=3,max=3}]"#;
    rig.run("dac-friction", &[SHORT[0], expect]).expect_status(0);
    assert_eq!(rig.summary("runs")["expectations"].as_array().map(Vec::len), Some(2));
}

#[test]
fn a_tripped_stack_is_a_finding() {
    let summary = figures(&[&SHORT[..], &["safety.following_error_rad=0.0001"]].concat());
    assert_eq!(summary["state"], "tripped");
    assert!(findings(&summary).contains("a wheel was too far from where it should be"), "{summary}");
}

#[test]
fn a_scenario_is_printed_as_one_file_that_runs_the_same() {
    let rig = Rig::new();
    let head = "base = \"dac-friction\"\nname = \"mine\"\nduration_s = 0.5\nexpect = []\n";
    rig.write("mine.toml", &format!("{head}[robot.load]\nmass_kg = 40.0\n"));
    let printed = rig.hil_sim(&["scenario", "mine.toml", "--set", "seed=7"]).expect_status(0).stdout;
    assert!(printed.contains("seed = 7") && printed.contains("mass_kg = 40.0"), "{printed}");
    assert!(!printed.contains("base"), "it is based on nothing any more:\n{printed}");
    rig.write("whole.toml", &printed);
    let hashes = ["mine.toml", "whole.toml"].map(|file| {
        rig.run(file, &["seed=7"]).expect_status(0);
        rig.summary("runs")["frames_blake3"].clone()
    });
    assert_eq!(hashes[0], hashes[1]);
    assert_eq!(rig.hil_sim(&["scenario", "no-such"]).expect_status(2).stdout, "");
}
