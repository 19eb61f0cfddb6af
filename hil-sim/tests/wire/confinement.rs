//! Who errs retransmits, counts, falls silent and comes back, as ISO 11898-1
//! has it.

use canloop::bus::ControllerState;
use canloop::frame::{CanId, Frame};
use canloop::time::{Duration, Instant};
use hil_sim::wire::{Damage, Fault, FaultId, Node, Nodes, Pick, Recovery, Wire};

use crate::rig::{frame, ids, length_us, seen, until, us, wire};

const LONG: i64 = 1_000_000;

fn damaged(times: u32) -> Fault {
    Fault::Corrupt(Pick::sender(Node::Stack).times(times), Damage::Caught, Nodes::ALL)
}

fn counters(wire: &Wire, node: Node) -> (u16, u16) {
    (wire.confinement(node).transmit_errors(), wire.confinement(node).receive_errors())
}

fn state(wire: &Wire, node: Node) -> ControllerState {
    wire.confinement(node).state()
}

/// A stack that has met so many errors, with nothing left to send.
fn after_errors(errors: u32) -> Wire {
    let mut wire = wire();
    let fault = wire.begin(Instant::ZERO, damaged(errors));
    wire.send(Instant::ZERO, Node::Stack, frame(0x100), false);
    until(&mut wire, us(LONG));
    assert!(wire.end(us(LONG), fault));
    wire
}

fn off_the_bus(recovery: Recovery) -> (Wire, FaultId) {
    let mut wire = wire().with_recovery(Node::Stack, recovery);
    let fault = wire.begin(Instant::ZERO, Fault::BusOff(Node::Stack));
    (wire, fault)
}

#[test]
fn a_damaged_frame_is_followed_by_an_error_frame_and_sent_again() {
    let mut wire = wire();
    wire.begin(Instant::ZERO, Fault::Corrupt(Pick::ALL.times(1), Damage::Caught, Nodes::DRIVES));
    wire.send(Instant::ZERO, Node::Stack, frame(0x100), false);
    // 10 bits before its regular end the receivers object: 7 bits of flags, 8
    // of delimiter, 3 of space.
    let length = length_us(&frame(0x100));
    assert_eq!(seen(&mut wire, us(LONG)), [(Node::Stack, 0x100, length - 10 + 18 + length)]);
    assert_eq!((wire.stats().error_frames, wire.node_stats(Node::Stack).failed), (1, 1));
}

#[test]
fn an_error_costs_the_transmitter_eight_and_each_success_gives_back_one() {
    let mut wire = after_errors(1);
    assert_eq!(counters(&wire, Node::Stack), (8 - 1, 0));
    wire.send(us(LONG), Node::Stack, frame(0x100), false);
    until(&mut wire, us(2 * LONG));
    assert_eq!(counters(&wire, Node::Stack), (6, 0));
}

#[test]
fn a_receiver_that_saw_the_error_first_counts_nine_and_the_others_one() {
    let mut wire = wire();
    wire.begin(Instant::ZERO, Fault::Corrupt(Pick::ALL.times(1), Damage::Caught, Nodes::only(Node::Left)));
    wire.send(Instant::ZERO, Node::Stack, frame(0x100), false);
    until(&mut wire, us(200));
    // The frame has crossed since, and gave back one to each.
    assert_eq!((counters(&wire, Node::Left), counters(&wire, Node::Right)), ((0, 8), (0, 0)));
}

#[test]
fn sixteen_errors_in_a_row_make_a_transmitter_passive_and_thirty_two_take_it_off() {
    for (errors, expected) in
        [(12, ControllerState::ErrorActive), (13, ControllerState::ErrorWarning), (17, ControllerState::ErrorPassive)]
    {
        assert_eq!(state(&after_errors(errors), Node::Stack), expected, "{errors}");
    }
    let mut wire = wire().with_recovery(Node::Stack, Recovery::ByCommand);
    wire.begin(Instant::ZERO, damaged(100));
    wire.send(Instant::ZERO, Node::Stack, frame(0x100), false);
    assert!(until(&mut wire, us(LONG)).is_empty());
    assert_eq!((state(&wire, Node::Stack), wire.stats().error_frames), (ControllerState::BusOff, 32));
}

