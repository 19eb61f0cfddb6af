//! Signals of a message that share bits in one and the same frame.

use std::ops::RangeInclusive;

use super::MessageLayout;
use crate::schema::bits::ByteOrder;
use crate::schema::signal::Signal;

/// Pairs of signals that overlap, as indices, each with the second one later
/// in the file. Signals that no frame carries together are none.
pub(super) fn overlaps(layout: &MessageLayout) -> Vec<(usize, usize)> {
    let masks: Vec<Vec<(usize, u8)>> = layout.signals.iter().map(touched_bits).collect();
    let mut found = Vec::new();
    for second in 1..layout.signals.len() {
        // One finding a signal is enough: a layout that slipped by a byte
        // overlaps in many places.
        let first =
            (0..second).find(|&first| share_bits(&masks[first], &masks[second]) && can_meet(layout, first, second));
        found.extend(first.map(|first| (first, second)));
    }
    found
}

/// The bits of each byte that a signal has, in the order of the bytes.
fn touched_bits(signal: &Signal) -> Vec<(usize, u8)> {
    let (start, len) = (signal.start_bit, signal.bit_count() as usize);
    let first = if signal.byte_order == ByteOrder::Intel { start } else { start ^ 7 };
    let mut bytes: Vec<(usize, u8)> = Vec::new();
    for bit in first..first + len {
        let mask = match signal.byte_order {
            ByteOrder::Intel => 1 << (bit % 8),
            ByteOrder::Motorola => 0x80 >> (bit % 8),
        };
        match bytes.last_mut() {
            Some((byte, bits)) if *byte == bit / 8 => *bits |= mask,
            _ => bytes.push((bit / 8, mask)),
        }
    }
    bytes
}

fn share_bits(first: &[(usize, u8)], second: &[(usize, u8)]) -> bool {
    let (Some(&(start, _)), Some(&(end, _))) = (second.first(), second.last()) else { return false };
    let from = first.partition_point(|(byte, _)| *byte < start);
    first[from..].iter().take_while(|(byte, _)| *byte <= end).any(|(byte, bits)| {
        let (_, others) = second[byte - start];
        bits & others != 0
    })
}

/// Whether a frame can carry both: no switch keeps them apart.
fn can_meet(layout: &MessageLayout, first: usize, second: usize) -> bool {
    conditions(layout, first).all(|(switch, values)| {
        conditions(layout, second)
            .filter(|(other, _)| *other == switch)
            .all(|(_, others)| values.iter().any(|range| others.iter().any(|other| intersect(range, other))))
    })
}

/// The switches that a signal depends on, from the nearest, with their values.
fn conditions(layout: &MessageLayout, index: usize) -> impl Iterator<Item = (usize, &[RangeInclusive<u64>])> {
    let mut next = layout.signals[index].selector.as_ref();
    std::iter::from_fn(move || {
        let selector = next?;
        next = layout.signals[selector.switch].selector.as_ref();
        Some((selector.switch, selector.values.as_slice()))
    })
}

fn intersect(first: &RangeInclusive<u64>, second: &RangeInclusive<u64>) -> bool {
    first.start() <= second.end() && second.start() <= first.end()
}
