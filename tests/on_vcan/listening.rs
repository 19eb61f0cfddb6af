//! Who listens to a bus hears everything on it, and a log keeps it.

use std::path::Path;
use std::process::{Command, Stdio};

use canloop::bus::{Arrival, Bus as _, OpenOptions};
use canloop::frame::{CanId, Frame, FrameKind};
use canloop::traffic::{self, Content, Direction, ErrorFrame};

use crate::rig::{Vcan, drain, numbered, open_with};

/// Two buses of 1 Mbit/s bring some 17 000 of the shortest frames a second.
const FLOOD: u32 = 10_000;

#[test]
#[ignore = "needs a kernel with CAN"]
fn a_listener_hears_error_frames_and_who_sent_what() {
    let vcan = Vcan::new("listen0");
    let mut ears = open_with(vcan.0, &OpenOptions { listens: true, ..OpenOptions::default() });
    let mut other = vcan.open();
    let mut fd = Frame::zeroed(CanId::Extended(0x123), 64);
    fd.kind = FrameKind::FdBitRateSwitch;
    for frame in [numbered(1, 7), fd] {
        other.send(&frame).unwrap();
    }
    let sent = Command::new("cansend").args([vcan.0, "20000004#0010000000006000"]).status().expect("can-utils");
    assert!(sent.success());
    let error = ErrorFrame { class: 0x004, data: [0, 0x10, 0, 0, 0, 0, 0x60, 0] };
    let heard = drain(&mut ears);
    let expected = [
        Arrival::Heard(Direction::Sent, Content::Frame(numbered(1, 7).into())),
        Arrival::Heard(Direction::Sent, Content::Frame(fd.into())),
        Arrival::Heard(Direction::Received, Content::Error(error)),
    ];
    assert_eq!(
        heard.iter().filter(|arrival| !matches!(arrival, Arrival::State(_))).copied().collect::<Vec<_>>(),
        expected
    );
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn a_log_of_two_full_buses_loses_nothing() {
    let vcans = [Vcan::new("log0"), Vcan::new("log1")];
    let mut buses = vcans.each_ref().map(Vcan::open);
    let path = std::env::temp_dir().join("two-full-buses.mcap");
    let mut logging = Command::new(env!("CARGO_BIN_EXE_canloop"));
    logging.args(["log", "--bus", "log0", "--bus", "log1", "-o"]).arg(&path);
    let logging = logging.stdout(Stdio::piped()).spawn().expect("the program");
    while !listens_to("log1") {
        drain(&mut buses[0]);
    }
    for number in 0..FLOOD {
        buses.iter_mut().for_each(|bus| bus.send(&numbered(1, number)).unwrap());
    }
    drain(&mut buses[0]);
    // The processor may be one, and have been ours alone until now.
    while counted(&path) < 2 * FLOOD as usize && listens_to("log1") {
        drain(&mut buses[0]);
    }
    assert!(Command::new("kill").args(["-INT", &logging.id().to_string()]).status().unwrap().success());
    let ended = logging.wait_with_output().unwrap();
    let told = String::from_utf8_lossy(&ended.stdout);
    assert!(ended.status.success(), "{told}");
    for bus in ["log0", "log1"] {
        let expected = format!("{bus}: {FLOOD} frames, 0 error frames, 0 lost on the way, 0 lost here");
        assert!(told.contains(&expected), "{told}");
    }
    assert_eq!(counted(&path), 2 * FLOOD as usize);
    let _ = std::fs::remove_file(&path);
}

/// Whether somebody but us has a socket on an interface.
fn listens_to(interface: &str) -> bool {
    let listed = std::fs::read_to_string("/proc/net/can/rcvlist_all").unwrap();
    listed.lines().filter(|line| line.trim_start().starts_with(interface)).count() > 1
}

/// Frames in a log, as far as it goes.
fn counted(path: &Path) -> usize {
    let Ok((_, reader)) = traffic::open(path, None) else { return 0 };
    reader.take_while(Result::is_ok).filter(|item| item.as_ref().is_ok_and(|record| record.frame().is_some())).count()
}
