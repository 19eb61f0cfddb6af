//! python-can's own client of the protocol joins the bus unchanged.

mod tcp_bus;

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};

use canloop::bus::Bus;
use canloop::frame::Frame;
use canloop::run::Clock;
use canloop::time::Duration;
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
        ours.receive(Clock::new().now() + Duration::from_millis(1)).expect("the bus works");
        if let Some(status) = python.try_wait().expect("the script runs") {
            break status;
        }
    };
    assert!(status.success(), "python-can did not get in");
    hub.stop();
}

/// python-can refuses an answer that has a frame right behind it.
#[test]
fn the_last_answer_comes_alone() {
    let hub = RunningHub::start();
    let mut ours = hub.join();
    let clock = Clock::new();
    let answers_in_time = (0..20).filter_map(|number| {
        let mut client = TcpStream::connect(hub.address).expect("the hub listens");
        assert_eq!(read(&mut client), "< hi >");
        client.write_all(b"< open can0 >").expect("the hub reads");
        assert_eq!(read(&mut client), "< ok >");
        let start = clock.now();
        client.write_all(b"< rawmode >").expect("the hub reads");
        let end = start + Duration::from_millis(20);
        while clock.now() < end {
            ours.send(&numbered(1, number)).expect("there is room");
            assert!(matches!(ours.receive(clock.now() + Duration::from_millis(1)), Ok(None)));
        }
        let answer = read(&mut client);
        // On a busy machine our own reading may come too late to tell.
        (clock.now() - start < Duration::from_millis(80)).then(|| (answer, read(&mut client)))
    });
    let (answer, next) = answers_in_time.take(1).next().expect("one of the answers is read in time");
    assert_eq!(answer, "< ok >");
    assert!(next.starts_with("< frame 001 "), "what was kept back comes: {next}");
    hub.stop();
}

fn read(stream: &mut TcpStream) -> String {
    let mut bytes = [0; 256];
    let count = stream.read(&mut bytes).expect("the hub speaks");
    String::from_utf8_lossy(&bytes[..count]).into_owned()
}
