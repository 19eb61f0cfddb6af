//! How a value becomes the raw number of a signal: rounding, range, and what
//! can be wrong with it.

use thiserror::Error;

use super::signal::{BELOW_HALF, Raw, RawKind, Signal};
use crate::config::nearest;

/// A value to be encoded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'v> {
    /// In the signal's unit.
    Physical(f64),
    /// As the bits hold it: whole numbers of 64 bits lose nothing.
    Raw(Raw),
    /// By its name in the signal's value table.
    Name(&'v str),
}

/// How to encode what the bits cannot hold exactly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Encoding {
    /// Values between two raw ones.
    pub rounding: Rounding,
    /// Values that are too small or too large.
    pub out_of_range: OutOfRange,
    /// What is too small or too large.
    pub within: Within,
}

/// Which of the two raw numbers around `(physical - offset) / factor` it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rounding {
    /// The nearer one; of two as near, the one farther from 0.
    #[default]
    Nearest,
    /// The one nearer to 0, as drive makers' code does:
    /// `(int)((x - x_min) * (2^n - 1) / span)`.
    TowardsZero,
}

/// What becomes of a value that is too small or too large.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OutOfRange {
    /// [`EncodeError::OutOfRange`].
    #[default]
    Refuse,
    /// The nearest value that there is; 0 raw for NaN.
    Saturate,
}

/// What a value must keep to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Within {
    /// What the signal's bits can hold.
    #[default]
    Bits,
    /// The minimum and maximum of the DBC besides, where it gives any. A value
    /// that has a name is always within.
    Limits,
}

/// Why values make no frame.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EncodeError {
    /// A name that the message does not have.
    #[error("{message} has no signal `{signal}`{}", did_you_mean(nearest))]
    UnknownSignal {
        /// Of the message.
        message: String,
        /// As given.
        signal: String,
        /// The name most like it.
        nearest: Option<String>,
    },
    /// A name that the value table does not have.
    #[error("{signal} has no value named `{name}`{}", did_you_mean(nearest))]
    UnknownName {
        /// Of the signal.
        signal: String,
        /// As given.
        name: String,
        /// The name most like it.
        nearest: Option<String>,
    },
    /// Too small, too large, or no number.
    #[error("{signal} cannot be {value}{unit}, expected {minimum} to {maximum}{unit}")]
    OutOfRange {
        /// Of the signal.
        signal: String,
        /// As given, in the signal's unit.
        value: f64,
        /// Least, in the signal's unit.
        minimum: f64,
        /// Greatest, in the signal's unit.
        maximum: f64,
        /// The unit, after a blank; empty when it has none.
        unit: String,
    },
    /// The value of a multiplexer switch keeps the signal out of the frame.
    #[error("{signal} is not in the frame when {switch} is {value}")]
    NotSelected {
        /// Of the signal.
        signal: String,
        /// Of the switch.
        switch: String,
        /// Of the switch, raw.
        value: u64,
    },
    /// More than 64 bits make no number.
    #[error("{signal} has {bits} bits, more than a number has")]
    TooWide {
        /// Of the signal.
        signal: String,
        /// How many it has.
        bits: u32,
    },
    /// There is no room.
    #[error("{message} needs {expected} bytes, found room for {found}")]
    NoRoom {
        /// Of the message.
        message: String,
        /// Bytes of the message.
        expected: usize,
        /// Bytes of the payload to be written, or of the longest frame.
        found: usize,
    },
}

impl Signal {
    /// The raw value that stands for `value`, one that the bits can hold.
    #[inline]
    pub fn quantise(&self, value: Value<'_>, how: Encoding) -> Result<Raw, EncodeError> {
        let raw = match value {
            Value::Raw(raw) => raw,
            Value::Name(name) => self.value_named(name).ok_or_else(|| self.unknown_name(name))?,
            Value::Physical(physical) => {
                let exact = (physical - self.offset) / self.factor;
                Raw::Real(if self.is_float() { exact } else { how.rounding.apply(exact) })
            }
        };
        let (least, most) = self.raw_range(how.within);
        let number = raw.as_f64();
        // Between the ends, or in a float beyond all of them.
        let holds = number >= least && number <= most || self.is_float() && !number.is_finite();
        if holds && self.holds(raw) {
            return Ok(raw);
        }
        if how.within == Within::Limits && self.is_named(raw) && self.holds(raw) {
            return Ok(raw);
        }
        match how.out_of_range {
            OutOfRange::Refuse => Err(self.out_of_range(value, raw, least, most)),
            OutOfRange::Saturate if number.is_nan() => Ok(Raw::Real(0.0)),
            OutOfRange::Saturate if how.within == Within::Bits => Ok(raw),
            OutOfRange::Saturate => Ok(Raw::Real(number.clamp(least, most))),
        }
    }

