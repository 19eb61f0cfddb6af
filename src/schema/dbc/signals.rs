//! From an `SG_` statement, and what is said of it, to a signal.

use super::findings::Findings;
use super::notes::Notes;
use super::statements::{Object, Signal as Statement};
use crate::schema::bits::{Bits, ByteOrder};
use crate::schema::signal::{RawKind, Signal};

/// Whole numbers up to this are exact in an `f64`.
const EXACT: f64 = 9_007_199_254_740_992.0;

/// A statement on its way to be a signal.
pub(super) struct SignalReader<'r, 'f, 's> {
    pub notes: &'r Notes<'f>,
    pub findings: &'r mut Findings<'s>,
    /// The name of the message.
    pub message: &'r str,
    /// The message's id as the DBC writes it.
    pub id: u64,
}

impl<'f> SignalReader<'_, 'f, '_> {
    /// The signal, or nothing when it can have no value.
    pub fn read(&mut self, statement: &Statement<'f>) -> Option<Signal> {
        let object = Object::Signal(self.id, statement.name.is);
        let short_name = statement.name.is.to_owned();
        let name = self.notes.long_name(object).unwrap_or_else(|| short_name.clone());
        let shown = format!("{}.{name}", self.message);
        let &Statement { start, size, factor, offset, minimum, maximum, .. } = statement;
        let byte_order = if statement.is_motorola { ByteOrder::Motorola } else { ByteOrder::Intel };
        let Some(bits) = Bits::new(start, size, byte_order) else {
            let label = format!("found {size} bits from bit {start}, expected 1 bit or more inside a message");
            let hint = "it is passed over: a signal is laid out as START|BITS@ORDER";
            self.findings.error(&statement.layout, format!("{shown} has no usable size"), label, hint);
            return None;
        };
        if !factor.is_finite() || factor == 0.0 || !offset.is_finite() {
            let label = format!("found ({factor},{offset}), expected finite numbers, the factor not 0");
            let hint = "(1,0) leaves the raw number as it is";
            self.findings.error(&statement.scale, format!("{shown} has no usable factor and offset"), label, hint);
        }
        if minimum > maximum {
            let label = format!("found {minimum} above {maximum}");
            let hint = "it is taken to have no range: turn it round, or write [0|0]";
            self.findings.warn(&statement.range, format!("the range of {shown} is upside down"), label, hint);
        }
        let has_range = minimum <= maximum;
        let kind = self.kind(&shown, object, statement);
        Some(Signal {
            name,
            short_name,
            unit: statement.unit.is.clone(),
            comment: self.notes.comment(object),
            minimum: if has_range { minimum } else { 0.0 },
            maximum: if has_range { maximum } else { 0.0 },
            factor,
            offset,
            value_names: self.value_names(&shown, object, kind, size),
            start_value: self.notes.start_value(self.id, statement.name.is),
            selector: None,
            start_bit: start,
            byte_order,
            kind,
            bits,
            scale_exactly: needs_exact_scale(kind, size, factor, offset),
        })
    }

    /// How the bits make a number. The size tells the two kinds of
    /// floating-point apart; that is what other readers go by.
    fn kind(&mut self, shown: &str, object: Object<'_>, statement: &Statement<'_>) -> RawKind {
        let size = statement.size;
        let whole = if statement.is_signed { RawKind::Signed } else { RawKind::Unsigned };
        let number_type = self.notes.number_type(object);
        match (number_type, size) {
            (_, 65..) => {
                let label = format!("found {size} bits, expected at most 64");
                let hint = "it is passed over: cut it into signals of up to 64 bits";
                self.findings.warn(&statement.layout, format!("{shown} is too wide for a number"), label, hint);
                whole
            }
            (0, _) => whole,
            (1 | 2, 32 | 64) => {
                let kind = if size == 32 { RawKind::Float32 } else { RawKind::Float64 };
                if (number_type == 1) != (size == 32) {
                    let label = format!("found {size} bits, but SIG_VALTYPE_ {number_type}");
                    let hint = "the size is believed: 1 is for 32 bits, 2 for 64";
                    self.findings.warn(&statement.layout, format!("{shown} is a float of another size"), label, hint);
                }
                kind
            }
            (1 | 2, _) => {
                let label = format!("found {size} bits, expected {} as SIG_VALTYPE_ says", 32 * number_type);
                let hint = "correct the size, or take out its SIG_VALTYPE_";
                let title = format!("{shown} is floating-point of the wrong size");
                self.findings.error(&statement.layout, title, label, hint);
                whole
            }
            _ => {
                let label = format!("found SIG_VALTYPE_ {number_type} for it, expected 0, 1 or 2");
                let hint = "it is taken for a whole number";
                self.findings.warn(&statement.layout, format!("{shown} has a type that nobody knows"), label, hint);
                whole
            }
        }
    }

    /// The names of raw values. A value that is named twice has the last name.
    fn value_names(&mut self, shown: &str, object: Object<'_>, kind: RawKind, size: usize) -> Vec<(i64, String)> {
        let Some(given) = self.notes.value_names(object) else { return Vec::new() };
        let mut names: Vec<(i64, String)> = Vec::new();
        for (value, name) in given {
            if !can_hold(kind, size, value.is) {
                let label = format!("found {}, which {size} bits do not hold", value.is);
                let hint = "no frame will ever say it: take it out, or correct it";
                self.findings.warn(&value.span, format!("{shown} cannot have this value"), label, hint);
            }
            // As 64 bits, however their sign is read.
            let raw = i64::try_from(value.is).or_else(|_| u64::try_from(value.is).map(|raw| raw as i64));
            let Ok(raw) = raw else { continue };
            match names.iter_mut().find(|(known, _)| *known == raw) {
                Some((_, known)) => {
                    let label = format!("found {}, which is `{known}` already", value.is);
                    let hint = "the last name is believed: take the other out";
                    self.findings.warn(&value.span, format!("a value of {shown} is named twice"), label, hint);
                    known.clone_from(name);
                }
                None => names.push((raw, name.clone())),
            }
        }
        names
    }
}

/// Whether a signal can have this raw value.
fn can_hold(kind: RawKind, size: usize, value: i128) -> bool {
    let size = size.min(64);
    match kind {
        RawKind::Unsigned => (0..1_i128 << size).contains(&value),
        RawKind::Signed => (-(1_i128 << (size - 1))..1_i128 << (size - 1)).contains(&value),
        RawKind::Float32 | RawKind::Float64 => i64::try_from(value).is_ok(),
    }
}

/// Whether whole numbers on the way from raw to physical may be too large for
/// an `f64`.
fn needs_exact_scale(kind: RawKind, size: usize, factor: f64, offset: f64) -> bool {
    let is_whole = |number: f64| number.trunc() == number && number.abs() < EXACT;
    let largest = libm::ldexp(factor.abs(), size.min(64) as i32) + offset.abs();
    matches!(kind, RawKind::Unsigned | RawKind::Signed)
        && is_whole(factor)
        && is_whole(offset)
        && largest > EXACT
        && (factor, offset) != (1.0, 0.0)
}
