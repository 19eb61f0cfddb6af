//! The usual signal, made ready for speed: a whole number that eight bytes of
//! the frame hold and an `f64` holds exactly. It takes no branch on what kind
//! of number it is; all others take the long way through [`Signal`].

use super::bits::ByteOrder;
use super::signal::{RawKind, Signal};

/// The most bits that are exact in an `f64`.
const EXACT_BITS: u32 = 53;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slot {
    mask: u64,
    factor: f64,
    offset: f64,
    /// The raw values have these for neighbours.
    below: f64,
    above: f64,
    /// First of the eight bytes.
    first: u32,
    /// A payload of so many bytes has the signal whatever switches say; none
    /// is long enough where it takes a closer look.
    always_from: u32,
    shift: u8,
    /// How far up the highest bit goes to be a sign, and down again.
    sign_shift: u8,
    is_motorola: bool,
    /// Whether a frame of zeros has the value that the signal starts with.
    pub starts_at_zero: bool,
    /// Whether all this is of use.
    is_usual: bool,
}

/// The first eight bytes of a payload, or those there are, as a little-endian
/// number.
#[derive(Clone, Copy, Default)]
pub(super) struct Head(u64);

impl Slot {
    pub fn new(signal: &Signal) -> Self {
        let (first, shift, mask) = signal.bits.narrow_window();
        let is_signed = signal.kind == RawKind::Signed;
        let unused = signal.unused_bits();
        let (least, most) = match is_signed {
            true => ((i64::MIN >> unused) as f64, (i64::MAX >> unused) as f64),
            false => (0.0, (u64::MAX >> unused) as f64),
        };
        let is_always_there = signal.selector.is_none() && !signal.is_wide();
        let fits = signal.bit_count() <= EXACT_BITS && !signal.bits.is_wide() && !signal.scale_exactly;
        Self {
            mask,
            factor: signal.factor,
            offset: signal.offset,
            below: least - 1.0,
            above: most + 1.0,
            first,
            always_from: if is_always_there { signal.end_byte() as u32 } else { u32::MAX },
            shift,
            sign_shift: if is_signed { unused as u8 } else { 0 },
            is_motorola: signal.byte_order == ByteOrder::Motorola,
            starts_at_zero: signal.start_value.is_none_or(|value| value.to_bits() == 0),
            is_usual: fits && !signal.is_float(),
        }
    }

    /// The physical value of `signal`, which this was made from, in `data`.
    #[inline]
    pub fn decode(&self, signal: &Signal, data: &[u8]) -> f64 {
        let window = data.get(self.first as usize..).and_then(|rest| rest.first_chunk());
        let (true, Some(bytes)) = (self.is_usual, window) else { return signal.decode(data) };
        let bits = self.oriented(u64::from_le_bytes(*bytes)) >> self.shift & self.mask;
        let raw = ((bits << self.sign_shift) as i64) >> self.sign_shift;
        raw as f64 * self.factor + self.offset
    }

    /// Whether a payload of `len` bytes has the signal for sure.
    #[inline]
    pub const fn is_there(&self, len: usize) -> bool {
        self.always_from as usize <= len
    }

    /// Puts the raw value that stands for `physical` in place, cut off towards
    /// 0 after `rounding` is added to its amount, unless that takes a closer
    /// look: false when the value is out of range, or the signal not a usual
    /// one in the first eight bytes.
    #[inline]
    pub fn encode(&self, head: &mut Head, physical: f64, rounding: f64) -> bool {
        let exact = (physical - self.offset) / self.factor;
        let rounded = exact + rounding.copysign(exact);
        // Not for NaN either.
        let holds = self.is_usual && self.first == 0 && rounded > self.below && rounded < self.above;
        if holds {
            let raw = rounded as i64 as u64;
            let word = self.oriented(head.0) & !(self.mask << self.shift) | (raw & self.mask) << self.shift;
            head.0 = self.oriented(word);
        }
        holds
    }

    /// From little-endian to the signal's order, and back.
    #[inline]
    const fn oriented(&self, word: u64) -> u64 {
        if self.is_motorola { word.swap_bytes() } else { word }
    }
}

impl Head {
    /// The first bytes of `payload`.
    pub fn read(payload: &[u8]) -> Self {
        let mut bytes = [0; 8];
        let len = payload.len().min(8);
        bytes[..len].copy_from_slice(&payload[..len]);
        Self(u64::from_le_bytes(bytes))
    }

    /// Puts them back.
    #[inline]
    pub fn write(&self, payload: &mut [u8]) {
        let bytes = self.0.to_le_bytes();
        match payload.first_chunk_mut() {
            Some(first) => *first = bytes,
            None => payload.copy_from_slice(&bytes[..payload.len()]),
        }
    }
}
