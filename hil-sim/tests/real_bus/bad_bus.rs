//! A bus that cannot be had is refused with one clear message and status 2,
//! and leaves nothing behind.

use std::io::Write;
use std::net::TcpListener;
use std::path::Path;

use crate::rig::{Rig, Run, finish};
use crate::two_programs::{canloop, free_port};

#[track_caller]
fn assert_refused(rig: &Rig, run: Run, words: &[&str]) {
    let run = run.expect_status(2);
    assert_eq!(run.stdout, "");
    assert_eq!(run.stderr.matches("error: ").count(), 1, "one message, please:\n{}", run.stderr);
    for word in words {
        assert!(run.stderr.contains(word), "the message should say {word:?}:\n{}", run.stderr);
    }
    assert!(rig.files().is_empty(), "left behind: {:?}", rig.files());
}

#[track_caller]
fn serve_is_refused(args: &[&str], words: &[&str]) {
    let rig = Rig::new();
    let run = rig.hil_sim(&[["serve"].as_slice(), args].concat());
    assert_refused(&rig, run, words);
}

#[track_caller]
fn drive_is_refused(args: &[&str], words: &[&str]) {
    let rig = Rig::new();
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/dac-friction.toml");
    let mut command = std::process::Command::new(canloop());
    command.args(["drive", "--config", config, "--log", "drive.mcap"]).args(args).current_dir(rig.path(""));
    assert_refused(&rig, finish(&mut command), words);
}

/// Both programs, with that bus.
#[track_caller]
fn both_are_refused(bus: &str, words: &[&str]) {
    serve_is_refused(&["dac-friction", "--bus", bus], words);
    drive_is_refused(&["--bus", bus], words);
}

#[test]
fn an_address_that_is_none_is_refused_with_the_forms_there_are() {
    for bus in ["", "udp://127.0.0.1/can0", "/dev/ttyUSB0", "can 0"] {
        both_are_refused(bus, &["is no bus", "can0", "tcp://HOST:PORT/NAME", "tcp-listen://HOST:PORT/NAME"]);
    }
    both_are_refused("tcp://127.0.0.1:29536", &["127.0.0.1:29536", "/NAME"]);
    both_are_refused("tcp://127.0.0.1:70000/can0", &["70000"]);
}

#[test]
fn a_kernel_without_can_is_named_as_the_reason() {
    // Asking for an interface loads the modules where there are any.
    both_are_refused("nocan7", &[]);
    let has_can = Path::new("/proc/net/can").exists();
    let reason = if has_can { "there is no interface nocan7" } else { "this kernel has no CAN sockets" };
    both_are_refused("nocan7", &[reason, if has_can { "" } else { "scripts/with-vcan" }]);
}

#[test]
#[ignore = "needs vcan0"]
fn an_interface_that_does_not_exist_is_refused_over_vcan() {
    both_are_refused("nocan7", &["there is no interface nocan7"]);
}

#[test]
#[ignore = "needs can0 at 500 kbit/s"]
fn an_interface_with_another_bit_rate_is_refused_with_both_over_a_card() {
    let slower = ["--bus", "can0", "--set", "bus.bitrate_bit_s=250000"];
    serve_is_refused(&[["dac-friction"].as_slice(), &slower].concat(), &["can0", "500000", "250000"]);
    drive_is_refused(&slower, &["can0", "500000", "250000"]);
}

#[test]
fn a_server_that_is_not_there_is_refused() {
    let port = free_port();
    both_are_refused(&format!("tcp://127.0.0.1:{port}/can0"), &["127.0.0.1", &port.to_string(), "hil-sim serve"]);
}

#[test]
fn a_server_that_speaks_something_else_is_refused() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("there are free ports");
    let address = listener.local_addr().expect("it is bound");
    std::thread::spawn(move || {
        for client in listener.incoming() {
            let _ = client.and_then(|mut client| client.write_all(b"HTTP/1.1 400 Bad Request\r\n\r\n"));
        }
    });
    both_are_refused(&format!("tcp://{address}/can0"), &[&address.to_string(), "socketcand"]);
}

#[test]
fn a_port_in_use_is_refused() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("there are free ports");
    let address = listener.local_addr().expect("it is bound");
    let words = [&format!("another program uses port {}", address.port()), "take another port"];
    serve_is_refused(&["dac-friction", "--bus", &format!("tcp-listen://{address}/can0")], &words);
}

#[test]
fn a_bus_that_other_machines_could_reach_has_to_be_asked_for() {
    let bus = format!("tcp-listen://0.0.0.0:{}/can0", free_port());
    serve_is_refused(&["dac-friction", "--bus", &bus], &["other machines", "--allow-others"]);
}

#[test]
fn a_scenario_without_a_bus_cannot_be_served() {
    serve_is_refused(&["dac-ideal", "--bus", "vcan0"], &["dac-ideal", "ideal", "bus.link"]);
}

#[test]
fn a_nonsensical_limit_is_refused() {
    for limit in ["0", "-1", "nan", "inf", "1e9"] {
        let limit = format!("--dead-man-s={limit}");
        serve_is_refused(&["dac-friction", "--bus", "vcan0", &limit], &["--dead-man-s", "expected 0.001 to 86400"]);
        drive_is_refused(&["--bus", "vcan0", &limit], &["--dead-man-s", "expected 0.001 to 86400"]);
    }
}

#[test]
fn a_robot_that_cannot_be_read_is_refused_before_the_bus_is_asked_for() {
    drive_is_refused(&["--bus", "nocan7", "--set", "robot.mass_kg=-1"], &["robot.mass_kg", "found -1"]);
}
