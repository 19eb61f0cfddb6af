//! A log has all that it takes to let the stack do the same again, bit for bit;
//! and to see what it would have done otherwise.

#[path = "../rig/mod.rs"]
mod rig;
#[path = "../real_bus/two_programs.rs"]
mod two_programs;

use std::process::Command;

use rig::{Rig, Run, finish, python};

fn replay(rig: &Rig, args: &[&str]) -> Run {
    finish(Command::new(two_programs::canloop()).arg("replay").args(args).current_dir(rig.path("")))
}

/// The log of a short run in which the wheels have broken loose.
fn logged() -> Rig {
    let rig = Rig::new();
    rig.hil_sim(&["run", "brisk", "--no-report", "--set", "duration_s=3", "--set", "expect=[]"]).expect_status(0);
    rig
}

#[test]
fn every_shipped_scenario_is_replayed_bit_for_bit() {
    let rig = Rig::new();
    let names = rig.hil_sim(&["run", "--list"]).expect_status(0).stdout;
    let names: Vec<&str> = names.lines().collect();
    rig.hil_sim(&[["run", "--no-report"].as_slice(), &names].concat()).expect_status(0);
    for name in names {
        let summary = rig.summary(&format!("runs/{name}"));
        let run = replay(&rig, &[&format!("runs/{name}/run.mcap")]);
        if summary["link"] == "ideal" {
            // No frame was sent, so there is nothing that a stack was given.
            assert!(run.expect_status(2).stderr.contains("does not say what went into a stack"), "{name}");
            continue;
        }
        let run = run.expect_status(0);
        let periods = format!("periods          {}", summary["ticks"].as_u64().expect("a number") + 1);
        assert!(
            run.stdout.contains("the same, bit for bit") && run.stdout.contains(&periods),
            "{name}: {}",
            run.stdout
        );
    }
}

#[test]
fn a_flipped_bit_is_found_in_its_period() {
    let rig = logged();
    for nth in ["100", "1001"] {
        let args = [rig.path("runs/run.mcap"), rig.path("flipped.mcap"), nth.into()];
        let tick = python("replay_of_a_log/flip_a_bit.py", &args.each_ref().map(std::path::PathBuf::as_path));
        let run = replay(&rig, &["flipped.mcap"]).expect_status(1);
        let found = run.stdout.lines().find_map(|line| line.trim().strip_prefix("first difference tick "));
        let found = found.and_then(|rest| rest.split(',').next()).unwrap_or_default();
        // A frame that is refused for its CRC is missed when the next period begins.
        let tick: u64 = tick.trim().parse().expect("a period");
        assert!([tick, tick + 1].map(|tick| tick.to_string()).contains(&found.to_owned()), "{tick}: {}", run.stdout);
    }
}

#[test]
fn a_changed_gain_is_told_with_the_first_tick_it_matters_in() {
    let rig = logged();
    let log = "runs/run.mcap";
    let run = replay(&rig, &[log, "--set", "controller.kp_per_s2=0.7", "--report", "replay.html"]).expect_status(1);
    let row = run.stdout.lines().find(|line| line.contains("torque_wanted_right_nm")).expect("it deviates");
    // At the first tick of the path there is no error that a gain could be for.
    let columns: Vec<&str> = row.split_whitespace().collect();
    let first: u64 = columns[1].parse().expect("a tick");
    assert!((1..10).contains(&first), "{row}: the drives are enabled within a few periods");
    assert!(!run.stdout.contains("odometry"), "the robot did what it did: {}", run.stdout);
    let page = std::fs::read_to_string(rig.path("replay.html")).expect("a page");
    assert!(page.contains("<svg") && page.contains("torque_wanted_right_nm"));

    let wide =
        ["torque_wanted_right_nm=9", "torque_wanted_left_nm=9", "torque_sent_right_nm=9", "torque_sent_left_nm=9"];
    let mut args = vec![log, "--set", "controller.kp_per_s2=0.7"];
    wide.iter().for_each(|one| args.extend(["--tolerance", one]));
    let run = replay(&rig, &args).expect_status(0);
    assert!(run.stdout.contains("within their tolerances"), "{}", run.stdout);
    // The same gain with the same configuration.
    rig.write("same.toml", &rig.hil_sim(&["scenario", "brisk"]).expect_status(0).stdout);
    assert!(replay(&rig, &[log, "--config", "same.toml"]).expect_status(0).stdout.contains("no signal differs"));
}

#[test]
fn a_log_that_was_cut_off_is_replayed_as_far_as_it_goes() {
    let rig = logged();
    let whole = std::fs::read(rig.path("runs/run.mcap")).expect("a log");
    std::fs::write(rig.path("cut.mcap"), &whole[..whole.len() * 2 / 3]).expect("the folder is writable");
    let run = replay(&rig, &["cut.mcap"]).expect_status(0);
    assert!(run.stdout.contains("bit for bit") && run.stdout.contains("never ended"), "{}", run.stdout);
}

#[test]
fn what_is_no_log_of_a_stack_is_refused() {
    let rig = logged();
    rig.write("empty.mcap", "");
    rig.write("text.mcap", "(0.0) can0 123#00\n");
    let whole = std::fs::read(rig.path("runs/run.mcap")).expect("a log");
    std::fs::write(rig.path("head.mcap"), &whole[..40]).expect("the folder is writable");
    let log = "runs/run.mcap";
    let cases: [(&[&str], &str); 7] = [
        (&["empty.mcap"], "does not begin as an MCAP file does"),
        (&["text.mcap"], "does not begin as an MCAP file does"),
        (&["head.mcap"], "found nothing attached to it"),
        (&["none.mcap"], "cannot read none.mcap"),
        (&[log, "--tolerance", "torque_sent_rigt_nm=1"], "did you mean `torque_sent_right_nm`?"),
        (&[log, "--tolerance", "state=-1"], "expected a number from 0 on"),
        (&[log, "--set", "controller.kp_per_s2=-1"], "controller.kp_per_s2"),
    ];
    for (args, says) in cases {
        let run = replay(&rig, args).expect_status(2);
        assert!(run.stderr.contains(says), "{args:?}: {}", run.stderr);
    }
}
