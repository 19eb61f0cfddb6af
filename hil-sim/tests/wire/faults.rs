//! Each fault does what it says, as one sees who listens to the wire.

use canloop::bus::ControllerState;
use canloop::frame::{CanId, Frame};
use canloop::time::{Duration, Instant};
use hil_sim::wire::{BurstyLoss, Damage, Fault, Node, Nodes, Pick, Wire};

use crate::rig::{RATES, frame, ids, length_us, seen, until, us, wire};

const MS: Duration = Duration::from_millis(1);
const LONG: i64 = 1_000_000;

/// Sends so many frames, one a millisecond, their number in the first byte.
fn send_numbered(wire: &mut Wire, node: Node, id: u16, count: u8) {
    for number in 0..count {
        let now = Instant::ZERO + MS * i64::from(number);
        wire.send(now, node, Frame::classic(CanId::Standard(id), &[number, 0x55]), false);
    }
}

/// The numbers that arrive while `fault` is in force.
fn numbers_with(fault: Fault, count: u8) -> (Vec<u8>, Wire) {
    let mut wire = wire();
    wire.begin(Instant::ZERO, fault);
    let mut numbers = Vec::new();
    for number in 0..count {
        let now = Instant::ZERO + MS * i64::from(number);
        numbers.extend(until(&mut wire, now).iter().map(|crossing| crossing.frame.payload()[0]));
        wire.send(now, Node::Stack, Frame::classic(CanId::Standard(0x100), &[number, 0x55]), false);
    }
    numbers.extend(until(&mut wire, us(LONG)).iter().map(|crossing| crossing.frame.payload()[0]));
    (numbers, wire)
}

#[test]
fn dropped_frames_are_not_on_the_wire_and_are_counted() {
    let (numbers, wire) = numbers_with(Fault::Drop(Pick::id(CanId::Standard(0x100)).times(2)), 5);
    assert_eq!((numbers, wire.stats().discarded, wire.stats().lost), (vec![2, 3, 4], 2, 0));
}

#[test]
fn a_fault_is_for_the_frames_that_it_picks_and_no_others() {
    for pick in [Pick::id(CanId::Standard(0x200)), Pick::id(CanId::Extended(0x100)), Pick::sender(Node::Left)] {
        assert_eq!(numbers_with(Fault::Drop(pick), 3).0, [0, 1, 2]);
    }
    let some = numbers_with(Fault::Drop(Pick::ALL.with_probability(0.5)), 100).0.len();
    assert!((30..70).contains(&some), "{some}");
}

#[test]
fn a_fault_that_has_ended_does_nothing_any_more() {
    let mut wire = wire();
    let fault = wire.begin(Instant::ZERO, Fault::Drop(Pick::ALL));
    wire.send(Instant::ZERO, Node::Stack, frame(0x100), false);
    assert!(wire.end(us(10), fault) && !wire.end(us(10), fault));
    wire.send(us(10), Node::Stack, frame(0x101), false);
    assert_eq!(ids(&mut wire, us(LONG)), [0x101]);
}

#[test]
fn a_delayed_frame_reaches_the_bus_later_and_others_overtake_it() {
    let mut wire = wire();
    wire.begin(Instant::ZERO, Fault::Delay(Pick::ALL.times(1), Duration::from_micros(700)));
    wire.send(Instant::ZERO, Node::Stack, frame(0x100), false);
    wire.send(Instant::ZERO, Node::Stack, frame(0x101), false);
    let length = length_us(&frame(0x100));
    let seen = seen(&mut wire, us(LONG));
    assert_eq!(seen[0].1, 0x101);
    assert_eq!(seen[1], (Node::Stack, 0x100, 700 + length));
}

#[test]
fn a_duplicated_frame_crosses_again_and_again() {
    assert_eq!(numbers_with(Fault::Duplicate(Pick::ALL.times(1), 2), 2).0, [0, 0, 0, 1]);
}

#[test]
fn a_reordered_frame_lets_the_next_go_first() {
    assert_eq!(numbers_with(Fault::Reorder(Pick::ALL.times(1)), 4).0, [1, 0, 2, 3]);
}

#[test]
fn a_reordered_frame_that_nothing_follows_goes_when_the_fault_ends() {
    let mut wire = wire();
    let fault = wire.begin(Instant::ZERO, Fault::Reorder(Pick::ALL));
    wire.send(Instant::ZERO, Node::Stack, frame(0x100), false);
    assert!(ids(&mut wire, us(1_000)).is_empty());
    wire.end(us(1_000), fault);
    assert_eq!(ids(&mut wire, us(LONG)), [0x100]);
}

