//! Frames are as long as can-utils' `canbusload -e` counts them.

use std::process::{Command, Stdio};

use canloop::bus::{Bus as _, SocketCan, frame_bits};
use canloop::frame::{CanId, Frame};
use canloop::run::Clock;
use canloop::time::Duration;
use proptest::prelude::*;
use proptest::strategy::ValueTree as _;
use proptest::test_runner::TestRunner;

use crate::rig::Vcan;

fn any_classic_frame() -> impl Strategy<Value = Frame> {
    let id = prop_oneof![(0..0x800_u16).prop_map(CanId::Standard), (0..0x2000_0000_u32).prop_map(CanId::Extended)];
    let byte = prop_oneof![any::<u8>(), Just(0x00), Just(0xFF), Just(0xF8), Just(0x1F)];
    (id, prop::collection::vec(byte, 0..=8)).prop_map(|(id, payload)| Frame::classic(id, &payload))
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn classic_frames_have_the_bits_that_can_utils_counts() {
    const BATCHES: usize = 20;
    const BATCH: usize = 50;
    let vcan = Vcan::new("length0");
    let mut bus = vcan.open();
    // It prints a line a second, and ends in order when interrupted.
    let mut counting = Command::new("timeout");
    counting.args(["--signal=INT", "6", "canbusload", "-e", "length0@1000000"]);
    let counting = counting.stdout(Stdio::piped()).spawn().expect("timeout can be run");
    pause(&mut bus, 1_500);
    let mut runner = TestRunner::deterministic();
    let mut bits = 0;
    for _ in 0..BATCHES {
        for _ in 0..BATCH {
            let frame = any_classic_frame().new_tree(&mut runner).expect("a frame").current();
            bits += u64::from(frame_bits(&frame));
            bus.send(&frame).unwrap();
        }
        pause(&mut bus, 50);
    }
    let told = counting.wait_with_output().expect("it ends").stdout;
    let told = String::from_utf8(told).expect("it writes text");
    let column =
        |line: &str, index: usize| line.split_whitespace().nth(index).and_then(|text| text.parse::<u64>().ok());
    let sum = |index: usize| told.lines().filter_map(|line| column(line, index)).sum::<u64>();
    assert_eq!(sum(1), (BATCHES * BATCH) as u64, "frames that it saw:\n{told}");
    assert_eq!(sum(2), bits, "bits that it counted:\n{told}");
}

/// Nobody else sends, so nothing arrives.
fn pause(bus: &mut SocketCan, ms: i64) {
    assert_eq!(bus.receive(Clock::new().now() + Duration::from_millis(ms)).unwrap(), None);
}
