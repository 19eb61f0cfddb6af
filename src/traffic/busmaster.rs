//! Logs of BUSMASTER: a header of lines in stars, then
//! `14:19:36:6265 Rx 1 0x21A s 8 FE 36 12 FE 69 05 07 AD`.

use super::date::Date;
use super::line_reader::LineFormat;
use super::words::{LineProblem, Word, Words};
use super::{Buses, Content, Direction, ErrorFrame, Record, number};
use crate::frame::Frame;
use crate::time::{Duration, Instant};
use crate::traffic::socketcan::{self, can_id};

/// Reads it; SavvyCAN writes it, too.
#[derive(Default)]
pub(super) struct Busmaster {
    mode: Mode,
    is_decimal: bool,
    /// When the session began, and the day that it began on.
    start: Instant,
    midnight: Instant,
    now: Instant,
}

/// What times count from.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
enum Mode {
    /// Midnight.
    #[default]
    System,
    /// The beginning of the session.
    Absolute,
    /// The line before.
    Relative,
}

const DAY: Duration = Duration::from_millis(86_400_000);
const HALF_A_DAY: Duration = Duration::from_millis(43_200_000);

impl Busmaster {
    fn header(&mut self, text: &str) -> Result<(), LineProblem> {
        match text {
            "HEX" => self.is_decimal = false,
            "DEC" => self.is_decimal = true,
            "SYSTEM MODE" => self.mode = Mode::System,
            "ABSOLUTE MODE" => self.mode = Mode::Absolute,
            "RELATIVE MODE" => self.mode = Mode::Relative,
            _ => {}
        }
        let Some(date) = text.strip_prefix("START DATE AND TIME ") else { return Ok(()) };
        // 26:3:2020 14:19:36:625
        let parts: Vec<u32> = date.split([':', ' ']).filter_map(|part| part.parse().ok()).collect();
        let &[day, month, year, hour, minute, second, millis] = parts.as_slice() else {
            return Err(LineProblem::warning(4, format!("found the date {date}, which cannot be read")));
        };
        let nanos = millis.min(999) * 1_000_000;
        let midnight = Date { year: year.into(), month, day, ..Date::default() };
        let start = Date { hour, minute, second, nanos, ..midnight };
        self.start = Instant::from_nanos(start.to_nanos().unwrap_or(0));
        self.midnight = Instant::from_nanos(midnight.to_nanos().unwrap_or(0));
        self.now = self.start;
        Ok(())
    }

    /// `14:19:36:6265`: tenths of milliseconds come last, and milliseconds in
    /// what SavvyCAN writes, which has no four digits there.
    fn moment(&mut self, word: &Word<'_>) -> Result<Instant, LineProblem> {
        let parts: Option<Vec<u64>> = word.text.split(|&byte| byte == b':').map(number::decimal).collect();
        let parts = parts.filter(|parts| parts.iter().all(|part| *part < 1_000_000));
        let Some(&[hours, minutes, seconds, fraction]) = parts.as_deref() else {
            return Err(word.problem("a time, as in 14:19:36:6265"));
        };
        let digits = word.text.rsplit(|&byte| byte == b':').next().map_or(0, <[u8]>::len);
        let tenths = if digits < 4 { 10 * fraction } else { fraction };
        let tenths = ((hours * 60 + minutes) * 60 + seconds) * 10_000 + tenths;
        let span = Duration::from_nanos(tenths as i64 * 100_000);
        self.now = match self.mode {
            Mode::Absolute => self.start + span,
            Mode::Relative => self.now + span,
            Mode::System => {
                if self.midnight + span + HALF_A_DAY < self.now {
                    self.midnight += DAY;
                }
                self.midnight + span
            }
        };
        Ok(self.now)
    }

    fn record(&mut self, line: &[u8], buses: &mut Buses) -> Result<Record, LineProblem> {
        let mut words = Words::of(line);
        let at = self.moment(&words.expect("a time")?)?;
        let direction = words.expect("Rx or Tx")?;
        let direction = match direction.text {
            b"Rx" => Direction::Received,
            b"Tx" => Direction::Sent,
            _ => return Err(direction.problem("Rx or Tx")),
        };
        let number = words.expect("the number of a bus")?;
        let index = buses.numbered(number.decimal("the number of a bus")?.try_into().unwrap_or(u32::MAX));
        let bus = index.map_err(|error| LineProblem::new(number.column, error.to_string()))?;
        let content = self.content(&mut words)?;
        Ok(Record { at, bus, direction, content })
    }

    fn content(&self, words: &mut Words<'_>) -> Result<Content, LineProblem> {
        let id = words.expect("an id")?;
        if id.text.starts_with(b"ERR") {
            return Ok(Content::Error(ErrorFrame::UNSPECIFIED));
        }
        let kind = words.expect("s, x, sr or xr")?;
        let (is_extended, is_remote, is_fd) = match kind.text {
            b"s" => (false, false, false),
            b"x" => (true, false, false),
            b"sr" => (false, true, false),
            b"xr" => (true, true, false),
            b"s-fd" => (false, false, true),
            b"x-fd" => (true, false, true),
            _ => return Err(kind.problem("s, x, sr, xr, s-fd or x-fd")),
        };
        let digits = id.text.strip_prefix(b"0x").unwrap_or(id.text);
        let raw = Word { text: digits, column: id.column }.number(self.radix(), "an id")?;
        let id = can_id(raw, is_extended).ok_or_else(|| id.problem("an id of 11 bits, or 29 with x"))?;
        let length = words.expect("a length")?;
        let len = length.decimal("a length")? as usize;
        let wanted = "a length that such frames can have";
        if len > if is_fd { Frame::CAPACITY } else { 8 } {
            return Err(length.problem(wanted));
        }
        let mut data = [0; Frame::CAPACITY];
        if !is_remote {
            for byte in &mut data[..len] {
                let word = words.expect("another byte of data")?;
                let value = word.number(self.radix(), "a byte of data")?;
                *byte = u8::try_from(value).map_err(|_| word.problem("a byte of data"))?;
            }
        }
        let recorded = match is_fd {
            true => socketcan::fd(id, false, false, &data[..len]).ok_or_else(|| length.problem(wanted))?,
            false => socketcan::with_dlc(id, is_remote, len as u8, &data[..len]),
        };
        Ok(Content::Frame(recorded))
    }

    const fn radix(&self) -> u32 {
        if self.is_decimal { 10 } else { 16 }
    }
}

impl LineFormat for Busmaster {
    fn line(&mut self, line: &[u8], buses: &mut Buses) -> Result<Option<Record>, LineProblem> {
        match line.trim_ascii() {
            [] => Ok(None),
            header @ [b'*', b'*', b'*', ..] => {
                let text = String::from_utf8_lossy(header);
                self.header(text.trim_matches('*')).map(|()| None)
            }
            text if text.first().is_some_and(u8::is_ascii_digit) => self.record(line, buses).map(Some),
            // Names of databases and the like.
            _ => Ok(None),
        }
    }
}
