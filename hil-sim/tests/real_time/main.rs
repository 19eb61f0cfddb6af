//! By the clock, over a bus: the robot keeps to its path, nothing is lost, and
//! how punctual the loop was is written down. When the bus goes away the robot
//! stops, and does not move again by itself.
//!
//! These say nothing of how late anything may be: machines that run tests
//! differ. So the limits on lateness are wide, here and in the drives; and a
//! run that fails while the machine holds its loop up for whole periods, again
//! and again, says nothing of the robot, and is done again.

//!
//! They have a program of their own, and take turns in it, so that nothing else
//! that is tested keeps the machine busy meanwhile.

#![cfg(target_os = "linux")]

#[path = "../rig/mod.rs"]
mod rig;
#[path = "../real_bus/two_programs.rs"]
mod two_programs;
#[path = "../real_bus/with_can.rs"]
mod with_can;

use std::path::PathBuf;
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use crate::rig::{finish, number, python};
use crate::two_programs::{Bench, Running};
use crate::with_can::run_where_there_is;

static TURN: Mutex<()> = Mutex::new(());

/// Lateness that never trips.
const PATIENT: [&str; 6] = [
    "--set",
    "safety.overrun_periods=200",
    "--set",
    "safety.feedback_timeout_periods=1000",
    "--set",
    "safety.heartbeat_timeout_s=10.0",
];

/// A profile whose drives wait for their commands for a second.
fn patient_profile(bench: &Bench) -> [String; 2] {
    let dbc = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../dbc");
    let text = std::fs::read_to_string(dbc.join("wheel_drive.toml")).expect("the shipped profile");
    let patient = text.replace("\nperiods = 4\n", "\nperiods = 200\n");
    assert_ne!(text, patient);
    bench.rig.write("patient.toml", &patient);
    std::fs::copy(dbc.join("wheel_drive.dbc"), bench.rig.path("wheel_drive.dbc")).expect("the folder is writable");
    ["--set".to_owned(), format!("drive.profile=\"{}\"", bench.rig.path("patient.toml").display())]
}

fn serve(bench: &Bench, args: &[&str]) -> Running {
    let profile = patient_profile(bench);
    let profile = profile.each_ref().map(String::as_str);
    bench.serve(&[["--time", "wall"].as_slice(), &profile, args].concat())
}

fn drive(bench: &Bench, args: &[&str]) -> Running {
    let profile = patient_profile(bench);
    let profile = profile.each_ref().map(String::as_str);
    bench.drive_in_real_time(&[&PATIENT, profile.as_slice(), args].concat())
}

/// Tries a machine gets to be punctual once.
const TRIES: usize = 5;

/// A controller that is asked to end when its bus is still there ends with 0;
/// one whose server went away, with 1.
#[track_caller]
fn assert_the_path_is_kept_to(bench: impl Fn() -> Bench, ends_with: i32) {
    let was_punctual = (0..TRIES).any(|_| the_path_is_kept_to(&bench(), ends_with));
    assert!(was_punctual, "the machine is too busy: it held the loop up in {TRIES} tries");
}

/// False when it was not, and the machine had held the loop up, which proves
/// nothing.
#[track_caller]
fn the_path_is_kept_to(bench: &Bench, ends_with: i32) -> bool {
    let expect = "expect=[{signal=\"position_error_m\", from_s=2.0, until_s=10.0, max=0.1}]";
    let serve = serve(bench, &["--set", "duration_s=10", "--set", expect]);
    let mut drive = drive(bench, &["--duration-s", "600", "--summary", "drive.json", "--log", "drive.mcap"]);
    let serve = serve.finish();
    drive.signal("INT");
    if ends_with == 0 {
        // There are no drives left to brake with: once more lets go at once.
        drive.wait_until("it brakes", |drive| drive.told().contains("braking to rest"));
        drive.signal("INT");
    }
    let drive = drive.finish();
    let stack = crate::rig::read_json(&bench.rig.path("drive.json"));
    let held = serve.status == Some(0) && drive.status == Some(ends_with);
    if !held && was_held_up(&stack) {
        return false;
    }
    serve.expect_status(0);
    let drive = drive.expect_status(ends_with);
    assert!(drive.stdout.contains("loop, us") && drive.stdout.contains("lateness"), "{}", drive.stdout);
    let robot = bench.rig.summary("runs");
    assert_eq!(number(&robot, "/simulated_s"), 10.0);
    assert!(number(&robot, "/torque/max_nm") > 50.0, "it broke loose: {robot}");
    assert_eq!((number(&robot, "/bus/lost"), number(&stack, "/bus/lost")), (0.0, 0.0));
    assert!(number(&stack, "/loop/periods") >= 1990.0, "{stack}");
    for histogram in ["lateness", "jitter", "round_trip", "compute"] {
        let at = |key: &str| number(&stack, &format!("/loop/{histogram}/{key}"));
        let spread = [at("p50_us"), at("p99_us"), at("p999_us"), at("max_us")];
        assert!(spread.is_sorted() && spread[3] > 0.0, "{histogram}: {spread:?}");
    }
    let log = bench.rig.path("drive.mcap");
    python("real_time/loop_is_logged.py", &[&log]);
    // With all its jitter.
    let replayed = finish(Command::new(two_programs::canloop()).arg("replay").arg(&log)).expect_status(0);
    assert!(replayed.stdout.contains("the same, bit for bit"), "{}", replayed.stdout);
    true
}

/// Whether a loop of 5 ms began often half a period late, or waited in vain for
/// drives that did.
fn was_held_up(stack: &serde_json::Value) -> bool {
    let missed = number(stack, "/loop/missed") / number(stack, "/loop/periods").max(1.0);
    number(stack, "/loop/lateness/p99_us") > 2500.0 || missed > 0.05
}

#[test]
fn all_of_it_holds_on_the_kernels_virtual_bus() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    run_where_there_is("with-vcan", "over_vcan");
}

#[test]
fn the_path_is_kept_to_over_tcp() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    assert_the_path_is_kept_to(Bench::over_tcp, 1);
}

#[test]
#[ignore = "needs vcan0"]
fn the_path_is_kept_to_over_vcan() {
    assert_the_path_is_kept_to(Bench::over_vcan, 0);
}

#[test]
#[ignore = "needs vcan0"]
fn an_interface_that_goes_down_and_up_again_stops_the_robot_for_good_over_vcan() {
    let bench = Bench::over_vcan();
    let mut serve = serve(&bench, &["--set", "duration_s=1e4", "--dead-man-s", "3"]);
    let drive = drive(&bench, &["--log", "drive.mcap", "--summary", "drive.json"]);
    serve.wait_for_bytes(&bench.rig.path("runs/run.mcap"), 300_000);
    set_link("down");
    let drive = drive.finish().expect_status(1);
    assert!(drive.stdout.contains("tripped: the bus went away"), "{}", drive.stdout);
    set_link("up");
    let summary = crate::rig::read_json(&bench.rig.path("drive.json"));
    assert_eq!((&summary["end"], &summary["state"]), (&"tripped".into(), &"tripped".into()));
    python("real_bus/stays_tripped.py", &[&bench.rig.path("drive.mcap")]);
    // The far side is back on the bus, and nobody moves its robot.
    serve.finish().expect_status(1);
    assert_eq!(bench.rig.summary("runs")["end"], "silent");
}

fn set_link(state: &str) {
    let set = finish(Command::new("ip").args(["link", "set", "dev", "vcan0", state]));
    set.expect_status(0);
}
