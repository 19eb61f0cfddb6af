//! Where the bits of a signal lie in a frame, compiled once into a window of
//! bytes, a shift and a mask.

use std::ops::Range;

/// Bytes that a frame can hold; windows are clamped to stay inside where they
/// can.
const CAPACITY: usize = 64;
/// Bytes of the longest message that any transport protocol carries, and more.
const LONGEST: usize = 1 << 16;

/// Consecutive bits of a message. More than 64 of them keep their place but
/// are no number: they read as 0 and are never written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bits {
    /// First byte of the window.
    first: usize,
    /// The byte after the last one touched.
    end: usize,
    len: u32,
    /// How far right the window moves to bring the lowest bit down to bit 0.
    shift: u32,
    /// As many ones as the signal has bits.
    mask: u64,
    /// Whether the bits touch nine bytes, so that no `u64` holds them all.
    wide: bool,
    order: ByteOrder,
}

/// Which end of a number comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByteOrder {
    /// Little-endian, `@1` in a DBC.
    Intel,
    /// Big-endian, `@0` in a DBC.
    Motorola,
}

impl Bits {
    /// Compiles a DBC's `start|len@order`: `start` names the lowest bit of an
    /// Intel signal and the highest one of a Motorola signal. `None` when there
    /// are no bits, or when they lie farther out than any message reaches.
    pub fn new(start: usize, len: usize, order: ByteOrder) -> Option<Self> {
        let touched = touched_bytes(start, len, order).filter(|touched| touched.end <= LONGEST)?;
        let is_number = len <= 64;
        let wide = is_number && touched.len() > 8;
        let width = if wide { 16 } else { 8 };
        let first = match touched.end {
            // The signals of a classic frame all share one window, which the
            // payload of a full one holds.
            0..=8 => 0,
            9..=CAPACITY => touched.start.min(CAPACITY - width),
            _ => touched.start,
        };
        let shift = match order {
            _ if !is_number => 0,
            ByteOrder::Intel => start - 8 * first,
            ByteOrder::Motorola => 8 * (first + width) - (line_position(start) + len),
        };
        let mask = if is_number { u64::MAX >> (64 - len) } else { 0 };
        Some(Self { first, end: touched.end, len: len as u32, shift: shift as u32, mask, wide, order })
    }

    /// The bits as a number; those that `data` is too short for are 0.
    #[inline]
    pub fn load(&self, data: &[u8]) -> u64 {
        if self.wide {
            (self.to_u128(window(data, self.first)) >> self.shift) as u64 & self.mask
        } else {
            (self.to_u64(window(data, self.first)) >> self.shift) & self.mask
        }
    }

    /// Puts the lowest bits of `value` in place and leaves all others alone.
    /// Bits that `data` is too short for are not written.
    #[inline]
    pub fn store(&self, data: &mut [u8], value: u64) {
        let Some(window) = data.get_mut(self.first..) else { return };
        let value = value & self.mask;
        if self.wide {
            edit(window, |bytes| {
                let kept = self.to_u128(*bytes) & !(u128::from(self.mask) << self.shift);
                let word = kept | u128::from(value) << self.shift;
                *bytes = match self.order {
                    ByteOrder::Intel => word.to_le_bytes(),
                    ByteOrder::Motorola => word.to_be_bytes(),
                };
            });
        } else {
            edit(window, |bytes| {
                let word = self.to_u64(*bytes) & !(self.mask << self.shift) | value << self.shift;
                *bytes = match self.order {
                    ByteOrder::Intel => word.to_le_bytes(),
                    ByteOrder::Motorola => word.to_be_bytes(),
                };
            });
        }
    }

    /// How many bits there are.
    pub const fn len(&self) -> u32 {
        self.len
    }

    /// Where the window of eight bytes begins, how far right it moves, and as
    /// many ones as there are bits. Of no use when [`Self::is_wide`].
    pub const fn narrow_window(&self) -> (u32, u8, u64) {
        (self.first as u32, self.shift as u8, self.mask)
    }

    /// Whether no eight bytes hold all of them.
    pub const fn is_wide(&self) -> bool {
        self.wide || self.len > 64
    }

    /// How many bytes a message must have to hold all of them.
    pub const fn end(&self) -> usize {
        self.end
    }

