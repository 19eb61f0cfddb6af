//! One frame at a time, as long as its bits take, and the lowest id first.

use canloop::bus::BitRates;
use canloop::frame::{CanId, Frame, FrameKind};
use canloop::time::{Duration, Instant};
use hil_sim::wire::{Node, Wire};
use proptest::prelude::*;

use crate::rig::{frame, ids, length_us, seen, until, us, wire};

/// Bits of a classic data frame, written out one by one as the standard draws
/// them, without the tables of the program.
fn bits_written_out(id: CanId, payload: &[u8]) -> i64 {
    let mut bits: Vec<bool> = Vec::new();
    let mut push = |value: u32, width: u32| bits.extend((0..width).rev().map(|bit| value >> bit & 1 == 1));
    push(0, 1);
    match id {
        CanId::Standard(id) => push(u32::from(id) << 3, 14),
        CanId::Extended(id) => {
            push(id >> 18, 11);
            push(0b11, 2);
            push((id & 0x3_FFFF) << 3, 21);
        }
    }
    push(payload.len() as u32, 4);
    payload.iter().for_each(|&byte| push(byte.into(), 8));
    let crc = bits.iter().fold(0_u32, |crc, &bit| {
        let shifted = crc << 1 & 0x7FFF;
        if bit == (crc >> 14 == 1) { shifted } else { shifted ^ 0x4599 }
    });
    bits.extend((0..15).rev().map(|bit| crc >> bit & 1 == 1));
    let (mut inserted, mut level, mut run) = (0, true, 0);
    for bit in &bits {
        (level, run) = if *bit == level { (level, run + 1) } else { (*bit, 1) };
        if run == 5 {
            (inserted, level, run) = (inserted + 1, !level, 1);
        }
    }
    // Delimiters and slot (3), end of frame (7), inter-frame space (3).
    bits.len() as i64 + inserted + 13
}

fn any_id() -> impl Strategy<Value = CanId> {
    prop_oneof![(0..0x800_u16).prop_map(CanId::Standard), (0..0x2000_0000_u32).prop_map(CanId::Extended)]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_frame_takes_as_long_as_its_bits_written_out(id in any_id(), payload in prop::collection::vec(any::<u8>(), 0..=8)) {
        let mut wire = wire();
        wire.send(Instant::ZERO, Node::Right, Frame::classic(id, &payload), false);
        let crossed = until(&mut wire, us(1_000));
        prop_assert_eq!(crossed[0].at, us(bits_written_out(id, &payload)));
    }

    #[test]
    fn of_frames_that_are_ready_together_the_lowest_id_goes_first(all in prop::array::uniform3(any_id())) {
        let mut wire = wire();
        for (node, id) in [Node::Stack, Node::Right, Node::Left].into_iter().zip(all) {
            wire.send(Instant::ZERO, node, Frame::classic(id, &[]), false);
        }
        let crossed: Vec<_> = until(&mut wire, us(1_000)).iter().map(|crossing| crossing.frame.id).collect();
        prop_assert_eq!(crossed.len(), 3);
        // As the bits go over the wire: a recessive one loses.
        let bits = |id: &CanId| match *id {
            CanId::Standard(id) => (id, 0, 0),
            CanId::Extended(id) => ((id >> 18) as u16, 1, id & 0x3_FFFF),
        };
        prop_assert!(crossed.is_sorted_by_key(bits), "{:?}", crossed);
    }
}

#[test]
fn a_frame_that_is_on_the_wire_is_not_interrupted() {
    let mut wire = wire();
    wire.send(Instant::ZERO, Node::Left, frame(0x300), false);
    assert!(wire.next_event().is_some());
    wire.send(us(1), Node::Right, frame(0x200), false);
    wire.send(us(2), Node::Stack, frame(0x100), false);
    assert_eq!(ids(&mut wire, us(10_000)), [0x300, 0x100, 0x200]);
}

#[test]
fn a_node_s_own_frames_keep_their_order_so_that_an_urgent_one_waits_behind_others() {
    for node in [Node::Stack, Node::Right] {
        let mut wire = wire();
        for id in [0x400, 0x100, 0x300] {
            wire.send(Instant::ZERO, node, frame(id), false);
        }
        wire.send(Instant::ZERO, Node::Left, frame(0x200), false);
        assert_eq!(ids(&mut wire, us(10_000)), [0x200, 0x400, 0x100, 0x300]);
    }
}

#[test]
fn a_data_frame_goes_before_the_request_for_it() {
    let mut wire = wire();
    let mut request = Frame::classic(CanId::Standard(0x100), &[]);
    request.kind = FrameKind::Remote;
    wire.send(Instant::ZERO, Node::Stack, request, false);
    wire.send(Instant::ZERO, Node::Right, frame(0x100), false);
    let senders: Vec<Node> = seen(&mut wire, us(1_000)).into_iter().map(|(node, ..)| node).collect();
    assert_eq!(senders, [Node::Right, Node::Stack]);
}

#[test]
fn the_data_phase_of_a_frame_that_switches_goes_at_its_own_rate() {
    let mut fd = Frame::zeroed(CanId::Standard(0x55), 64);
    fd.payload_mut().fill(0x55);
    fd.kind = FrameKind::FdBitRateSwitch;
    let end_us = |data_bit_s| {
        let mut wire = Wire::new(BitRates { nominal_bit_s: 1_000_000, data_bit_s }, 1);
        wire.send(Instant::ZERO, Node::Right, fd, false);
        seen(&mut wire, us(10_000))[0].2
    };
    // 512 bits of data and more go four times as fast.
    let saved_us = end_us(1_000_000) - end_us(4_000_000);
    assert!((512 * 3 / 4..600 * 3 / 4).contains(&saved_us), "{saved_us}");
}

#[test]
fn an_overloaded_bus_starves_what_is_least_urgent_and_counts_what_finds_no_room() {
    let mut wire = wire();
    let (urgent, patient) = (frame(0x100), frame(0x500));
    let length = Duration::from_micros(length_us(&urgent));
    wire.send(Instant::ZERO, Node::Left, patient, false);
    let mut crossed = Vec::new();
    for turn in 0..1_000 {
        let now = Instant::ZERO + length * turn;
        crossed.extend(until(&mut wire, now));
        wire.send(now, Node::Stack, urgent, false);
        if turn % 10 == 0 {
            wire.send(now, Node::Right, patient, false);
        }
    }
    let first = crossed.iter().filter(|crossing| crossing.frame.id == patient.id).count();
    assert!(first <= 1 && crossed.len() >= 998, "{first} of {}", crossed.len());
    assert_eq!(wire.node_stats(Node::Right).lost, 100 - 64);
    assert_eq!(wire.stats().lost, 36);
    // When the urgent ones stop, the others come, late.
    let late = until(&mut wire, us(1_000_000));
    assert!(late.iter().filter(|crossing| crossing.sender == Node::Right).count() == 64);
    assert!(late.last().is_some_and(|crossing| crossing.at > Instant::ZERO + length * 1_060));
}
