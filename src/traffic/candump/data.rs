//! Hexadecimal data and ids as both forms write them.

use crate::frame::Frame;
use crate::traffic::number;
use crate::traffic::socketcan::{can_id, error_in};
use crate::traffic::words::{LineProblem, Word};
use crate::traffic::{Content, ErrorFrame};

use crate::frame::CanId;

/// What an id says.
pub(super) enum Id {
    Frame(CanId),
    /// An error frame's classes, with its flag.
    Error(u32),
}

/// Up to three digits are 11 bits; eight are 29, or an error.
pub(super) fn id(digits: &[u8], column: u64) -> Result<Id, LineProblem> {
    let wanted = "an id of three or eight hexadecimal digits";
    let word = Word { text: digits, column };
    let raw = number::hex(digits).ok_or_else(|| word.problem(wanted))?;
    if digits.len() == 8 && raw >> 29 == ErrorFrame::FLAG >> 29 {
        return Ok(Id::Error(raw));
    }
    can_id(raw, digits.len() > 3).map(Id::Frame).ok_or_else(|| word.problem(wanted))
}

/// An error frame of these classes.
pub(super) fn error(word: u32, data: &[u8]) -> Content {
    Content::Error(error_in(word, data).unwrap_or(ErrorFrame::UNSPECIFIED))
}

/// Bytes, with or without points between them, into `data`; how many there
/// are, or at which digit they are none.
pub(super) fn bytes(digits: &[u8], data: &mut [u8; Frame::CAPACITY]) -> Result<usize, usize> {
    let (mut at, mut len) = (0, 0);
    while at < digits.len() {
        if digits[at] == b'.' {
            at += 1;
            continue;
        }
        let (high, low) = (number::nibble(digits[at]), digits.get(at + 1).copied().and_then(number::nibble));
        let room = data.get_mut(len).ok_or(at)?;
        *room = high.ok_or(at)? << 4 | low.ok_or(at + 1)?;
        at += 2;
        len += 1;
    }
    Ok(len)
}
