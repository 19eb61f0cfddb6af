//! A log of any kind is played onto a bus, frame for frame, no faster than it was
//! asked for.

mod tcp_bus;

use std::process::{Command, Output};
use std::time::{Duration, Instant};

use canloop::frame::{CanId, Frame};
use tcp_bus::{RunningHub, numbered};

const LOG: &str = "(1700000000.000000) can0 001#00000001\n(1700000000.200000) can1 003#00000003\n\
    (1700000000.100000) can0 002#00000002\n(1700000000.300000) can0 004#00000004\n";

fn play(log: &str, hub: &RunningHub, args: &[&str]) -> Output {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("drive.log"), log).expect("writable");
    let bus = format!("tcp://{}/can0", hub.address);
    let mut command = Command::new(env!("CARGO_BIN_EXE_canloop"));
    command.args(["replay", "drive.log", "--onto", &bus]).args(args).current_dir(&folder);
    command.output().expect("the program")
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[test]
fn the_frames_of_one_bus_are_played_in_their_order_as_often_as_wanted() {
    let hub = RunningHub::start();
    let output = play(LOG, &hub, &["--from-bus", "can0", "--loop", "2", "--speed", "10"]);
    assert!(output.status.success() && told(&output).contains("6 frames played"), "{}", told(&output));
    let once = [numbered(1, 1), numbered(2, 2), numbered(4, 4)];
    assert_eq!(hub.stop().1, [once, once].concat());
}

#[test]
#[allow(clippy::disallowed_methods, reason = "nothing may be played too early, however busy the machine is")]
fn nothing_is_played_before_it_is_due() {
    for (speed, at_least) in [("1", 0.3), ("0.5", 0.6)] {
        let (hub, began) = (RunningHub::start(), Instant::now());
        let output = play(LOG, &hub, &["--from-bus", "can0", "--speed", speed]);
        assert!(output.status.success(), "{}", told(&output));
        assert!(began.elapsed() >= Duration::from_secs_f64(at_least), "{:?} at speed {speed}", began.elapsed());
    }
}

#[test]
fn a_log_that_one_bus_is_to_be_chosen_of_says_so() {
    let hub = RunningHub::start();
    for (log, args, says) in [
        (LOG, ["--speed", "1"], "say with --from-bus which one"),
        (LOG, ["--from-bus", "can2"], "there is no bus \"can2\""),
        (LOG, ["--speed", "0"], "expected 0.001 to 1000"),
        ("nothing\n", ["--speed", "1"], "there is no frame to play"),
    ] {
        let output = play(log, &hub, &args);
        assert!(output.status.code() == Some(2) && told(&output).contains(says), "{}", told(&output));
    }
    let only: Vec<Frame> = hub.stop().1;
    assert!(only.iter().all(|frame| frame.id != CanId::Standard(3)) && only.is_empty());
}
