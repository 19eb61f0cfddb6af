//! Two cards on one bus, each with the driver of a real one: what one sends
//! the other receives, and neither is quicker than it can be.

use std::fs::{File, OpenOptions as FileOptions};
use std::os::unix::fs::FileExt as _;

use canloop::bus::{Arrival, Bus as _, BusError, CanLink, ControllerState, OpenOptions, SocketCan};
use canloop::frame::{CanId, Frame, FrameKind};
use canloop::run::Clock;
use canloop::time::Duration;

use crate::rig::{drain, ip, next, numbered, open, open_with};

const BIT_RATE: u32 = 500_000;

fn refusal(options: &OpenOptions) -> String {
    SocketCan::open("can0", options, Clock::new()).err().expect("it should not open").to_string()
}

fn wait(bus: &mut SocketCan) -> Option<Arrival> {
    bus.receive(Clock::new().now() + Duration::from_millis(300)).unwrap().map(|(_, arrival)| arrival)
}

/// A card that raises no interrupt until this is dropped: the driver learns
/// neither of frames received nor of frames sent.
struct Silenced {
    registers: File,
    enabled: [u8; 1],
}

impl Silenced {
    /// The SJA1000's interrupt enable register (data sheet, 6.4.7). The card
    /// maps the controller's registers to its second I/O range.
    const INTERRUPT_ENABLE: u64 = 4;

    fn new(card: &str) -> Self {
        let range = format!("/sys/class/net/{card}/device/resource1");
        let registers = FileOptions::new().read(true).write(true).open(range).unwrap();
        let mut enabled = [0];
        registers.read_exact_at(&mut enabled, Self::INTERRUPT_ENABLE).unwrap();
        registers.write_all_at(&[0], Self::INTERRUPT_ENABLE).unwrap();
        Self { registers, enabled }
    }
}

impl Drop for Silenced {
    fn drop(&mut self) {
        self.registers.write_all_at(&self.enabled, Self::INTERRUPT_ENABLE).unwrap();
    }
}

#[test]
#[ignore = "needs can0 and can1 on one bus"]
fn frames_cross_from_each_card_to_the_other_as_they_are() {
    let (mut here, mut there) = (open("can0"), open("can1"));
    for id in [CanId::Standard(0x123), CanId::Standard(0x7FF), CanId::Extended(0x123), CanId::Extended(0x1FFF_FFFF)] {
        // The emulated controller stumbles over remote frames that ask for bytes.
        for (kind, len) in [(FrameKind::Classic, 0), (FrameKind::Classic, 8), (FrameKind::Remote, 0)] {
            let mut frame = Frame::zeroed(id, len);
            frame.kind = kind;
            if kind == FrameKind::Classic {
                frame.payload_mut().iter_mut().zip(1..).for_each(|(byte, value)| *byte = value);
            }
            here.send(&frame).unwrap();
            assert_eq!(next(&mut there).1, Arrival::Frame(frame));
            there.send(&frame).unwrap();
            assert_eq!(next(&mut here).1, Arrival::Frame(frame));
        }
    }
    assert_eq!((drain(&mut here), drain(&mut there)), (vec![], vec![]), "nobody hears himself");
}

#[test]
#[ignore = "needs can0 and can1 on one bus"]
fn a_card_is_read_as_it_was_set_up() {
    for card in ["can0", "can1"] {
        let link = CanLink::read(card).unwrap();
        assert!(link.is_up && link.is_controller && !link.carries_fd);
        assert_eq!((link.bit_rate_bit_s, link.queue_frames), (Some(BIT_RATE), 10));
        assert_eq!(link.state, Some(ControllerState::ErrorActive));
    }
}

#[test]
#[ignore = "needs can0 and can1 on one bus"]
fn another_bit_rate_is_refused_with_both_values() {
    open_with("can0", &OpenOptions { bit_rate_bit_s: Some(BIT_RATE), ..Default::default() });
    let message = refusal(&OpenOptions { bit_rate_bit_s: Some(250_000), ..Default::default() });
    assert!(message.contains("500000") && message.contains("250000") && message.contains("ip link set"), "{message}");
}

