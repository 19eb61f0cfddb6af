//! Frames go there and back as they are, to all others and not to the sender.

use canloop::bus::{Arrival, Bus as _, OpenOptions};
use canloop::frame::{CanId, Frame, FrameKind};
use canloop::run::Clock;
use canloop::time::Duration;

use crate::rig::{Vcan, drain, next, numbered, open_with};

#[test]
#[ignore = "needs a kernel with CAN"]
fn frames_of_every_kind_arrive_as_they_were_sent_both_ways() {
    let vcan = Vcan::new("kinds0");
    let (mut here, mut there) = (vcan.open(), vcan.open());
    for id in [CanId::Standard(0x123), CanId::Standard(0x7FF), CanId::Extended(0x123), CanId::Extended(0x1FFF_FFFF)] {
        for (kind, len) in [
            (FrameKind::Classic, 0),
            (FrameKind::Classic, 8),
            (FrameKind::Remote, 3),
            (FrameKind::Fd, 5),
            (FrameKind::Fd, 64),
            (FrameKind::FdBitRateSwitch, 48),
        ] {
            let mut frame = Frame::zeroed(id, len);
            frame.kind = kind;
            if kind != FrameKind::Remote {
                frame.payload_mut().iter_mut().zip(1..).for_each(|(byte, value)| *byte = value);
            }
            here.send(&frame).unwrap();
            assert_eq!(next(&mut there).1, Arrival::Frame(frame));
            there.send(&frame).unwrap();
            assert_eq!(next(&mut here).1, Arrival::Frame(frame));
        }
    }
    assert_eq!((here.counts().sent, here.counts().received), (24, 24));
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn every_other_socket_sees_a_frame_and_its_sender_does_not() {
    let vcan = Vcan::new("echo0");
    let (mut sender, mut second, mut third) = (vcan.open(), vcan.open(), vcan.open());
    sender.send(&numbered(1, 7)).unwrap();
    assert_eq!(next(&mut second).1, Arrival::Frame(numbered(1, 7)));
    assert_eq!(next(&mut third).1, Arrival::Frame(numbered(1, 7)));
    assert_eq!(drain(&mut sender), []);
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn only_the_ids_asked_for_arrive() {
    let vcan = Vcan::new("filter0");
    let wanted = [CanId::Standard(0x181), CanId::Extended(0x1_8100)];
    let mut bus = open_with(vcan.0, &OpenOptions { receive: &wanted, ..Default::default() });
    let mut other = vcan.open();
    for id in [0x180, 0x181, 0x182, 0x581] {
        other.send(&Frame::classic(CanId::Standard(id), &[1])).unwrap();
    }
    for id in [0x181, 0x1_8100, 0x1_8101, 0x101_8100] {
        other.send(&Frame::classic(CanId::Extended(id), &[2])).unwrap();
    }
    let expected = wanted.map(|id| Arrival::Frame(Frame::classic(id, &[1 + u8::from(id.is_extended())])));
    assert_eq!(drain(&mut bus), expected);
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn a_stamp_lies_between_sending_and_receiving_and_never_goes_back() {
    let vcan = Vcan::new("stamps0");
    let (mut here, mut there) = (vcan.open(), vcan.open());
    let clock = Clock::new();
    let mut last = clock.now();
    for number in 0..500 {
        let before = clock.now();
        here.send(&numbered(1, number)).unwrap();
        let (at, _) = next(&mut there);
        let after = clock.now();
        assert!(before <= at && at <= after, "{before:?} {at:?} {after:?}");
        assert!(at >= last);
        last = at;
    }
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn a_stamp_tells_when_a_frame_arrived_and_not_when_it_was_read() {
    let vcan = Vcan::new("late0");
    let (mut here, mut there) = (vcan.open(), vcan.open());
    let clock = Clock::new();
    here.send(&numbered(1, 1)).unwrap();
    let sent = clock.now();
    let late = Duration::from_millis(200);
    assert_eq!(here.receive(sent + late).unwrap(), None);
    let (at, _) = next(&mut there);
    assert!(at - sent < Duration::from_millis(100), "{:?}", at - sent);
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn nothing_comes_by_the_deadline_when_nobody_sends() {
    let vcan = Vcan::new("quiet0");
    let mut bus = vcan.open();
    let clock = Clock::new();
    let deadline = clock.now() + Duration::from_micros(3_700);
    assert_eq!(bus.receive(deadline).unwrap(), None);
    assert!(clock.now() >= deadline);
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn a_bus_is_opened_by_its_address() {
    let vcan = Vcan::new("address0");
    let mut bus = canloop::bus::open(vcan.0, &OpenOptions::default(), Clock::new()).unwrap();
    vcan.open().send(&numbered(5, 5)).unwrap();
    let (_, arrival) = bus.receive(Clock::new().now() + Duration::from_millis(5_000)).unwrap().unwrap();
    assert_eq!(arrival, Arrival::Frame(numbered(5, 5)));
}