    #[inline]
    fn to_u64(self, bytes: [u8; 8]) -> u64 {
        match self.order {
            ByteOrder::Intel => u64::from_le_bytes(bytes),
            ByteOrder::Motorola => u64::from_be_bytes(bytes),
        }
    }

    #[inline]
    fn to_u128(self, bytes: [u8; 16]) -> u128 {
        match self.order {
            ByteOrder::Intel => u128::from_le_bytes(bytes),
            ByteOrder::Motorola => u128::from_be_bytes(bytes),
        }
    }
}

/// The bytes that a signal touches, past the end of any frame perhaps;
/// `None` when it has no bits or too many to count.
pub(super) fn touched_bytes(start: usize, len: usize, order: ByteOrder) -> Option<Range<usize>> {
    let first_bit = match order {
        ByteOrder::Intel => start,
        ByteOrder::Motorola => line_position(start),
    };
    let last_bit = first_bit.checked_add(len.checked_sub(1)?)?;
    Some(first_bit / 8..last_bit / 8 + 1)
}

/// A DBC counts bits from the lowest of each byte; this counts from the
/// highest, in the order of a Motorola signal.
const fn line_position(bit: usize) -> usize {
    bit ^ 7
}

#[inline]
fn window<const N: usize>(data: &[u8], first: usize) -> [u8; N] {
    match data.get(first..).and_then(|rest| rest.first_chunk()) {
        Some(bytes) => *bytes,
        None => padded(data.get(first..).unwrap_or_default()),
    }
}

#[cold]
fn padded<const N: usize>(short: &[u8]) -> [u8; N] {
    let mut bytes = [0; N];
    bytes[..short.len()].copy_from_slice(short);
    bytes
}

/// Changes the first `N` bytes of `window`, or those there are of them.
#[inline]
fn edit<const N: usize>(window: &mut [u8], change: impl FnOnce(&mut [u8; N])) {
    if let Some(bytes) = window.first_chunk_mut() {
        change(bytes);
        return;
    }
    let mut bytes = [0; N];
    bytes[..window.len()].copy_from_slice(window);
    change(&mut bytes);
    window.copy_from_slice(&bytes[..window.len()]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_must_have_bits_and_lie_within_reach() {
        for (start, len, order) in [
            (0, 0, ByteOrder::Intel),
            (8 * LONGEST - 1, 2, ByteOrder::Intel),
            (8 * LONGEST - 8, 2, ByteOrder::Motorola),
            (0, usize::MAX, ByteOrder::Motorola),
            (usize::MAX, 64, ByteOrder::Intel),
        ] {
            assert_eq!(Bits::new(start, len, order), None, "{start}|{len} {order:?}");
        }
    }

    #[test]
    fn bits_past_a_short_buffer_are_not_written() {
        let bits = Bits::new(4, 16, ByteOrder::Intel).unwrap();
        let mut data = [0; 2];
        bits.store(&mut data, 0xFFFF);
        assert_eq!(data, [0xF0, 0xFF]);
        Bits::new(32, 8, ByteOrder::Intel).unwrap().store(&mut data, 0);
    }
    #[test]
    fn bits_past_a_frame_s_end_are_read_and_written_in_longer_messages() {
        for (start, len, order) in [(8 * 100 + 3, 64, ByteOrder::Intel), (8 * 63 + 2, 33, ByteOrder::Motorola)] {
            let bits = Bits::new(start, len, order).unwrap();
            let mut data = vec![0xFF; bits.end()];
            bits.store(&mut data, 0x0123_4567_89AB_CDEF);
            assert_eq!(bits.load(&data), 0x0123_4567_89AB_CDEF & (u64::MAX >> (64 - len)));
            assert_eq!(bits.load(&data[..64]) & !bits.load(&data), 0);
            bits.store(&mut data[..10], 0);
        }
    }

    #[test]
    fn more_bits_than_a_number_has_are_left_alone() {
        let bits = Bits::new(0, 1600, ByteOrder::Intel).unwrap();
        let mut data = [0xFF; 200];
        bits.store(&mut data, 0);
        assert_eq!((bits.load(&data), bits.end(), data), (0, 200, [0xFF; 200]));
    }
}