    /// Writes a value of any sort, or what the signal starts with.
    #[inline(never)]
    pub(super) fn encode_with_care(
        &self,
        payload: &mut [u8],
        value: Option<Value<'_>>,
        how: Encoding,
    ) -> Result<(), EncodeError> {
        let raw = match value {
            Some(value) => self.quantise(value, how)?,
            None => Raw::Real(self.start_value.unwrap_or(0.0)),
        };
        self.encode_raw(payload, raw);
        Ok(())
    }

    /// Least and greatest raw value, as far as an `f64` can tell.
    fn raw_range(&self, within: Within) -> (f64, f64) {
        let unused = self.unused_bits();
        let (least, most) = match self.kind {
            RawKind::Unsigned => (0.0, (u64::MAX >> unused) as f64),
            RawKind::Signed => ((i64::MIN >> unused) as f64, (i64::MAX >> unused) as f64),
            RawKind::Float32 => (f64::from(f32::MIN), f64::from(f32::MAX)),
            RawKind::Float64 => (f64::MIN, f64::MAX),
        };
        if within == Within::Bits || self.minimum >= self.maximum {
            return (least, most);
        }
        // A limit need not be a raw value; half a step beyond it is still it.
        let limit = |physical: f64| {
            let raw = (physical - self.offset) / self.factor;
            if self.is_float() { raw } else { raw.round() }
        };
        let (one, other) = (limit(self.minimum), limit(self.maximum));
        (least.max(one.min(other)), most.min(one.max(other)))
    }

    /// Whether the bits can hold `raw`, where an `f64` cannot tell.
    #[inline]
    fn holds(&self, raw: Raw) -> bool {
        match (self.kind, raw) {
            (RawKind::Unsigned, Raw::Real(raw)) => raw < 18_446_744_073_709_551_616.0,
            (RawKind::Signed, Raw::Real(raw)) => raw < 9_223_372_036_854_775_808.0,
            (RawKind::Unsigned, Raw::Signed(raw)) => raw >= 0,
            (RawKind::Signed, Raw::Unsigned(raw)) => i64::try_from(raw).is_ok(),
            _ => true,
        }
    }

    fn is_named(&self, raw: Raw) -> bool {
        let number = raw.as_f64();
        self.value_names.iter().any(|(value, _)| *value as f64 == number)
    }

    #[cold]
    fn unknown_name(&self, name: &str) -> EncodeError {
        let names = self.value_names.iter().map(|(_, name)| name.as_str());
        EncodeError::UnknownName {
            signal: self.name.clone(),
            name: name.to_owned(),
            nearest: nearest(name, names).map(str::to_owned),
        }
    }

    #[cold]
    fn out_of_range(&self, given: Value<'_>, raw: Raw, least: f64, most: f64) -> EncodeError {
        let value = if let Value::Physical(physical) = given { physical } else { self.physical(raw) };
        let (one, other) = (self.physical(Raw::Real(least)), self.physical(Raw::Real(most)));
        EncodeError::OutOfRange {
            signal: self.name.clone(),
            value,
            minimum: one.min(other),
            maximum: one.max(other),
            unit: if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) },
        }
    }
}

impl Rounding {
    /// What makes it of a cut towards 0 when it is added to the amount.
    #[inline]
    pub(super) const fn before_cut(self) -> f64 {
        match self {
            Self::Nearest => BELOW_HALF,
            Self::TowardsZero => 0.0,
        }
    }

    #[inline]
    fn apply(self, exact: f64) -> f64 {
        match self {
            Self::Nearest => exact.round(),
            Self::TowardsZero => exact.trunc(),
        }
    }
}

impl From<f64> for Value<'_> {
    fn from(physical: f64) -> Self {
        Self::Physical(physical)
    }
}

impl<'v> From<&'v str> for Value<'v> {
    fn from(name: &'v str) -> Self {
        Self::Name(name)
    }
}

fn did_you_mean(nearest: &Option<String>) -> String {
    nearest.as_ref().map_or_else(String::new, |name| format!("; did you mean `{name}`?"))
}