#[test]
fn damage_that_the_crc_catches_costs_time_and_nothing_else() {
    let (numbers, wire) = numbers_with(Fault::Corrupt(Pick::ALL.times(3), Damage::Caught, Nodes::ALL), 5);
    assert_eq!((numbers, wire.stats().error_frames), (vec![0, 1, 2, 3, 4], 3));
}

#[test]
fn damage_that_it_does_not_catch_changes_one_byte_for_those_who_are_hit() {
    let mut wire = wire();
    wire.begin(Instant::ZERO, Fault::Corrupt(Pick::ALL.times(1), Damage::Uncaught, Nodes::only(Node::Left)));
    wire.send(Instant::ZERO, Node::Stack, frame(0x100), false);
    wire.send(Instant::ZERO, Node::Stack, frame(0x101), false);
    let crossed = until(&mut wire, us(LONG));
    let (left, right) = (crossed[0].as_heard_by(Node::Left).unwrap(), crossed[0].as_heard_by(Node::Right).unwrap());
    assert_eq!(right, frame(0x100));
    let differing = left.payload().iter().zip(right.payload()).filter(|(one, other)| one != other).count();
    assert_eq!((differing, left.id, wire.stats().error_frames), (1, right.id, 0));
    assert_eq!(crossed[1].as_heard_by(Node::Left), Some(frame(0x101)));
}

#[test]
fn a_silenced_node_hears_but_sends_and_acknowledges_nothing() {
    let mut wire = wire();
    wire.begin(Instant::ZERO, Fault::Silence(Node::Left));
    wire.send(Instant::ZERO, Node::Left, frame(0x100), false);
    wire.send(Instant::ZERO, Node::Stack, frame(0x200), false);
    let crossed = until(&mut wire, us(1_000));
    assert_eq!(crossed.len(), 1);
    assert!(crossed[0].heard_by.contains(Node::Left));
    // With the other one silent as well nobody acknowledges.
    wire.begin(us(1_000), Fault::Silence(Node::Right));
    wire.send(us(1_000), Node::Stack, frame(0x200), false);
    assert!(ids(&mut wire, us(LONG)).is_empty());
    assert_eq!(wire.confinement(Node::Stack).state(), ControllerState::ErrorPassive);
}

#[test]
fn a_babbling_node_sends_at_its_rate_and_stops_when_the_fault_ends() {
    let mut wire = wire();
    let fault = wire.begin(Instant::ZERO, Fault::Babble(frame(0x7), Some(MS)));
    let seen = seen(&mut wire, us(10_500));
    assert_eq!(seen.len(), 11);
    assert!(seen.iter().all(|&(node, id, _)| (node, id) == (Node::Intruder, 0x7)));
    assert!(seen.windows(2).all(|pair| pair[1].2 - pair[0].2 == 1_000));
    wire.end(us(10_500), fault);
    assert!(ids(&mut wire, us(LONG)).is_empty());
}

#[test]
fn one_that_babbles_without_end_leaves_no_room_for_anything_less_urgent() {
    let mut wire = wire();
    let fault = wire.begin(Instant::ZERO, Fault::Babble(frame(0x7), None));
    wire.send(us(1), Node::Stack, frame(0x100), false);
    wire.send(us(1), Node::Right, frame(0x6), false);
    let all = ids(&mut wire, us(10_000));
    assert_eq!(all.iter().filter(|&&id| id == 0x100).count(), 0);
    assert_eq!(all.iter().filter(|&&id| id == 0x6).count(), 1);
    let full = 10_000 / length_us(&frame(0x7)) as usize;
    assert!((full - 2..=full).contains(&all.len()), "{} of {full}", all.len());
    wire.end(us(10_000), fault);
    assert_eq!(ids(&mut wire, us(LONG)), [0x100]);
}

#[test]
fn a_node_that_is_held_off_the_bus_stays_off_until_the_fault_ends() {
    let mut wire = wire();
    let fault = wire.begin(Instant::ZERO, Fault::BusOff(Node::Right));
    until(&mut wire, us(LONG));
    assert_eq!(wire.confinement(Node::Right).state(), ControllerState::BusOff);
    wire.end(us(LONG), fault);
    until(&mut wire, us(2 * LONG));
    assert_eq!(wire.confinement(Node::Right).state(), ControllerState::ErrorActive);
}

#[test]
fn what_nobody_acknowledges_is_sent_until_somebody_does() {
    let (numbers, wire) = numbers_with(Fault::NoAcknowledge(Pick::ALL.times(4)), 3);
    assert_eq!((numbers, wire.stats().error_frames), (vec![0, 1, 2], 4));
    assert_eq!(wire.confinement(Node::Stack).transmit_errors(), 4 * 8 - 3);
}

