//! `canloop doctor` tells what this machine, and a bus, allow a control loop.
#![cfg(target_os = "linux")]

mod tcp_bus;

use std::process::{Command, Output};

use serde_json::Value;
use tcp_bus::RunningHub;

const PROGRAM: &str = env!("CARGO_BIN_EXE_canloop");

fn doctor(arguments: &[&str]) -> Output {
    Command::new(PROGRAM).arg("doctor").args(arguments).output().expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("text")
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// The check of that name; there is one.
#[track_caller]
fn check<'a>(report: &'a Value, name: &str) -> &'a Value {
    let checks = report["checks"].as_array().expect("a list");
    checks.iter().find(|check| check["name"] == name).unwrap_or_else(|| panic!("no {name} in {report}"))
}

#[test]
fn without_a_bus_nothing_is_missing() {
    let output = doctor(&["--quick"]);
    let shown = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{shown}");
    for name in ["kernel", "clock source", "SCHED_FIFO", "locked memory", "timer slack", "CPU governor"] {
        let line = shown.lines().find(|line| line.starts_with(name));
        let line = line.unwrap_or_else(|| panic!("no {name} in\n{shown}"));
        assert!(line.contains("  OK  ") || line.contains("  degraded  "), "{line}");
    }
    assert!(shown.contains(" 0 missing"), "{shown}");
}

#[test]
fn each_line_that_is_not_ok_is_followed_by_a_command() {
    let shown = text(&doctor(&["--quick", "--bus", "nocan7"]).stdout);
    let lines: Vec<_> = shown.lines().take_while(|line| !line.is_empty()).collect();
    for pair in lines.windows(2) {
        let is_wrong = pair[0].contains("  degraded  ") || pair[0].contains("  missing  ");
        assert_eq!(pair[1].trim_start().starts_with("$ "), is_wrong, "{shown}");
    }
}

#[test]
fn an_interface_that_is_not_there_is_missing_and_the_status_is_1() {
    let output = doctor(&["--quick", "--json", "--bus", "nocan7"]);
    assert_eq!(output.status.code(), Some(1));
    let report = json(&output);
    assert_eq!(report["outcome"], "missing");
    assert_eq!(check(&report, "interface")["outcome"], "missing");
    // Where a bus of the kernel is wanted, a kernel without CAN is no detail.
    assert_ne!(check(&report, "kernel CAN")["outcome"], "degraded");
}

#[test]
fn an_interface_of_another_kind_is_missing_too() {
    let output = doctor(&["--quick", "--json", "--bus", "lo"]);
    assert_eq!(output.status.code(), Some(1));
    let report = json(&output);
    let found = check(&report, "interface")["found"].as_str().expect("text");
    assert!(found.contains("lo is no CAN interface"), "{found}");
}

#[test]
fn a_virtual_interface_that_is_up_is_all_right() {
    let with_vcan = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/with-vcan");
    let mut command = Command::new(with_vcan);
    let output = command.args([PROGRAM, "doctor", "--quick", "--json", "--bus", "vcan0"]).output().expect("bash");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let report = json(&output);
    for name in ["kernel CAN", "interface", "time stamps", "error counts"] {
        assert_eq!(check(&report, name)["outcome"], "ok", "{report}");
    }
}

#[test]
fn a_bus_of_a_server_is_joined_and_timed() {
    let hub = RunningHub::start();
    let output = doctor(&["--quick", "--json", "--bus", &format!("tcp://{}/can0", hub.address)]);
    assert_eq!(output.status.code(), Some(0));
    let report = json(&output);
    let found = check(&report, "bus server")["found"].as_str().expect("text");
    assert!(found.contains("joined in") && found.contains(" us"), "{found}");

    let output = doctor(&["--quick", "--json", "--bus", &format!("tcp://{}/can7", hub.address)]);
    assert_eq!(output.status.code(), Some(1));
    let report = json(&output);
    let found = check(&report, "bus server")["found"].as_str().expect("text");
    assert!(found.contains("does not open `can7`"), "{found}");
    let (_, heard) = hub.stop();
    assert!(heard.is_empty(), "looking at a bus sends nothing on it");
}

#[test]
fn a_server_that_nobody_runs_is_missing() {
    let output = doctor(&["--quick", "--bus", "tcp://127.0.0.1:1/can0"]);
    assert_eq!(output.status.code(), Some(1));
    let shown = text(&output.stdout);
    assert!(shown.contains("bus server") && shown.contains("nobody listens there"), "{shown}");
}

#[test]
fn wake_ups_are_measured_for_as_long_as_asked() {
    let report = json(&doctor(&["--json", "--seconds", "0.25"]));
    let wake_ups = &report["wake_ups"];
    assert_eq!(wake_ups["count"], 250);
    let figure = |name: &str| wake_ups[name].as_f64().expect("a number");
    assert!(figure("p50_us") <= figure("p99_us") && figure("p99_us") <= figure("max_us"), "{wake_ups}");
    assert!(figure("fine_from_period_ms") >= figure("max_us") / 100.0, "{wake_ups}");
}

#[test]
fn bad_input_is_refused_before_anything_is_looked_at() {
    for (arguments, expected) in [
        (&["--bus", "can 0"][..], "is no bus"),
        (&["--bus", "udp://127.0.0.1/can0"], "is no bus"),
        (&["--bus", "tcp://127.0.0.1:29536"], "no `/NAME`"),
        (&["--bus", "tcp-listen://127.0.0.1:29536/can0"], "yet to be served"),
        (&["--seconds", "0"], "expected 0.01 to 3600"),
        (&["--seconds", "nan"], "expected 0.01 to 3600"),
        (&["--seconds", "1", "--quick"], "cannot be used with"),
    ] {
        let output = doctor(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
        let message = text(&output.stderr);
        assert!(message.contains(expected), "{arguments:?}: {message}");
    }
}
