//! What candump of can-utils prints: the log form (`-L`, and the files of
//! `-l`) and the screen form, with each kind of stamp.

mod data;
mod log_line;
mod screen_line;
mod stamps;
mod writer;

use std::borrow::Cow;

pub(super) use stamps::Stamps;
pub(super) use writer::Candump as CandumpWriter;

use super::line_reader::LineFormat;
use super::number;
use super::words::{LineProblem, Words};
use super::{Buses, Content, Direction, Record};
use crate::frame::Frame;
use crate::time::Instant;

/// Reads both forms, also mixed.
pub(super) struct Candump {
    stamps: Stamps,
    /// The time of the line before.
    now: Instant,
    /// Of lines that name none.
    bus: Option<u16>,
    /// Whether it has been said that there are frames without a stamp.
    said_unstamped: bool,
    /// Which form the latest stamped line has.
    in_log_form: bool,
    /// Whether lines say who sent their frame.
    says_directions: bool,
    /// Whether the latest line could have been longer: the log form does not
    /// say the length of a frame.
    may_be_cut: bool,
}

impl Candump {
    /// To read a file that begins with `head`.
    pub fn new(head: &[u8]) -> Self {
        let (stamps, now) = (Stamps::guess(head), Instant::ZERO);
        Self {
            stamps,
            now,
            bus: None,
            said_unstamped: false,
            in_log_form: false,
            says_directions: false,
            may_be_cut: false,
        }
    }

    fn dispatch(&mut self, line: &[u8], buses: &mut Buses) -> Result<Option<Record>, LineProblem> {
        // What -e prints below an error frame is indented with a tab.
        match line.iter().find(|byte| **byte != b' ') {
            None | Some(b'#' | b'\t') => Ok(None),
            Some(b'(') => self.stamped(line, buses).map(Some),
            Some(b'<') => {
                let bus = self.default_bus(buses)?;
                screen_line::with_id_in_brackets(line).and_then(|frame| self.unstamped(bus, Direction::Received, frame))
            }
            Some(_) if line.starts_with(b"DROPCOUNT: ") => self.drop_count(line, buses).map(Some),
            Some(_) if line.starts_with(b"interface = ") => self.interface(line, buses),
            Some(_) => {
                let mut words = Words::of(line);
                let (bus, direction, frame) = screen_line::frame(&mut words, buses)?;
                self.unstamped(bus, direction, frame)
            }
        }
    }

    fn stamped(&mut self, line: &[u8], buses: &mut Buses) -> Result<Record, LineProblem> {
        let (nanos, rest) = stamps::split(line)?;
        let offset = line.len() - rest.len();
        let further = |mut problem: LineProblem| {
            problem.column += offset as u64;
            problem
        };
        let mut words = Words::of(rest);
        let has_hash = memchr::memchr(b'#', rest).is_some();
        self.in_log_form = has_hash || self.in_log_form && memchr::memchr(b'[', rest).is_none();
        if !self.in_log_form {
            let (bus, direction, content) = screen_line::frame(&mut words, buses).map_err(further)?;
            self.may_be_cut = false;
            self.now = self.stamps.moment(self.now, nanos);
            return Ok(Record { at: self.now, bus, direction, content });
        }
        let (bus, said, content) = log_line::frame(&mut words, buses).map_err(further)?;
        self.says_directions |= said.is_some();
        self.may_be_cut = said.is_none() && (self.says_directions || could_be_longer(&content));
        self.now = Instant::from_nanos(nanos);
        let direction = said.unwrap_or_default();
        Ok(Record { at: self.now, bus, direction, content })
    }

    /// A frame without a stamp is said to be at the time of the one before.
    fn unstamped(&mut self, bus: u16, direction: Direction, content: Content) -> Result<Option<Record>, LineProblem> {
        self.may_be_cut = false;
        self.said_unstamped = true;
        Ok(Some(Record { at: self.now, bus, direction, content }))
    }

    /// `DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 17)`
    fn drop_count(&self, line: &[u8], buses: &mut Buses) -> Result<Record, LineProblem> {
        let mut words = Words::of(line).skip(2);
        let wanted = "a number of dropped frames";
        let count = words.next().ok_or_else(|| LineProblem::new(1, format!("expected {wanted}")))?;
        let lost = number::decimal(count.text).and_then(|lost| u32::try_from(lost).ok());
        let lost = lost.ok_or_else(|| count.problem(wanted))?;
        let name = words.find(|word| word.text.starts_with(b"'")).map_or(&b"can0"[..], |word| word.text);
        let name = String::from_utf8_lossy(name.trim_ascii_end());
        let bus = index(buses, name.trim_matches('\'').as_bytes(), 1)?;
        Ok(Record { at: self.now, bus, direction: Direction::Received, content: Content::Lost(lost) })
    }

    /// `interface = can0, family = 29, type = 3, proto = 1`, which a candump
    /// of old prints first.
    fn interface(&mut self, line: &[u8], buses: &mut Buses) -> Result<Option<Record>, LineProblem> {
        let name = Words::of(line).nth(2).map_or(&b"can0"[..], |word| word.text);
        self.bus = Some(index(buses, name.strip_suffix(b",").unwrap_or(name), 13)?);
        Ok(None)
    }

    fn default_bus(&mut self, buses: &mut Buses) -> Result<u16, LineProblem> {
        match self.bus {
            Some(bus) => Ok(bus),
            None => index(buses, b"can0", 1),
        }
    }
}

impl LineFormat for Candump {
    fn line(&mut self, line: &[u8], buses: &mut Buses) -> Result<Option<Record>, LineProblem> {
        match memchr::memchr(b'\x1B', line) {
            None => self.dispatch(line, buses),
            Some(_) => self.dispatch(&without_colours(line), buses),
        }
    }

    fn tells_cut_lines(&self) -> bool {
        !self.may_be_cut
    }

    fn remark(&mut self) -> Option<&'static str> {
        let news = self.said_unstamped && self.now == Instant::ZERO;
        (news).then_some("there are no stamps in this log: all its frames are at 0 s")
    }
}

/// Whether a frame may have lost the end of its data.
fn could_be_longer(content: &Content) -> bool {
    match content {
        Content::Frame(recorded) if recorded.is_fd() => recorded.frame.len() < Frame::CAPACITY,
        Content::Frame(recorded) => recorded.frame.len() < 8,
        _ => true,
    }
}

/// The index of a bus, or what is wrong with having one more.
fn index(buses: &mut Buses, name: &[u8], column: u64) -> Result<u16, LineProblem> {
    buses.index_of_bytes(name).map_err(|error| LineProblem::new(column, error.to_string()))
}

/// The line without the escape sequences of `candump -c`.
fn without_colours(line: &[u8]) -> Cow<'_, [u8]> {
    let mut plain = Vec::with_capacity(line.len());
    let mut rest = line.iter().copied();
    while let Some(byte) = rest.next() {
        match byte {
            b'\x1B' => drop(rest.by_ref().find(u8::is_ascii_alphabetic)),
            _ => plain.push(byte),
        }
    }
    Cow::Owned(plain)
}
