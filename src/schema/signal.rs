//! A signal: a number in some bits of a frame, with its unit and scale.

use std::ops::RangeInclusive;

use super::bits::{Bits, ByteOrder};

/// One signal of a message.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Name, unique in its message: the long one where the DBC gives one
    /// (`SystemSignalLongSymbol`).
    pub name: String,
    /// The name in the DBC's `SG_` statement, cut to 32 characters by some
    /// tools.
    pub short_name: String,
    /// Unit as the DBC writes it; empty when it has none.
    pub unit: String,
    /// What it means (`CM_`); empty when the DBC does not say.
    pub comment: String,
    /// Least physical value that makes sense; equal to `maximum` when the DBC
    /// gives no range.
    pub minimum: f64,
    /// Greatest physical value that makes sense.
    pub maximum: f64,
    /// Physical value of one raw step. Finite and not 0, unless the DBC was
    /// read in spite of its errors.
    pub factor: f64,
    /// Physical value of raw 0; finite.
    pub offset: f64,
    /// Names of raw values (`VAL_`), in the DBC's order, none named twice.
    /// Those of an unsigned signal beyond `i64::MAX` are here as the negative
    /// number of the same 64 bits.
    pub value_names: Vec<(i64, String)>,
    /// The raw value before anybody has set one (`GenSigStartValue`).
    pub start_value: Option<f64>,
    /// When a frame carries it; always, if it is not multiplexed.
    pub selector: Option<Selector>,
    /// Start bit as the DBC counts: the lowest bit of an Intel signal, the
    /// highest of a Motorola one.
    pub start_bit: usize,
    /// Which end comes first.
    pub byte_order: ByteOrder,
    /// How the raw bits are to be read.
    pub kind: RawKind,
    pub(super) bits: Bits,
    /// Whether `f64` is too narrow for what happens between raw and physical.
    pub(super) scale_exactly: bool,
}

/// Which values of a multiplexer switch bring a signal into a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selector {
    /// The switch, as an index into the message's signals.
    pub switch: usize,
    /// Raw values of the switch, its bits read without a sign.
    pub values: Vec<RangeInclusive<u64>>,
}

/// How the bits of a signal make a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RawKind {
    /// A whole number from 0.
    Unsigned,
    /// A whole number in two's complement.
    Signed,
    /// IEEE 754 binary32, `SIG_VALTYPE_ 1`.
    Float32,
    /// IEEE 754 binary64, `SIG_VALTYPE_ 2`.
    Float64,
}

/// What the bits of a signal hold, before factor and offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Raw {
    /// From an unsigned signal.
    Unsigned(u64),
    /// From a signed signal.
    Signed(i64),
    /// From a floating-point signal.
    Real(f64),
}

impl Signal {
    /// How many bits it has, 1 or more.
    pub const fn bit_count(&self) -> u32 {
        self.bits.len()
    }

    /// Whether it has more than 64 bits, a text perhaps. That is no number: it
    /// reads as raw 0, is never written, and messages pass it over.
    pub const fn is_wide(&self) -> bool {
        self.bit_count() > 64
    }

    /// Bits that a `u64` has more than this signal.
    pub(super) const fn unused_bits(&self) -> u32 {
        64_u32.saturating_sub(self.bit_count())
    }

    /// How many bytes a payload must have to hold all of it.
    pub const fn end_byte(&self) -> usize {
        self.bits.end()
    }

    /// Whether the physical value is the raw whole number itself.
    pub fn is_integer(&self) -> bool {
        self.factor == 1.0 && self.offset == 0.0 && !self.is_float()
    }

    /// Whether the raw value is floating-point.
    pub const fn is_float(&self) -> bool {
        matches!(self.kind, RawKind::Float32 | RawKind::Float64)
    }

    /// Where it lies and how it is scaled, as a DBC writes it, such as
    /// `0|16@1- (0.005,0)`.
    pub fn layout(&self) -> String {
        let order = if self.byte_order == ByteOrder::Intel { 1 } else { 0 };
        let sign = if self.kind == RawKind::Unsigned { '+' } else { '-' };
        let float = if self.is_float() { " float" } else { "" };
        format!("{}|{}@{order}{sign} ({},{}){float}", self.start_bit, self.bit_count(), self.factor, self.offset,)
    }

    /// The raw value in `data`, a payload or the storage of a frame. Bits that
    /// `data` is too short for are 0.
    #[inline]
    pub fn decode_raw(&self, data: &[u8]) -> Raw {
        let bits = self.bits.load(data);
        match self.kind {
            RawKind::Unsigned => Raw::Unsigned(bits),
            RawKind::Signed => Raw::Signed(self.sign_extend(bits)),
            RawKind::Float32 => Raw::Real(f64::from(f32::from_bits(bits as u32))),
            RawKind::Float64 => Raw::Real(f64::from_bits(bits)),
        }
    }

    /// The physical value in `data`: `raw * factor + offset`, each step
    /// rounded to `f64`; rounded once where both are whole numbers.
    #[inline]
    pub fn decode(&self, data: &[u8]) -> f64 {
        self.physical(self.decode_raw(data))
    }

    /// The physical value that `raw` stands for.
    #[inline]
    pub fn physical(&self, raw: Raw) -> f64 {
        if self.scale_exactly { self.scaled_exactly(raw) } else { raw.as_f64() * self.factor + self.offset }
    }

