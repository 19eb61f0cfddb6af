//! An interface that goes away is told of, and taken again when it is back.

use canloop::bus::{Arrival, Bus as _, BusError, OpenOptions, SocketCan};
use canloop::frame::CanId;
use canloop::run::Clock;
use canloop::time::{Duration, Instant};

use crate::rig::{Vcan, drain, ip, next, numbered, open_with};

#[test]
#[ignore = "needs a kernel with CAN"]
fn an_interface_taken_down_and_up_is_down_then_up_and_frames_flow_again() {
    let vcan = Vcan::new("downup0");
    let mut bus = vcan.open();
    ip("link set downup0 down");
    assert_eq!(next(&mut bus).1, Arrival::Down);
    assert!(matches!(bus.send(&numbered(1, 1)), Err(BusError::Down)));
    assert!(waits_without_work(&mut bus, Duration::from_millis(300)));
    ip("link set downup0 up");
    assert_eq!(next(&mut bus).1, Arrival::Up);
    assert_frames_flow(&vcan, &mut bus);
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn an_interface_removed_and_made_anew_is_found_by_its_name() {
    let vcan = Vcan::new("anew0");
    let mut bus = vcan.open();
    ip("link del anew0");
    assert_eq!(next(&mut bus).1, Arrival::Down);
    assert!(waits_without_work(&mut bus, Duration::from_millis(300)));
    Vcan::add("anew0");
    assert_eq!(bus.receive(Clock::new().now() + Duration::from_millis(200)).unwrap(), None, "it is not up yet");
    ip("link set anew0 up");
    assert_eq!(next(&mut bus).1, Arrival::Up);
    assert_frames_flow(&vcan, &mut bus);
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn an_interface_exchanged_between_two_looks_is_down_then_up() {
    let vcan = Vcan::new("swap0");
    let mut bus = vcan.open();
    ip("link del swap0");
    Vcan::add("swap0");
    ip("link set swap0 up");
    assert_eq!(next(&mut bus).1, Arrival::Down);
    assert_eq!(next(&mut bus).1, Arrival::Up);
    assert_frames_flow(&vcan, &mut bus);
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn an_outage_first_seen_by_a_send_is_told_all_the_same() {
    for (name, command) in [("sendd0", "link set sendd0 down"), ("sendr0", "link del sendr0")] {
        let vcan = Vcan::new(name);
        let mut bus = vcan.open();
        ip(command);
        assert!(matches!(bus.send(&numbered(1, 1)), Err(BusError::Down)));
        assert_eq!(drain(&mut bus), [Arrival::Down]);
    }
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn the_filters_are_there_again_after_an_outage() {
    let vcan = Vcan::new("again0");
    let mut bus = open_with(vcan.0, &OpenOptions { receive: &[CanId::Standard(2)], ..Default::default() });
    ip("link set again0 down");
    ip("link set again0 up");
    assert_eq!(next(&mut bus).1, Arrival::Down);
    assert_eq!(next(&mut bus).1, Arrival::Up);
    let mut other = vcan.open();
    other.send(&numbered(1, 1)).unwrap();
    other.send(&numbered(2, 2)).unwrap();
    assert_eq!(drain(&mut bus), [Arrival::Frame(numbered(2, 2))]);
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn an_interface_that_no_longer_carries_can_fd_stays_down_where_that_is_needed() {
    let vcan = Vcan::new("nofd0");
    let mut bus = open_with(vcan.0, &OpenOptions { needs_fd: true, ..Default::default() });
    ip("link set nofd0 down");
    ip("link set nofd0 mtu 16");
    ip("link set nofd0 up");
    assert_eq!(next(&mut bus).1, Arrival::Down);
    assert_eq!(bus.receive(Clock::new().now() + Duration::from_millis(200)).unwrap(), None);
    ip("link set nofd0 down");
    ip("link set nofd0 mtu 72");
    ip("link set nofd0 up");
    assert_eq!(next(&mut bus).1, Arrival::Up);
}

fn assert_frames_flow(vcan: &Vcan, bus: &mut SocketCan) {
    let mut other = vcan.open();
    other.send(&numbered(3, 4)).unwrap();
    assert_eq!(next(bus).1, Arrival::Frame(numbered(3, 4)));
    bus.send(&numbered(5, 6)).unwrap();
    assert_eq!(next(&mut other).1, Arrival::Frame(numbered(5, 6)));
}

/// Whether nothing arrives for a while, and the thread sleeps meanwhile.
fn waits_without_work(bus: &mut SocketCan, span: Duration) -> bool {
    let clock = Clock::new();
    let (until, before) = (clock.now() + span, thread_work());
    let arrived = bus.receive(until).unwrap();
    arrived.is_none() && clock.now() >= until && (thread_work() - before).as_nanos() < span.as_nanos() / 3
}

/// Processor time of this thread.
fn thread_work() -> Instant {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Instant::from_nanos(time.tv_sec * 1_000_000_000 + time.tv_nsec)
}
