//! When one side dies, the other ends within its dead-man limit, says so, and
//! leaves a log that can be read. A controller that is asked to end says
//! goodbye first.

use std::path::Path;

use crate::rig::{Run, python};
use crate::two_programs::Bench;

/// Serves for as long as it takes.
const FOR_LONG: [&str; 2] = ["--set", "duration_s=1e5"];

/// A log of so many bytes is that of a robot under way.
const UNDER_WAY_BYTES: u64 = 300_000;

/// Kills the far side in the middle of a run; gives how the controller ended.
#[track_caller]
fn drive_after_its_far_side_was_killed(bench: &Bench) -> Run {
    let serve = bench.serve(&[["--no-log"].as_slice(), &FOR_LONG].concat());
    let mut drive = bench.drive(&["--log", "drive.mcap", "--dead-man-s", "1"]);
    drive.wait_for_bytes(&bench.rig.path("drive.mcap"), UNDER_WAY_BYTES);
    serve.signal("KILL");
    drive.finish().expect_status(1)
}

#[test]
fn a_killed_far_side_ends_the_controller_over_tcp() {
    let bench = Bench::over_tcp();
    let drive = drive_after_its_far_side_was_killed(&bench);
    assert!(drive.stdout.contains("is gone"), "{}", drive.stdout);
    assert_can_be_read(&bench.rig.path("drive.mcap"));
}

#[test]
#[ignore = "needs vcan0"]
fn a_killed_far_side_ends_the_controller_over_vcan() {
    let drive = drive_after_its_far_side_was_killed(&Bench::over_vcan());
    assert!(drive.stdout.contains("nothing came from the other side for 1 s"), "{}", drive.stdout);
}

/// Kills the controller in the middle of a run; gives how the far side ended.
#[track_caller]
fn serve_after_its_controller_was_killed(bench: &Bench) -> Run {
    let mut serve = bench.serve(&[["--dead-man-s", "1"].as_slice(), &FOR_LONG].concat());
    let drive = bench.drive(&[]);
    serve.wait_for_bytes(&bench.rig.path("runs/run.mcap"), UNDER_WAY_BYTES);
    drive.signal("KILL");
    let serve = serve.finish().expect_status(1);
    assert!(serve.stdout.contains("nothing came from the controller for 1 s"), "{}", serve.stdout);
    assert_eq!(bench.rig.summary("runs")["end"], "silent");
    serve
}

#[test]
fn a_killed_controller_ends_the_far_side_over_tcp() {
    let bench = Bench::over_tcp();
    serve_after_its_controller_was_killed(&bench);
    assert_can_be_read(&bench.rig.path("runs/run.mcap"));
}

#[test]
#[ignore = "needs vcan0"]
fn a_killed_controller_ends_the_far_side_over_vcan() {
    serve_after_its_controller_was_killed(&Bench::over_vcan());
}

#[test]
fn a_controller_that_is_asked_to_end_tells_both_drives_to_let_go() {
    for signal in ["INT", "TERM"] {
        let bench = Bench::over_tcp();
        let mut serve = bench.serve(&[["--dead-man-s", "1"].as_slice(), &FOR_LONG].concat());
        let drive = bench.drive(&[]);
        serve.wait_for_bytes(&bench.rig.path("runs/run.mcap"), UNDER_WAY_BYTES);
        drive.signal(signal);
        let drive = drive.finish().expect_status(0);
        assert!(drive.stdout.contains("the drives were told to let go"), "{}", drive.stdout);
        serve.finish().expect_status(1);
        let end = end_of_log(&bench.rig.path("runs/run.mcap"));
        // A last SYNC, which both drives answer, puts them into force.
        let last = ["RightCommand 0.0 Disable", "LeftCommand 0.0 Disable", "Sync - -"];
        assert_eq!(end[end.len() - 5..end.len() - 2], last, "{signal}: {end:?}");
    }
}

#[track_caller]
fn assert_can_be_read(log: &Path) {
    let end = end_of_log(log);
    assert!(end[0].parse::<u64>().expect("a count") > 1000, "{end:?}");
}

/// How many frames a log holds, and what the last ones say.
#[track_caller]
fn end_of_log(log: &Path) -> Vec<String> {
    python("real_bus/end_of_a_log.py", &[log]).lines().map(str::to_owned).collect()
}
