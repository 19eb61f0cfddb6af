//! A log that is killed has every frame that is older than a chunk.

use std::time::Duration;

use canloop::frame::{CanId, Frame};

use crate::rig::{Logging, frames_in, send};
use crate::tcp_bus::RunningHub;

const TIMES: u32 = 50;
/// Frames of 8 bytes with their stamps, names and heads that make a chunk of half
/// a mebibyte, and a few more.
const CHUNK_FRAMES: usize = 8000;

#[test]
fn fifty_times_killed_at_any_moment() {
    let hub = RunningHub::start();
    for time in 0..TIMES {
        let mut logging = Logging::start(&[(&hub, "can0")], &[]);
        let (mut sender, before) = (hub.join(), hub.passed_on());
        // From before the first chunk is full to behind the fifth.
        let frames = 500 + time as usize * 800;
        for number in 0..frames as u32 {
            let noise = number.wrapping_mul(2_654_435_761).to_be_bytes();
            send(&mut sender, &Frame::classic(CanId::Standard(1), &[number.to_be_bytes(), noise].concat()));
        }
        // Far more frames come at once than a bus carries: what is kept is looked at
        // once the program has nothing left to do.
        wait_until_all_is_heard(&hub, before + frames, &logging);
        logging.kill();
        logging.repair("bus.mcap");
        let numbers = frames_in(&logging.path("bus.mcap")).numbers("can0");
        assert_eq!(numbers, (0..numbers.len() as u32).collect::<Vec<_>>(), "none is missing in between");
        assert!(numbers.len() + CHUNK_FRAMES >= frames, "{} of {frames} frames", numbers.len());
    }
}

/// Waits until this server has passed on so many frames, nothing is left in the
/// buffers of its connections, and no thread of the logging program is at work.
#[allow(clippy::disallowed_methods, reason = "another program is waited for")]
fn wait_until_all_is_heard(hub: &RunningHub, frames: usize, logging: &Logging) {
    let at_port = format!(":{:04X}", hub.address.port());
    let is_empty = || {
        let sockets = std::fs::read_to_string("/proc/net/tcp").expect("Linux");
        sockets.lines().map(|line| line.split_whitespace().collect::<Vec<_>>()).all(|columns| {
            let is_ours = columns.iter().take(3).any(|column| column.ends_with(&at_port));
            !is_ours || columns[4] == "00000000:00000000"
        })
    };
    let mut looks = 0;
    while looks < 10 {
        looks = if hub.passed_on() == frames && is_empty() && logging.is_idle() { looks + 1 } else { 0 };
        std::thread::sleep(Duration::from_millis(3));
    }
}