#[test]
fn states_are_told_in_the_order_in_which_they_come() {
    let mut wire = wire();
    wire.begin(Instant::ZERO, damaged(32));
    wire.send(Instant::ZERO, Node::Stack, frame(0x100), false);
    until(&mut wire, us(LONG));
    let changes = std::iter::from_fn(|| wire.poll_change()).filter(|change| change.node == Node::Stack);
    let states: Vec<_> = changes.map(|change| change.state).collect();
    use ControllerState::{BusOff, ErrorActive, ErrorPassive, ErrorWarning};
    assert_eq!(states, [ErrorWarning, ErrorPassive, BusOff, ErrorActive]);
}

#[test]
fn who_is_alone_becomes_passive_never_goes_off_and_sends_again_for_ever() {
    let mut wire = wire();
    let cut = wire.begin(Instant::ZERO, Fault::Cut(Nodes::DRIVES));
    wire.send(Instant::ZERO, Node::Stack, frame(0x100), false);
    assert!(until(&mut wire, us(LONG)).is_empty());
    assert_eq!(counters(&wire, Node::Stack), (128, 0));
    assert_eq!(state(&wire, Node::Stack), ControllerState::ErrorPassive);
    // Each attempt is 6 bits longer than the frame, and 8 of suspension follow.
    let attempts = LONG / (length_us(&frame(0x100)) + 6 + 8);
    let failed = wire.node_stats(Node::Stack).failed as i64;
    assert!((attempts..attempts + 5).contains(&failed), "{failed} of {attempts}");
    wire.end(us(LONG), cut);
    assert_eq!(ids(&mut wire, us(LONG + 500)), [0x100]);
}

#[test]
fn one_who_acknowledges_is_enough() {
    let mut wire = wire();
    wire.begin(Instant::ZERO, Fault::Cut(Nodes::only(Node::Left)));
    wire.send(Instant::ZERO, Node::Stack, frame(0x100), false);
    let crossed = until(&mut wire, us(LONG));
    assert_eq!(crossed.len(), 1);
    assert!(crossed[0].heard_by.contains(Node::Right) && !crossed[0].heard_by.contains(Node::Left));
}

#[test]
fn a_passive_transmitter_lets_others_go_between_its_frames_and_an_active_one_does_not() {
    for (errors, expected) in [(1, [0x100, 0x101, 0x500]), (20, [0x100, 0x500, 0x101])] {
        let mut wire = after_errors(errors);
        for id in [0x100, 0x101] {
            wire.send(us(LONG), Node::Stack, frame(id), false);
        }
        wire.send(us(LONG), Node::Right, frame(0x500), false);
        assert_eq!(ids(&mut wire, us(2 * LONG)), expected);
    }
}

#[test]
fn alone_on_the_bus_a_passive_transmitter_waits_eight_bits_between_its_frames() {
    let mut wire = after_errors(20);
    for id in [0x100, 0x101] {
        wire.send(us(LONG), Node::Stack, frame(id), false);
    }
    let seen = seen(&mut wire, us(2 * LONG));
    assert_eq!(seen[1].2 - seen[0].2, 8 + length_us(&frame(0x101)));
}

#[test]
fn a_passive_receiver_cannot_keep_a_frame_from_the_others() {
    let mut wire = wire();
    wire.begin(Instant::ZERO, Fault::Corrupt(Pick::ALL, Damage::Caught, Nodes::only(Node::Left)));
    wire.send(Instant::ZERO, Node::Stack, frame(0x100), false);
    let crossed = until(&mut wire, us(LONG));
    // Nine each time: the fifteenth makes it passive.
    assert_eq!((crossed.len(), wire.stats().error_frames), (1, 15));
    assert!(crossed[0].heard_by.contains(Node::Right) && !crossed[0].heard_by.contains(Node::Left));
    assert_eq!(crossed[0].as_heard_by(Node::Left), None);
}

