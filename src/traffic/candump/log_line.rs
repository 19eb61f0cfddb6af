//! The log form behind its stamp: `can0 123#DEADBEEF R`.

use super::data::{Id, bytes, error, id};
use super::index;
use crate::frame::Frame;
use crate::traffic::socketcan::{self, BIT_RATE_SWITCH, ERROR_PASSIVE};
use crate::traffic::words::{LineProblem, Word, Words};
use crate::traffic::{Buses, Content, Direction, number};

/// The rest of a line; not all say who sent the frame.
pub(super) fn frame(
    words: &mut Words<'_>,
    buses: &mut Buses,
) -> Result<(u16, Option<Direction>, Content), LineProblem> {
    let name = words.expect("the name of a bus")?;
    let frame = words.expect("a frame, as in 123#DEADBEEF")?;
    let content = content(&frame)?;
    let direction = match words.next() {
        None => None,
        Some(word) => match word.text {
            b"R" | b"r" => Some(Direction::Received),
            b"T" | b"t" => Some(Direction::Sent),
            _ => return Err(word.problem("the end of the line, or R or T")),
        },
    };
    Ok((index(buses, name.text, name.column)?, direction, content))
}

/// `123#DEADBEEF`, `123##1DEADBEEF`, `123#R8`, `20000080#0000000000000000`.
fn content(word: &Word<'_>) -> Result<Content, LineProblem> {
    let Some(hash) = memchr::memchr(b'#', word.text) else {
        return Err(word.problem("a frame, as in 123#DEADBEEF"));
    };
    let behind = Part { text: &word.text[hash + 1..], column: word.column + hash as u64 + 1 };
    match (id(&word.text[..hash], word.column)?, behind.text.first()) {
        (Id::Error(class), _) => Ok(error(class, behind.data()?.as_slice())),
        (Id::Frame(id), Some(b'#')) => behind.skip(1).fd(id),
        (Id::Frame(id), Some(b'R' | b'r')) => behind.skip(1).remote(id),
        (Id::Frame(id), _) => behind.classic(id),
    }
}

/// What stands behind the `#`.
struct Part<'l> {
    text: &'l [u8],
    column: u64,
}

/// Data of a frame.
struct Data {
    bytes: [u8; Frame::CAPACITY],
    len: usize,
}

impl Data {
    fn as_slice(&self) -> &[u8] {
        &self.bytes[..self.len]
    }
}

impl Part<'_> {
    fn skip(&self, count: usize) -> Self {
        Self { text: &self.text[count..], column: self.column + count as u64 }
    }

    fn problem(&self, title: impl Into<String>) -> LineProblem {
        LineProblem::new(self.column, title)
    }

    fn data(&self) -> Result<Data, LineProblem> {
        let mut data = Data { bytes: [0; Frame::CAPACITY], len: 0 };
        match bytes(self.text, &mut data.bytes) {
            Ok(len) => data.len = len,
            Err(at) => return Err(self.no_data(at)),
        }
        Ok(data)
    }

    #[cold]
    fn no_data(&self, at: usize) -> LineProblem {
        let column = self.column + at as u64;
        match self.text.get(at) {
            Some(b'#' | b':') => LineProblem::new(column, "a CAN XL frame, which canloop does not read"),
            Some(byte) => {
                let found = char::from(*byte).escape_debug();
                LineProblem::new(column, format!("found `{found}` in the data, expected hexadecimal digits"))
            }
            None => LineProblem::new(column, "the data ends in the middle of a byte"),
        }
    }

    fn classic(&self, id: crate::frame::CanId) -> Result<Content, LineProblem> {
        let (text, dlc) = self.without_dlc()?;
        let data = Part { text, column: self.column }.data()?;
        let mut recorded = socketcan::classic(id, data.as_slice())
            .ok_or_else(|| self.problem(format!("{} bytes of data, expected at most 8", data.len)))?;
        match dlc {
            Some(_) if data.len < 8 => return Err(self.problem("a length code without 8 bytes of data")),
            dlc => recorded.dlc_above_8 = dlc,
        }
        Ok(Content::Frame(recorded))
    }

    fn remote(&self, id: crate::frame::CanId) -> Result<Content, LineProblem> {
        let (text, dlc) = self.without_dlc()?;
        let len = match text {
            [] => 0,
            [digit] => number::nibble(*digit).filter(|len| *len <= 8).unwrap_or(u8::MAX),
            _ => u8::MAX,
        };
        match (len, dlc) {
            (u8::MAX, _) => Err(self.problem("expected the length of a remote request, 0 to 8")),
            (8, Some(dlc)) => Ok(Content::Frame(socketcan::with_dlc(id, true, dlc, &[]))),
            (_, Some(_)) => Err(self.problem("a length code, but not the length 8")),
            (len, None) => Ok(Content::Frame(socketcan::with_dlc(id, true, len, &[]))),
        }
    }

    fn fd(&self, id: crate::frame::CanId) -> Result<Content, LineProblem> {
        let flags = self.text.first().copied().and_then(number::nibble);
        let flags = flags.ok_or_else(|| self.problem("expected the flags of a CAN FD frame, a digit"))?;
        let data = self.skip(1).data()?;
        socketcan::fd(id, flags & BIT_RATE_SWITCH != 0, flags & ERROR_PASSIVE != 0, data.as_slice())
            .map(Content::Frame)
            .ok_or_else(|| self.problem(format!("{} bytes of data, which no CAN FD frame has", data.len)))
    }

    /// Takes `_B` off the end: a length code above 8.
    fn without_dlc(&self) -> Result<(&[u8], Option<u8>), LineProblem> {
        let [text @ .., b'_', digit] = self.text else { return Ok((self.text, None)) };
        match number::nibble(*digit) {
            Some(dlc @ 9..) => Ok((text, Some(dlc))),
            _ => Err(LineProblem::new(self.column + text.len() as u64, "expected a length code from _9 to _F")),
        }
    }
}
