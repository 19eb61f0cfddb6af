//! python-can's own client of the protocol joins the bus unchanged.

mod tcp_bus;

use std::path::Path;
use std::process::{Command, Stdio};

use canloop::bus::Bus;
use canloop::frame::Frame;
use tcp_bus::{RunningHub, classic_frames, next_frame, numbered};

/// What the script sends when it has heard all.
const DONE: u16 = 0x7DF;

#[test]
fn frames_go_both_ways() {
    let hub = RunningHub::start();
    let mut ours = hub.join();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = Command::new(root.join("scripts/python"))
        .arg(root.join("tests/tcp_bus_joined_by_python_can.py"))
        .args([hub.address.port().to_string(), classic_frames().len().to_string()])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("scripts/python runs");

    let theirs: Vec<Frame> = classic_frames().iter().map(|_| next_frame(&mut ours)).collect();
    assert_eq!(theirs, classic_frames());
    for frame in classic_frames() {
        ours.send(&frame).expect("there is room");
    }
    assert_eq!(next_frame(&mut ours), numbered(DONE, classic_frames().len() as u32));

    let python = python.wait_with_output().expect("the script ends");
    let errors = String::from_utf8_lossy(&python.stderr).into_owned();
    assert!(python.status.success() && errors.is_empty(), "{errors}");
    // It prints what it heard, in candump's words.
    let heard = String::from_utf8_lossy(&python.stdout).into_owned();
    let sent: Vec<String> = classic_frames().iter().map(Frame::to_string).collect();
    assert_eq!(heard.lines().collect::<Vec<_>>(), sent);
    assert_eq!(hub.stop().0.malformed, 0);
}

#[test]
fn it_can_join_while_frames_fly() {
    let hub = RunningHub::start();
    let mut ours = hub.join();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut python = Command::new(root.join("scripts/python"))
        .arg(root.join("tests/tcp_bus_joined_by_python_can.py"))
        .args([hub.address.port().to_string(), "join".to_owned()])
        .spawn()
        .expect("scripts/python runs");
    let mut number = 0;
    let status = loop {
        // Bursts, so that one is always there right behind the answers.
        for _ in 0..20 {
            ours.send(&numbered(1, number)).expect("there is room");
            number += 1;
        }
        ours.receive(canloop::run::Clock::new().now() + canloop::time::Duration::from_millis(1))
            .expect("the bus works");
        if let Some(status) = python.try_wait().expect("the script runs") {
            break status;
        }
    };
    assert!(status.success(), "python-can did not get in");
    hub.stop();
}
