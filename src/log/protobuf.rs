//! Protobuf messages, written straight into a chunk and read again: a field is a
//! tag and a value. What there is is written, zeros too, because some viewers take a
//! field that is missing for a gap in the signal; and a signal that a frame
//! does not carry is one.

use prost_types::field_descriptor_proto::Type;

use crate::frame::{Frame, FrameKind};
use crate::schema::{MessageLayout, Raw, RawKind, Signal};
use crate::time::Instant;

/// Fields of `canloop.CanFdFrame`, in the order of [`put_fd_frame`].
pub(super) const FD_FRAME_FIELDS: [(&str, Type); 6] = [
    ("id", Type::Uint32),
    ("is_extended", Type::Bool),
    ("bit_rate_switch", Type::Bool),
    ("sent_by_stack", Type::Bool),
    ("data", Type::Bytes),
    ("error_state_indicator", Type::Bool),
];

/// Fields of `canloop.Lost`: frames lost before a moment, and until then in all.
pub(super) const LOST_FIELDS: [(&str, Type); 2] = [("frames", Type::Uint64), ("total", Type::Uint64)];

/// Severity of a line in `foxglove.Log`.
#[derive(Clone, Copy)]
pub(super) enum Level {
    Info = 2,
    Error = 4,
}

const VARINT: u64 = 0;
const FIXED64: u64 = 1;
const LENGTH_DELIMITED: u64 = 2;
const FIXED32: u64 = 5;

/// The protobuf type that holds every value of `signal`: whole numbers that
/// the DBC does not scale stay whole, all else is a double.
pub(super) fn field_type(signal: &Signal) -> Type {
    match signal.kind {
        _ if !signal.is_integer() => Type::Double,
        RawKind::Signed => Type::Sint64,
        _ => Type::Uint64,
    }
}

/// Appends the signals that a frame carries, fields numbered from 1 as in
/// `layout` and of the types that [`field_type`] gives.
pub(super) fn put_signals(out: &mut Vec<u8>, layout: &MessageLayout, frame: &Frame) {
    let data = frame.storage();
    for (index, signal) in layout.carried(frame) {
        let number = index as u64 + 1;
        match (signal.is_integer(), signal.decode_raw(data)) {
            (true, Raw::Unsigned(value)) => put_unsigned(out, number, value),
            (true, Raw::Signed(value)) => put_unsigned(out, number, zigzag(value)),
            _ => put_double(out, number, signal.decode(data)),
        }
    }
}

/// Appends numbers as doubles, fields numbered from 1.
pub(super) fn put_doubles(out: &mut Vec<u8>, values: &[f64]) {
    (1..).zip(values).for_each(|(number, &value)| put_double(out, number, value));
}

/// Appends a `canloop.CanFdFrame`.
pub(super) fn put_fd_frame(out: &mut Vec<u8>, frame: &Frame, sent_by_stack: bool, error_passive: bool) {
    put_unsigned(out, 1, u64::from(frame.id.raw()));
    put_unsigned(out, 2, u64::from(frame.id.is_extended()));
    put_unsigned(out, 3, u64::from(frame.kind == FrameKind::FdBitRateSwitch));
    put_unsigned(out, 4, u64::from(sent_by_stack));
    put_bytes(out, 5, frame.payload());
    put_unsigned(out, 6, u64::from(error_passive));
}

/// Appends a `foxglove.Log`.
pub(super) fn put_log(out: &mut Vec<u8>, at: Instant, level: Level, name: &str, text: &str) {
    let mut timestamp = Vec::new();
    put_unsigned(&mut timestamp, 1, at.as_nanos().div_euclid(1_000_000_000) as u64);
    put_unsigned(&mut timestamp, 2, at.as_nanos().rem_euclid(1_000_000_000) as u64);
    put_bytes(out, 1, &timestamp);
    put_unsigned(out, 2, level as u64);
    put_bytes(out, 3, text.as_bytes());
    put_bytes(out, 4, name.as_bytes());
    put_bytes(out, 5, b"");
    put_varint(out, 6 << 3 | FIXED32);
    out.extend_from_slice(&[0; 4]);
}

fn put_double(out: &mut Vec<u8>, number: u64, value: f64) {
    let tag = number << 3 | FIXED64;
    if tag < 0x80 {
        // The usual case in one copy: this is the most frequent thing a log does.
        let mut field = [tag as u8; 9];
        field[1..].copy_from_slice(&value.to_le_bytes());
        out.extend_from_slice(&field);
    } else {
        put_varint(out, tag);
        out.extend_from_slice(&value.to_le_bytes());
    }
}

pub(super) fn put_unsigned(out: &mut Vec<u8>, number: u64, value: u64) {
    put_varint(out, number << 3 | VARINT);
    put_varint(out, value);
}

pub(super) fn put_bytes(out: &mut Vec<u8>, number: u64, bytes: &[u8]) {
    put_varint(out, number << 3 | LENGTH_DELIMITED);
    put_varint(out, bytes.len() as u64);
    out.extend_from_slice(bytes);
}

/// Appends a whole number that always takes eight bytes.
pub(super) fn put_fixed(out: &mut Vec<u8>, number: u64, value: i64) {
    put_varint(out, number << 3 | FIXED64);
    out.extend_from_slice(&value.to_le_bytes());
}

/// Seven bits a byte, lowest first; the top bit says that more follow.
fn put_varint(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

/// The order 0, -1, 1, -2, 2, ... that keeps small negative numbers short.
const fn zigzag(value: i64) -> u64 {
    ((value << 1) ^ (value >> 63)) as u64
}

/// What a field holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Value<'m> {
    /// A whole number of any length.
    Number(u64),
    /// Eight bytes, as a double or as a whole number.
    Fixed(u64),
    /// Text, or bytes.
    Bytes(&'m [u8]),
}

/// Gives each field's number and value, but for those of four bytes, which no
/// message here has to be understood by.
pub(crate) fn read_fields<'m>(mut rest: &'m [u8], mut take: impl FnMut(u64, Value<'m>)) -> Result<(), &'static str> {
    while !rest.is_empty() {
        let tag = varint(&mut rest).ok_or(SHORT)?;
        match (tag >> 3, tag & 7) {
            (number, VARINT) => take(number, Value::Number(varint(&mut rest).ok_or(SHORT)?)),
            (number, LENGTH_DELIMITED) => {
                let len = usize::try_from(varint(&mut rest).ok_or(SHORT)?).map_err(|_| SHORT)?;
                let (value, behind) = rest.split_at_checked(len).ok_or(SHORT)?;
                rest = behind;
                take(number, Value::Bytes(value));
            }
            (number, FIXED64) => {
                let (value, behind) = rest.split_first_chunk().ok_or(SHORT)?;
                rest = behind;
                take(number, Value::Fixed(u64::from_le_bytes(*value)));
            }
            (_, FIXED32) => rest = rest.get(4..).ok_or(SHORT)?,
            _ => return Err("a message is not in protobuf"),
        }
    }
    Ok(())
}

const SHORT: &str = "a message is shorter than its schema says";

/// Seven bits a byte, lowest first.
fn varint(rest: &mut &[u8]) -> Option<u64> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let (byte, behind) = rest.split_first()?;
        *rest = behind;
        value |= u64::from(byte & 0x7F) << shift;
        if byte & 0x80 == 0 {
            return Some(value);
        }
    }
    None
}