#[test]
fn who_goes_off_the_bus_loses_what_it_had_to_send_and_hears_nothing() {
    let mut wire = wire();
    (0..5).for_each(|_| wire.send(Instant::ZERO, Node::Stack, frame(0x100), false));
    wire.begin(Instant::ZERO, Fault::BusOff(Node::Stack));
    wire.send(us(10), Node::Stack, frame(0x100), false);
    wire.send(us(10), Node::Right, frame(0x200), false);
    let crossed = until(&mut wire, us(LONG));
    assert_eq!(crossed.len(), 1);
    assert!(!crossed[0].heard_by.contains(Node::Stack) && crossed[0].heard_by.contains(Node::Left));
    assert_eq!((wire.node_stats(Node::Stack).discarded, wire.node_stats(Node::Stack).bus_off), (6, 1));
}

#[test]
fn on_an_idle_bus_it_comes_back_after_128_times_11_bits() {
    let (mut wire, fault) = off_the_bus(Recovery::ByItself);
    until(&mut wire, us(5_000));
    wire.end(us(5_000), fault);
    until(&mut wire, us(5_000 + 128 * 11 - 1));
    assert_eq!(state(&wire, Node::Stack), ControllerState::BusOff);
    until(&mut wire, us(5_000 + 128 * 11));
    assert_eq!((state(&wire, Node::Stack), counters(&wire, Node::Stack)), (ControllerState::ErrorActive, (0, 0)));
}

#[test]
fn on_a_busy_bus_each_frame_counts_as_one_of_the_128() {
    let (mut wire, fault) = off_the_bus(Recovery::ByItself);
    wire.end(Instant::ZERO, fault);
    let length = length_us(&frame(0x200));
    for turn in 0..200 {
        until(&mut wire, us(turn * length));
        wire.send(us(turn * length), Node::Right, frame(0x200), false);
        let is_off = state(&wire, Node::Stack) == ControllerState::BusOff;
        assert_eq!(is_off, turn < 128, "after {turn} frames");
    }
}

#[test]
fn it_can_be_made_to_wait_before_that_or_for_a_command() {
    let (mut wire, fault) = off_the_bus(Recovery::After(Duration::from_millis(100)));
    wire.end(Instant::ZERO, fault);
    until(&mut wire, us(100_000 + 128 * 11 - 1));
    assert_eq!(state(&wire, Node::Stack), ControllerState::BusOff);
    until(&mut wire, us(100_000 + 128 * 11));
    assert_eq!(state(&wire, Node::Stack), ControllerState::ErrorActive);

    let (mut wire, fault) = off_the_bus(Recovery::ByCommand);
    wire.restart(us(10), Node::Stack);
    wire.end(us(20), fault);
    until(&mut wire, us(LONG));
    assert_eq!(state(&wire, Node::Stack), ControllerState::BusOff, "a held one hears no command");
    wire.restart(us(LONG), Node::Stack);
    until(&mut wire, us(LONG + 128 * 11));
    assert_eq!(state(&wire, Node::Stack), ControllerState::ErrorActive);
}

#[test]
fn two_who_send_different_frames_under_one_id_destroy_both_until_they_are_off() {
    let mut wire = wire();
    wire.send(Instant::ZERO, Node::Right, Frame::classic(CanId::Standard(0x100), &[1, 2]), false);
    wire.send(Instant::ZERO, Node::Left, Frame::classic(CanId::Standard(0x100), &[1, 3]), false);
    // 19 bits of header, the first byte, and the first of the second.
    assert_eq!(wire.next_event(), Some(us(19 + 8 + 1 + 12 + 8 + 3)));
    assert!(until(&mut wire, us(LONG)).is_empty());
    let off = [Node::Right, Node::Left].map(|node| wire.node_stats(node).bus_off);
    assert_eq!((off, wire.stats().error_frames), ([1, 1], 32));
}

#[test]
fn the_same_frame_from_two_disturbs_nobody() {
    let mut wire = wire();
    wire.send(Instant::ZERO, Node::Right, frame(0x100), false);
    wire.send(Instant::ZERO, Node::Left, frame(0x100), false);
    assert_eq!(ids(&mut wire, us(LONG)), [0x100, 0x100]);
    assert_eq!(wire.stats().error_frames, 0);
}
