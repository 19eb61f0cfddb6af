//! Vector's text logs, `.asc`, as CANalyzer, CANoe, python-can and log2asc of
//! can-utils write them.

mod classic;
mod fd;
mod writer;

pub(super) use writer::Asc as AscWriter;

use super::date::Date;
use super::line_reader::LineFormat;
use super::words::{LineProblem, Word, Words};
use super::{Buses, Content, Direction, ErrorFrame, Record, number};
use crate::frame::CanId;
use crate::time::{Duration, Instant};
use crate::traffic::socketcan::can_id;

/// Reads lines, in the order header, events.
pub(super) struct Asc {
    /// When the measurement began.
    start: Instant,
    /// The time of the line before.
    now: Instant,
    /// Whether times count from the line before.
    is_relative: bool,
    /// 10 or 16.
    radix: u32,
    /// Requests to send, which are no frames yet.
    requests: u64,
    /// Whether the latest frame was on a line for CAN FD, whose flags stand
    /// behind the data.
    latest_is_fd: bool,
}

impl Default for Asc {
    fn default() -> Self {
        Self {
            start: Instant::ZERO,
            now: Instant::ZERO,
            is_relative: false,
            radix: 16,
            requests: 0,
            latest_is_fd: false,
        }
    }
}

/// What an event says: who sent it and what it is.
type Event = (Direction, Content);

impl Asc {
    fn header(&mut self, first: &Word<'_>, words: &mut Words<'_>) -> Result<(), LineProblem> {
        let is = |name: &[u8]| first.text.eq_ignore_ascii_case(name);
        if is(b"date") {
            self.begin(words.rest(), words.column())?;
        } else if is(b"base") {
            let base = words.expect("hex or dec")?;
            self.radix = match base.text {
                b"hex" => 16,
                b"dec" => 10,
                _ => return Err(base.problem("hex or dec")),
            };
            self.is_relative = words.rest().to_ascii_lowercase().ends_with(b"relative");
        } else if is(b"begin") {
            // "Begin Triggerblock Sam Sep 30 15:06:13.191 2017"
            words.next();
            if !words.rest().is_empty() {
                self.begin(words.rest(), words.column())?;
            }
        } else if !["end", "internal", "no", "previous"].iter().any(|name| is(name.as_bytes())) {
            return Err(first.problem("a time, or a line of the header"));
        }
        Ok(())
    }

    fn begin(&mut self, date: &[u8], column: u64) -> Result<(), LineProblem> {
        let nanos = Date::parse(date).and_then(Date::to_nanos).ok_or_else(|| {
            let title = format!(
                "found the date `{}`, which cannot be read: times are kept as they are",
                super::words::shown(date)
            );
            LineProblem::warning(column + 1, title)
        })?;
        self.start = Instant::from_nanos(nanos);
        self.now = self.start;
        Ok(())
    }

    fn event(
        &mut self,
        time: &Word<'_>,
        words: &mut Words<'_>,
        buses: &mut Buses,
    ) -> Result<Option<Record>, LineProblem> {
        let nanos = Duration::from_nanos(time.nanos(0)?);
        self.now = if self.is_relative { self.now + nanos } else { self.start + nanos };
        let Some(word) = words.next() else { return Ok(None) };
        self.latest_is_fd = false;
        let (number, event) = if word.text == b"CANFD" {
            let number = words.expect("the number of a bus")?;
            (number, self.fd_event(words)?)
        } else if word.text == b"CANXL" {
            return Err(word.problem("a CAN or CAN FD frame: canloop does not read CAN XL"));
        } else if word.text.iter().all(u8::is_ascii_digit) {
            (word, self.classic_event(words)?)
        } else {
            // Something that is no frame: statistics, other buses, variables.
            return Ok(None);
        };
        let Some((direction, content)) = event else { return Ok(None) };
        let bus = buses.numbered(number.decimal("the number of a bus")?.try_into().unwrap_or(u32::MAX));
        let bus = bus.map_err(|error| LineProblem::new(number.column, error.to_string()))?;
        Ok(Some(Record { at: self.now, bus, direction, content }))
    }

    /// Who sent a frame; `None` for a request to send, which is no frame yet.
    fn direction(&mut self, word: &Word<'_>) -> Result<Option<Direction>, LineProblem> {
        match word.text {
            b"Rx" => Ok(Some(Direction::Received)),
            b"Tx" => Ok(Some(Direction::Sent)),
            b"TxRq" => {
                self.requests += 1;
                Ok(None)
            }
            _ => Err(word.problem("Rx or Tx")),
        }
    }

    /// `123` or `1ABCDx`, in this radix.
    fn id(&self, word: &Word<'_>, radix: u32) -> Result<CanId, LineProblem> {
        let (digits, is_extended) = match word.text {
            [digits @ .., b'x' | b'X'] => (digits, true),
            digits => (digits, false),
        };
        let raw = Word { text: digits, column: word.column }.number(radix, "an id");
        raw.ok().and_then(|raw| can_id(raw, is_extended)).ok_or_else(|| word.problem("an id, as in 123 or 1ABCDx"))
    }
}

impl LineFormat for Asc {
    fn line(&mut self, line: &[u8], buses: &mut Buses) -> Result<Option<Record>, LineProblem> {
        let mut words = Words::of(line);
        let Some(first) = words.next() else { return Ok(None) };
        if first.text.starts_with(b"//") {
            name_of_bus(line, buses);
            return Ok(None);
        }
        if first.text[0].is_ascii_digit() || first.text[0] == b'-' {
            return self.event(&first, &mut words, buses);
        }
        self.header(&first, &mut words).map(|()| None)
    }

    fn tells_cut_lines(&self) -> bool {
        !self.latest_is_fd
    }

    fn remark(&mut self) -> Option<&'static str> {
        (self.requests > 0).then_some("lines with TxRq tell what was asked to be sent: they are left out")
    }
}

/// `// bus 2 = vcan0`, with which our writer says what a number stands for.
fn name_of_bus(line: &[u8], buses: &mut Buses) {
    let text = String::from_utf8_lossy(line);
    let Some((number, name)) = text.trim().strip_prefix("// bus ").and_then(|rest| rest.split_once(" = ")) else {
        return;
    };
    if let Some(number) = number::decimal(number.as_bytes()) {
        // Where there are too many, the numbers are as good as names.
        let _ = buses.declare(number.try_into().unwrap_or(u32::MAX), name);
    }
}

/// Whether a word says that there was an error.
fn is_error(word: &Word<'_>) -> bool {
    word.text.eq_ignore_ascii_case(b"ErrorFrame")
}

/// An error of which the log says no more that we know to read.
const ERROR: Content = Content::Error(ErrorFrame::UNSPECIFIED);