#[test]
fn the_sides_of_a_cut_go_on_by_themselves_at_the_same_time() {
    let mut wire = wire();
    let fault = wire.begin(Instant::ZERO, Fault::Cut(Nodes::only(Node::Stack)));
    wire.send(us(100), Node::Right, frame(0x200), false);
    wire.send(us(100), Node::Stack, frame(0x100), false);
    let crossed = until(&mut wire, us(10_000));
    assert_eq!(crossed.len(), 1, "the drives hear each other, nobody hears the stack");
    assert_eq!(crossed[0].at, us(100 + length_us(&frame(0x200))));
    assert!(!crossed[0].heard_by.contains(Node::Stack) && crossed[0].heard_by.contains(Node::Left));
    wire.end(us(10_000), fault);
    assert_eq!(ids(&mut wire, us(LONG)), [0x100]);
}

#[test]
fn a_frame_that_is_on_the_wire_when_it_is_cut_is_destroyed_and_sent_again() {
    let mut wire = wire();
    wire.send(Instant::ZERO, Node::Stack, frame(0x100), false);
    assert!(wire.next_event().is_some());
    wire.begin(us(30), Fault::Cut(Nodes::only(Node::Left)));
    assert_eq!(seen(&mut wire, us(LONG)), [(Node::Stack, 0x100, 30 + 23 + length_us(&frame(0x100)))]);
    assert_eq!((wire.stats().error_frames, wire.confinement(Node::Stack).transmit_errors()), (1, 7));
}

#[test]
fn bit_errors_come_at_their_rate() {
    let mut wire = wire();
    wire.begin(Instant::ZERO, Fault::BitErrors(1e-3));
    let length = length_us(&frame(0x100));
    let mut arrived = 0;
    for turn in 0..5_000 {
        arrived += until(&mut wire, us(turn * 1_000)).len();
        wire.send(us(turn * 1_000), Node::Stack, frame(0x100), false);
    }
    let attempts = arrived as f64 + wire.stats().error_frames as f64;
    let share = wire.stats().error_frames as f64 / attempts;
    let expected = 1.0 - libm::pow(1.0 - 1e-3, length as f64);
    assert!((share - expected).abs() < 0.01, "{share}, expected {expected}");
    assert!(arrived >= 4_999);
}

#[test]
fn bursty_loss_takes_frames_in_a_row() {
    let channel = BurstyLoss { turns_bad: 0.02, turns_good: 0.05, lost_when_good: 0.0, lost_when_bad: 1.0 };
    let numbers = numbers_with(Fault::BurstyLoss(channel), 250).0;
    let lost = 250 - numbers.len();
    let bursts = numbers.windows(2).filter(|pair| pair[1] - pair[0] > 1).count();
    // Two in seven on average, in bursts of twenty.
    assert!((20..150).contains(&lost) && bursts > 0 && lost / bursts >= 4, "{lost} in {bursts}");
}

#[test]
fn the_same_seed_gives_the_same_faults_and_another_gives_others() {
    let run = |seed| {
        let mut wire = Wire::new(RATES, seed);
        wire.begin(Instant::ZERO, Fault::BitErrors(2e-3));
        wire.begin(Instant::ZERO, Fault::Drop(Pick::ALL.with_probability(0.2)));
        send_numbered(&mut wire, Node::Stack, 0x100, 60);
        until(&mut wire, us(LONG)).iter().map(|crossing| (crossing.at, crossing.frame.payload()[0])).collect::<Vec<_>>()
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

#[test]
fn what_is_lost_is_awaited_no_longer() {
    let faults = [
        Fault::Drop(Pick::ALL),
        Fault::Silence(Node::Right),
        Fault::BusOff(Node::Right),
        Fault::BurstyLoss(BurstyLoss { turns_bad: 0.0, turns_good: 0.0, lost_when_good: 1.0, lost_when_bad: 1.0 }),
    ];
    for fault in faults {
        let mut wire = wire();
        wire.begin(Instant::ZERO, fault);
        wire.send(Instant::ZERO, Node::Right, frame(0x100), true);
        assert_eq!(wire.awaited(), 0, "{fault:?}");
    }
    let mut wire = wire();
    (0..70).for_each(|_| wire.send(Instant::ZERO, Node::Right, frame(0x100), true));
    assert_eq!((wire.awaited(), wire.stats().lost), (64, 6));
    wire.begin(us(10), Fault::BusOff(Node::Right));
    assert_eq!(wire.awaited(), 0, "its queue is thrown away");
}
