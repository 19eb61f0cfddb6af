//! The log of a run holds every frame that crossed the bus, what each one
//! means, and what it takes to understand it, for readers that others wrote.

mod rig;

use rig::{Rig, number, python};

#[test]
fn independent_readers_find_every_frame_and_every_value_of_the_run() {
    let rig = Rig::new();
    let overrides = ["duration_s=3.0", "expect=[]", "seed=7", "robot.load.mass_kg=81"];
    let mut args = vec!["run", "dac-friction"];
    overrides.iter().for_each(|set| args.extend(["--set", set]));
    rig.hil_sim(&args).expect_status(0);
    let summary = rig.summary("runs");
    assert_eq!(summary["ticks"], 600);
    let out = python("log_of_a_run.py", &[&rig.path("runs")]);
    assert_eq!(out.trim(), format!("{} frames", number(&summary, "/bus/frames")));
}

#[test]
fn a_log_changes_nothing_in_the_run() {
    let (with, without) = (Rig::new(), Rig::new());
    let short = ["--set", "duration_s=1.0", "--set", "expect=[]"];
    with.hil_sim(&[&["run", "dac-friction"][..], &short].concat()).expect_status(0);
    without.hil_sim(&[&["run", "dac-friction", "--no-log"][..], &short].concat()).expect_status(0);
    assert_eq!(with.summary("runs")["frames_blake3"], without.summary("runs")["frames_blake3"]);
    assert!(without.summary("runs")["log"].is_null());
}
