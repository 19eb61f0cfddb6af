//! A log that is killed has every frame that is older than a chunk.

use std::time::Duration;

use canloop::frame::{CanId, Frame};

use crate::rig::{Logging, frames_in, send};
use crate::tcp_bus::RunningHub;

const TIMES: u32 = 50;
/// Frames of 8 bytes with their stamps, names and heads that make a chunk of half
/// a mebibyte. One is being filled, and one may be on its way to the disk.
const CHUNK_FRAMES: usize = 8000;

#[test]
fn fifty_times_killed_at_any_moment() {
    let hub = RunningHub::start();
    for time in 0..TIMES {
        let mut logging = Logging::start(&[(&hub, "can0")], &[]);
        let mut sender = hub.join();
        // From before the first chunk is full to behind the fifth.
        let frames = 500 + time as usize * 800;
        for number in 0..frames as u32 {
            let noise = number.wrapping_mul(2_654_435_761).to_be_bytes();
            send(&mut sender, &Frame::classic(CanId::Standard(1), &[number.to_be_bytes(), noise].concat()));
        }
        wait_until_all_is_heard(hub.address.port());
        logging.kill();
        logging.repair("bus.mcap");
        let numbers = frames_in(&logging.path("bus.mcap")).numbers("can0");
        assert_eq!(numbers, (0..numbers.len() as u32).collect::<Vec<_>>(), "none is missing in between");
        assert!(numbers.len() + 2 * CHUNK_FRAMES >= frames, "{} of {frames} frames", numbers.len());
    }
}

/// Waits until nothing is left in the buffers of this server's connections.
#[allow(clippy::disallowed_methods, reason = "another program is waited for")]
fn wait_until_all_is_heard(port: u16) {
    let at_port = format!(":{port:04X}");
    let is_empty = || {
        let sockets = std::fs::read_to_string("/proc/net/tcp").expect("Linux");
        sockets.lines().map(|line| line.split_whitespace().collect::<Vec<_>>()).all(|columns| {
            let is_ours = columns.iter().take(3).any(|column| column.ends_with(&at_port));
            !is_ours || columns[4] == "00000000:00000000"
        })
    };
    let mut looks = 0;
    while looks < 3 {
        looks = if is_empty() { looks + 1 } else { 0 };
        std::thread::sleep(Duration::from_millis(3));
    }
}
