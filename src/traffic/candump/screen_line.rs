//! The screen form behind its stamp, if it has one:
//! `can0  TX - -  123   [8]  11 22 33 44 55 66 77 88   '."3DUfw.'`.

use super::data::{Id, error, id};
use super::index;
use crate::frame::{CanId, Frame};
use crate::traffic::socketcan::{self, can_id};
use crate::traffic::words::{LineProblem, Word, Words, shown};
use crate::traffic::{Buses, Content, Direction, number};

/// What -x shows of a frame.
#[derive(Default)]
struct Extra {
    direction: Direction,
    bit_rate_switch: bool,
    error_passive: bool,
}

/// What is in brackets before the data.
enum Length {
    /// `[8]`
    Classic(usize),
    /// `{C}`, with -8
    Code(u8),
    /// `[08]`
    Fd(usize),
}

/// The rest of a line.
pub(super) fn frame(words: &mut Words<'_>, buses: &mut Buses) -> Result<(u16, Direction, Content), LineProblem> {
    let name = words.expect("the name of a bus")?;
    let mut word = words.expect("an id")?;
    let mut extra = Extra::default();
    if let b"RX" | b"TX" = word.text {
        extra.direction = if word.text == b"TX" { Direction::Sent } else { Direction::Received };
        extra.bit_rate_switch = words.expect("B or -")?.text == b"B";
        extra.error_passive = words.expect("E or -")?.text == b"E";
        word = words.expect("an id")?;
    }
    let content = match id(word.text, word.column)? {
        Id::Error(class) => {
            let length = length(words.expect("a length, as in [8]")?)?;
            error(class, &data(words, &length)?)
        }
        Id::Frame(id) => behind_id(id, words, &extra)?,
    };
    Ok((index(buses, name.text, name.column)?, extra.direction, content))
}

/// `<0x18eeff01> [8] 05 a0 be 1c 00 a0 a0 c0`, of a candump of old.
pub(super) fn with_id_in_brackets(line: &[u8]) -> Result<Content, LineProblem> {
    let mut words = Words::of(line);
    let word = words.expect("an id")?;
    let digits = word.text.strip_prefix(b"<0x").and_then(|rest| rest.strip_suffix(b">"));
    let digits = digits.ok_or_else(|| word.problem("an id, as in <0x123>"))?;
    let raw = number::hex(digits).ok_or_else(|| word.problem("an id, as in <0x123>"))?;
    let id = can_id(raw, digits.len() > 3).ok_or_else(|| word.problem("an id of at most 29 bits"))?;
    behind_id(id, &mut words, &Extra::default())
}

fn behind_id(id: CanId, words: &mut Words<'_>, extra: &Extra) -> Result<Content, LineProblem> {
    let word = words.expect("a length, as in [8]")?;
    let length = length(word)?;
    if words.rest().starts_with(b"remote request") {
        let dlc = match length {
            Length::Classic(len) | Length::Fd(len) => len as u8,
            Length::Code(dlc) => dlc,
        };
        return Ok(Content::Frame(socketcan::with_dlc(id, true, dlc.min(15), &[])));
    }
    let data = data(words, &length)?;
    let recorded = match length {
        Length::Classic(_) => socketcan::classic(id, &data),
        Length::Code(dlc) => Some(socketcan::with_dlc(id, false, dlc, &data)),
        Length::Fd(_) => socketcan::fd(id, extra.bit_rate_switch, extra.error_passive, &data),
    };
    recorded.map(Content::Frame).ok_or_else(|| word.problem("a length that a frame can have"))
}

fn length(word: Word<'_>) -> Result<Length, LineProblem> {
    let wanted = "a length, as in [8]";
    let length = match word.text {
        [b'[', digit, b']'] => number::decimal(&[*digit]).map(|len| Length::Classic(len as usize)),
        [b'[', digits @ .., b']'] => number::decimal(digits).map(|len| Length::Fd(len as usize)),
        [b'{', digit, b'}'] => number::nibble(*digit).map(Length::Code),
        _ => None,
    };
    let fits = |length: &Length| match length {
        Length::Classic(len) => *len <= 8,
        Length::Fd(len) => *len <= Frame::CAPACITY,
        Length::Code(_) => true,
    };
    length.filter(fits).ok_or_else(|| word.problem(wanted))
}

/// As many bytes as the length says; what follows is for people. With -S they
/// stand in the opposite order with a mark between them, with -i in binary.
fn data(words: &mut Words<'_>, length: &Length) -> Result<Vec<u8>, LineProblem> {
    let count = match *length {
        Length::Classic(len) | Length::Fd(len) => len,
        Length::Code(dlc) => usize::from(dlc.min(8)),
    };
    if count > 1 && words.clone().next().is_some_and(|word| word.text.contains(&b'`')) {
        return swapped(words.expect("data")?, count);
    }
    let mut data = Vec::with_capacity(count);
    for _ in 0..count {
        let word = words.expect("another byte of data")?;
        data.push(byte(word.text).ok_or_else(|| word.problem("a byte, as in 7F"))?);
    }
    Ok(data)
}

fn swapped(word: Word<'_>, count: usize) -> Result<Vec<u8>, LineProblem> {
    let bytes: Option<Vec<u8>> = word.text.split(|&byte| byte == b'`').rev().map(byte).collect();
    match bytes {
        Some(bytes) if bytes.len() == count => Ok(bytes),
        _ => Err(LineProblem::new(word.column, format!("found `{}`, expected {count} bytes", shown(word.text)))),
    }
}

fn byte(text: &[u8]) -> Option<u8> {
    match text {
        [high, low] => Some(number::nibble(*high)? << 4 | number::nibble(*low)?),
        bits if bits.len() == 8 => bits.iter().try_fold(0, |byte: u8, bit| match bit {
            b'0' | b'1' => Some(byte << 1 | (bit - b'0')),
            _ => None,
        }),
        _ => None,
    }
}