#[test]
#[ignore = "needs can0 and can1 on one bus"]
fn a_card_is_refused_where_can_fd_is_needed() {
    let message = refusal(&OpenOptions { needs_fd: true, ..Default::default() });
    assert!(message.contains("classic frames only"), "{message}");
}

#[test]
#[ignore = "needs can0 and can1 on one bus"]
fn a_card_taken_down_is_back_only_with_its_bit_rate() {
    let mut bus = open_with("can0", &OpenOptions { bit_rate_bit_s: Some(BIT_RATE), ..Default::default() });
    let mut other = open("can1");
    ip("link set can0 down");
    assert_eq!(next(&mut bus).1, Arrival::Down);
    assert!(matches!(bus.send(&numbered(1, 1)), Err(BusError::Down)));
    ip("link set can0 up type can bitrate 250000");
    assert_eq!(wait(&mut bus), None, "another bit rate");
    ip("link set can0 down");
    ip("link set can0 up type can bitrate 500000");
    assert_eq!(next(&mut bus).1, Arrival::Up);
    bus.send(&numbered(2, 2)).unwrap();
    assert_eq!(next(&mut other).1, Arrival::Frame(numbered(2, 2)));
    other.send(&numbered(3, 3)).unwrap();
    assert_eq!(next(&mut bus).1, Arrival::Frame(numbered(3, 3)));
}

#[test]
#[ignore = "needs can0 and can1 on one bus"]
fn a_full_transmit_queue_is_told_and_loses_nothing() {
    let (mut bus, mut other) = (open("can0"), open("can1"));
    let silenced = Silenced::new("can0");
    let taken = (0..1000).find(|&number| bus.send(&numbered(1, number)).is_err()).expect("the queue has no end");
    assert!((10..20).contains(&taken), "{taken} frames taken");
    assert!(matches!(bus.send(&numbered(1, 0)), Err(BusError::Full)), "still full");
    assert_eq!((bus.counts().sent, bus.counts().full), (taken.into(), 2));

    drop(silenced);
    other.send(&numbered(2, 0)).unwrap(); // and the card speaks up
    assert_eq!(next(&mut bus).1, Arrival::Frame(numbered(2, 0)));
    let expected: Vec<_> = (0..taken).map(|number| Arrival::Frame(numbered(1, number))).collect();
    assert_eq!(drain(&mut other), expected);
    bus.send(&numbered(1, taken)).unwrap();
    assert_eq!(next(&mut other).1, Arrival::Frame(numbered(1, taken)));
}

#[test]
#[ignore = "needs can0 and can1 on one bus"]
fn a_burst_longer_than_the_queue_arrives_whole_and_in_order() {
    const BURST: u32 = 200;
    let (mut bus, mut other) = (open("can0"), open("can1"));
    for number in 0..BURST {
        while let Err(error) = bus.send(&numbered(1, number)) {
            assert!(matches!(error, BusError::Full), "{error}");
            assert_eq!(bus.receive(Clock::new().now() + Duration::from_millis(1)).unwrap(), None);
        }
    }
    let expected: Vec<_> = (0..BURST).map(|number| Arrival::Frame(numbered(1, number))).collect();
    assert_eq!(drain(&mut other), expected);
}

#[test]
#[ignore = "needs can0 and can1 on one bus"]
fn frames_that_the_card_had_no_room_for_are_told_as_a_loss() {
    let (mut bus, mut other) = (open("can0"), open("can1"));
    let silenced = Silenced::new("can1");
    (0..20).for_each(|number| bus.send(&numbered(1, number)).unwrap());
    drop(silenced);
    bus.send(&numbered(1, 20)).unwrap(); // one more, for the card to speak up
    let arrivals = drain(&mut other);
    let (frames, losses): (Vec<_>, Vec<_>) =
        arrivals.into_iter().partition(|arrival| matches!(arrival, Arrival::Frame(_)));
    // The controller has 64 bytes (data sheet, 6.4.13), of which such a frame takes 7.
    let expected: Vec<_> = (0..9).map(|number| Arrival::Frame(numbered(1, number))).collect();
    assert_eq!(frames, expected);
    assert!(matches!(losses[..], [Arrival::Lost(1..)]), "{losses:?}");
    assert!(other.counts().lost > 0);
}
