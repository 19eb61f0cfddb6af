//! The same scenario and seed give the same frames on every bus, for the same
//! stack: in one process, and in two with a real bus between them.

use crate::rig::number;
use crate::two_programs::Bench;

const FOR_20_S: [&str; 2] = ["--set", "duration_s=20"];

#[track_caller]
fn assert_same_frames(bench: &Bench) {
    assert_same_frames_with(bench, &[]);
}

#[track_caller]
fn assert_same_frames_with(bench: &Bench, overrides: &[&str]) {
    let for_20_s = [&FOR_20_S[..], overrides].concat();
    bench.rig.hil_sim(&[["run", bench.scenario(), "--no-log", "--out", "memory"].as_slice(), &for_20_s].concat());
    let serve = bench.serve(&[["--no-log", "--out", "bus"].as_slice(), &for_20_s].concat());
    let drive = bench.drive(&for_20_s).finish().expect_status(0);
    assert!(drive.stdout.contains("the other side ended the run"), "{}", drive.stdout);
    serve.finish().expect_status(0);
    let (memory, bus) = (bench.rig.summary("memory"), bench.rig.summary("bus"));
    assert_eq!(number(&bus, "/simulated_s"), 20.0);
    assert!(number(&bus, "/bus/frames") > 3_000.0, "the drives were driven");
    assert_eq!(bus["frames_blake3"], memory["frames_blake3"]);
    if bench.scenario() == "dac-friction" {
        assert_eq!(bus["tracking"], memory["tracking"]);
    }
    // Where drives do not tell at once that they are enabled, the far side
    // knows only from the first torque, to a few periods, when the path began.
    let difference_m = number(&bus, "/tracking/final_m") - number(&memory, "/tracking/final_m");
    assert!(difference_m.abs() < 0.02, "{difference_m}");
}

#[test]
fn over_tcp() {
    assert_same_frames(&Bench::over_tcp());
}

#[test]
fn over_tcp_with_every_kind_of_drive() {
    for scenario in ["rough-ride", "cia402", "odrive-0.6", "odrive-0.5", "vesc", "damiao-dm4310", "comma-body"] {
        assert_same_frames(&Bench::over_tcp().of(scenario));
    }
}

#[test]
fn over_tcp_with_a_robot_s_own_node_ids_and_mode() {
    let mode_4 = r#"drive.constants.Mode_Of_Operation="ProfileTorque""#;
    let overrides = ["--set", "drive.node_ids={right=5,left=6}", "--set", mode_4];
    assert_same_frames_with(&Bench::over_tcp().of("cia402"), &overrides);
    let swapped = ["--set", "drive.node_ids={right=12,left=3}"];
    assert_same_frames_with(&Bench::over_tcp().of("odrive-0.6"), &swapped);
}

#[test]
#[ignore = "needs vcan0"]
fn over_vcan() {
    assert_same_frames(&Bench::over_vcan());
}

#[test]
#[ignore = "needs can0 and can1 on one bus"]
fn over_a_card() {
    assert_same_frames(&Bench::over_two_cards());
}