    /// The name of the raw value in `data`, if the DBC gives it one.
    pub fn decode_name(&self, data: &[u8]) -> Option<&str> {
        let raw = match self.decode_raw(data) {
            Raw::Unsigned(raw) => raw as i64,
            Raw::Signed(raw) => raw,
            Raw::Real(raw) if raw.trunc() == raw && raw.abs() < 1e15 => raw as i64,
            Raw::Real(_) => return None,
        };
        self.value_names.iter().find(|(value, _)| *value == raw).map(|(_, name)| name.as_str())
    }

    /// The raw value that the DBC gives this name.
    pub fn value_named(&self, name: &str) -> Option<Raw> {
        let (value, _) = self.value_names.iter().find(|(_, known)| known == name)?;
        Some(if self.kind == RawKind::Unsigned { Raw::Unsigned(*value as u64) } else { Raw::Signed(*value) })
    }

    /// Writes the raw value nearest to `physical`, halves away from zero.
    /// What the bits cannot hold becomes the nearest value that they can; NaN
    /// becomes raw 0 in a whole-number signal. No other bit changes, and bits
    /// that `data` is too short for are not written.
    #[inline]
    pub fn encode(&self, data: &mut [u8], physical: f64) {
        self.encode_raw(data, Raw::Real((physical - self.offset) / self.factor));
    }

    /// Writes `raw`, as [`Self::encode`] does but before factor and offset.
    #[inline]
    pub fn encode_raw(&self, data: &mut [u8], raw: Raw) {
        self.bits.store(data, self.to_bits(raw));
    }

    /// The bits themselves, as a number.
    #[inline]
    pub(super) fn decode_bits(&self, data: &[u8]) -> u64 {
        self.bits.load(data)
    }

    /// Writes the lowest bits of `value`.
    #[inline]
    pub(super) fn encode_bits(&self, data: &mut [u8], value: u64) {
        self.bits.store(data, value);
    }

    /// What a counter of this width shows after `counter`.
    pub(super) const fn next_counter(&self, counter: u8) -> u8 {
        self.low_bits(counter.wrapping_add(1))
    }

    /// What of `counter` this signal has bits for.
    pub(super) const fn low_bits(&self, counter: u8) -> u8 {
        counter & (u64::MAX >> self.unused_bits()) as u8
    }

    #[inline]
    fn to_bits(&self, raw: Raw) -> u64 {
        let unused = self.unused_bits();
        match self.kind {
            RawKind::Unsigned => raw.to_u64().min(u64::MAX >> unused),
            RawKind::Signed => raw.to_i64().clamp(i64::MIN >> unused, i64::MAX >> unused) as u64,
            RawKind::Float32 => u64::from(to_f32(raw.as_f64()).to_bits()),
            RawKind::Float64 => raw.as_f64().to_bits(),
        }
    }

    /// As [`Self::physical`], for large whole numbers.
    #[cold]
    fn scaled_exactly(&self, raw: Raw) -> f64 {
        let raw = match raw {
            Raw::Unsigned(raw) => i128::from(raw),
            Raw::Signed(raw) => i128::from(raw),
            Raw::Real(raw) => return raw * self.factor + self.offset,
        };
        (raw * self.factor as i128 + self.offset as i128) as f64
    }

    #[inline]
    pub(super) const fn sign_extend(&self, bits: u64) -> i64 {
        let unused = self.unused_bits();
        ((bits << unused) as i64) >> unused
    }
}

impl Raw {
    /// The nearest `f64`.
    #[inline]
    pub const fn as_f64(self) -> f64 {
        match self {
            Self::Unsigned(raw) => raw as f64,
            Self::Signed(raw) => raw as f64,
            Self::Real(raw) => raw,
        }
    }

    /// The nearest whole number from 0; 0 for NaN.
    #[inline]
    fn to_u64(self) -> u64 {
        match self {
            Self::Unsigned(raw) => raw,
            Self::Signed(raw) => u64::try_from(raw).unwrap_or(0),
            Self::Real(raw) if raw >= TWO_TO_THE_63 => raw as u64,
            Self::Real(raw) => nearest_whole(raw).max(0) as u64,
        }
    }

    /// The nearest whole number; 0 for NaN.
    #[inline]
    fn to_i64(self) -> i64 {
        match self {
            Self::Unsigned(raw) => i64::try_from(raw).unwrap_or(i64::MAX),
            Self::Signed(raw) => raw,
            Self::Real(raw) => nearest_whole(raw),
        }
    }
}

/// What makes a cut towards 0 a rounding when it is added to the amount. 0.5
/// itself would lift the number below 0.5 to 1; where this is too little, the
/// sum is rounded up.
pub(super) const BELOW_HALF: f64 = 0.5_f64.next_down();

const TWO_TO_THE_63: f64 = 9_223_372_036_854_775_808.0;

/// The nearest whole number, halves away from zero; 0 for NaN. As
/// `f64::round`, which is a call into the system where the processor is not
/// known to have an instruction for it.
#[inline]
const fn nearest_whole(number: f64) -> i64 {
    (number + BELOW_HALF.copysign(number)) as i64
}

/// The nearest `f32`; a finite number stays finite.
#[inline]
fn to_f32(value: f64) -> f32 {
    if value.is_finite() { value.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32 } else { value as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_whole_number_is_that_of_round() {
        for number in [0.0, 0.49999999999999994, 0.5, 1.5, 2.5, 4503599627370495.5, 4503599627370497.0, 1e18, 1e300] {
            for number in [number, -number] {
                assert_eq!(nearest_whole(number), number.round() as i64, "{number}");
            }
        }
        assert_eq!(nearest_whole(f64::NAN), 0);
        assert_eq!(nearest_whole(f64::INFINITY), i64::MAX);
    }
}
