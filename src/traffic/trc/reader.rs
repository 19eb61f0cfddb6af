//! Reads all versions: the header says which columns there are.

use super::start_time;
use crate::frame::Frame;
use crate::time::{Duration, Instant};
use crate::traffic::date::Date;
use crate::traffic::line_reader::LineFormat;
use crate::traffic::record::fd_len_of;
use crate::traffic::socketcan::{self, can_id};
use crate::traffic::words::{LineProblem, Word, Words};
use crate::traffic::{Buses, Content, Direction, ErrorFrame, Record, number};

/// Reads `.trc`.
pub(in crate::traffic) struct Trc {
    start: Instant,
    has_start: bool,
    /// A letter for each column, as `$COLUMNS` of version 2 names them.
    columns: Vec<u8>,
    /// Whether the columns are those of version 1.
    is_version_1: bool,
}

impl Default for Trc {
    fn default() -> Self {
        let columns = version_1(0).to_vec();
        Self { start: Instant::ZERO, has_start: false, columns, is_version_1: true }
    }
}

/// The words of a row by their columns.
#[derive(Default)]
struct Row<'l> {
    time: Option<Word<'l>>,
    kind: Option<Word<'l>>,
    bus: Option<Word<'l>>,
    id: Option<Word<'l>>,
    direction: Option<Word<'l>>,
    length: Option<Word<'l>>,
    /// Whether the length is one, and not a length code.
    is_in_bytes: bool,
}

/// The columns of the versions before `$COLUMNS`.
const fn version_1(minor: u32) -> &'static [u8] {
    match minor {
        0 => b"NOILD",
        1 => b"NOdILD",
        2 => b"NOBdILD",
        _ => b"NOBdIRLD",
    }
}

impl Trc {
    /// A line of the header, or a comment.
    fn header(&mut self, line: &str, buses: &mut Buses) -> Result<(), LineProblem> {
        let value = |name: &str| line.strip_prefix(name).map(str::trim);
        if let Some(version) = value(";$FILEVERSION=") {
            let (major, minor) = version.split_once('.').unwrap_or((version, "0"));
            self.is_version_1 = major == "1";
            match (major, minor.parse()) {
                ("1", Ok(minor)) => self.columns = version_1(minor).to_vec(),
                ("2", Ok(_)) => self.columns = b"NOTBIdRLD".to_vec(),
                _ => return Err(LineProblem::new(15, format!("found the version {version}, expected 1.0 to 2.1"))),
            }
        } else if let Some(days) = value(";$STARTTIME=") {
            let nanos = start_time::parse(days);
            let problem =
                || LineProblem::warning(13, format!("found the time {days}, expected days since 30 December 1899"));
            self.start = Instant::from_nanos(nanos.ok_or_else(problem)?);
            self.has_start = true;
        } else if let Some(columns) = value(";$COLUMNS=") {
            self.columns = columns.bytes().filter(u8::is_ascii_alphabetic).collect();
        } else {
            self.comment(line.trim_start_matches([';', ' ']), buses);
        }
        Ok(())
    }

    fn comment(&mut self, text: &str, buses: &mut Buses) {
        if let Some(date) = text.strip_prefix("Start time: ") {
            let nanos = Date::parse(date.as_bytes()).and_then(Date::to_nanos);
            if let (Some(nanos), false) = (nanos, self.has_start) {
                self.start = Instant::from_nanos(nanos);
            }
        } else if let Some((number, name)) = text.strip_prefix("Bus ").and_then(|rest| rest.split_once(" = "))
            && let Ok(number) = number.parse()
        {
            // Where there are too many, the numbers are as good as names.
            let _ = buses.declare(number, name.trim());
        }
    }

    fn row<'l>(&self, words: &mut Words<'l>) -> Result<Row<'l>, LineProblem> {
        let mut row = Row::default();
        for column in &self.columns {
            let place = match column {
                b'D' => break,
                b'O' => &mut row.time,
                b'T' => &mut row.kind,
                b'B' => &mut row.bus,
                b'I' => &mut row.id,
                b'd' => &mut row.direction,
                b'L' | b'l' => {
                    row.is_in_bytes = *column == b'l';
                    &mut row.length
                }
                _ => {
                    words.expect("another column")?;
                    continue;
                }
            };
            *place = Some(words.expect("another column")?);
        }
        Ok(row)
    }

    fn record(&self, line: &[u8], buses: &mut Buses) -> Result<Option<Record>, LineProblem> {
        let mut words = Words::of(line);
        if self.is_event(line) {
            return Ok(None);
        }
        let row = self.row(&mut words)?;
        let missing = || LineProblem::new(1, "the columns of this file do not say enough of a frame");
        let time = row.time.ok_or_else(missing)?;
        let at = self.start + Duration::from_nanos(time.nanos(-3)?);
        let (direction, content) = match self.is_version_1 {
            true => self.of_version_1(&row, &mut words)?,
            false => self.of_version_2(&row, &mut words)?,
        };
        let Some(content) = content else { return Ok(None) };
        let number = match &row.bus {
            Some(word) if word.text != b"-" => word.decimal("the number of a bus")?.try_into().unwrap_or(u32::MAX),
            _ => 1,
        };
        let bus = buses.numbered(number).map_err(|error| LineProblem::new(time.column, error.to_string()))?;
        Ok(Some(Record { at, bus, direction, content }))
    }

    /// Rows of version 2 that tell of something other than a frame have fewer
    /// columns: a change of the hardware's state, of error counters, a remark.
    fn is_event(&self, line: &[u8]) -> bool {
        let kind = self.columns.iter().position(|&column| column == b'T');
        let word = kind.and_then(|at| Words::of(line).nth(at));
        word.is_some_and(|word| matches!(word.text, b"ST" | b"EC" | b"EV"))
    }

    fn of_version_1(&self, row: &Row<'_>, words: &mut Words<'_>) -> Result<(Direction, Option<Content>), LineProblem> {
        let missing = || LineProblem::new(1, "a row without an id");
        let (id, length) = (row.id.ok_or_else(missing)?, row.length.ok_or_else(missing)?);
        let direction = match row.direction.map_or(&b"Rx"[..], |word| word.text) {
            b"Rx" => Direction::Received,
            b"Tx" => Direction::Sent,
            b"Warng" => return Ok((Direction::Received, None)),
            b"Error" => {
                let data = data(words, length.decimal("a length")? as usize)?;
                let kind = number::hex(id.text).unwrap_or(0) as u8;
                let data: Vec<u8> = std::iter::once(kind).chain(data.as_slice().iter().copied()).collect();
                return Ok((Direction::Received, Some(error(&data))));
            }
            _ => return Err(row.direction.map_or_else(missing, |word| word.problem("Rx, Tx, Warng or Error"))),
        };
        if id.text == b"FFFFFFFF" {
            // The state of the bus, in version 1.0.
            return Ok((direction, None));
        }
        if words.rest().starts_with(b"ERROR") {
            return Ok((direction, Some(Content::Error(ErrorFrame::UNSPECIFIED))));
        }
        let is_remote = words.rest().starts_with(b"RTR");
        let recorded = classic(&id, is_remote, &length, words)?;
        Ok((direction, Some(recorded)))
    }

    fn of_version_2(&self, row: &Row<'_>, words: &mut Words<'_>) -> Result<(Direction, Option<Content>), LineProblem> {
        let missing = || LineProblem::new(1, "the columns of this file do not say enough of a frame");
        let (kind, id) = (row.kind.ok_or_else(missing)?, row.id.ok_or_else(missing)?);
        let length = row.length.ok_or_else(missing)?;
        let direction = match row.direction.map_or(&b"Rx"[..], |word| word.text) {
            b"Rx" => Direction::Received,
            b"Tx" => Direction::Sent,
            _ => return Err(row.direction.map_or_else(missing, |word| word.problem("Rx or Tx"))),
        };
        let content = match kind.text {
            b"DT" => classic(&id, words.rest().starts_with(b"RTR"), &length, words)?,
            b"RR" => classic(&id, true, &length, words)?,
            b"FD" => fd(&id, row, &length, words, false, false)?,
            b"FB" => fd(&id, row, &length, words, true, false)?,
            b"FE" => fd(&id, row, &length, words, true, true)?,
            b"BI" => fd(&id, row, &length, words, false, true)?,
            b"ER" => {
                let len = length.decimal("a length")? as usize;
                return Ok((Direction::Received, Some(error(data(words, len)?.as_slice()))));
            }
            _ => return Err(kind.problem("a type of message, as DT, FD or RR")),
        };
        Ok((direction, Some(content)))
    }
}

impl LineFormat for Trc {
    fn line(&mut self, line: &[u8], buses: &mut Buses) -> Result<Option<Record>, LineProblem> {
        match line.trim_ascii() {
            [] => Ok(None),
            comment @ [b';', ..] => self.header(&String::from_utf8_lossy(comment), buses).map(|()| None),
            _ => self.record(line, buses),
        }
    }
}

fn classic(id: &Word<'_>, is_remote: bool, length: &Word<'_>, words: &mut Words<'_>) -> Result<Content, LineProblem> {
    let dlc = length.decimal("a length")?;
    let dlc =
        u8::try_from(dlc).ok().filter(|dlc| *dlc <= 15).ok_or_else(|| length.problem("a length of at most 8 bytes"))?;
    let data = if is_remote { Data::default() } else { data(words, usize::from(dlc.min(8)))? };
    Ok(Content::Frame(socketcan::with_dlc(id_of(id)?, is_remote, dlc, data.as_slice())))
}

fn fd(
    id: &Word<'_>,
    row: &Row<'_>,
    length: &Word<'_>,
    words: &mut Words<'_>,
    switch: bool,
    passive: bool,
) -> Result<Content, LineProblem> {
    let number = length.decimal("a length")?;
    let len = match row.is_in_bytes {
        true => usize::try_from(number).unwrap_or(usize::MAX),
        false => u8::try_from(number).ok().filter(|dlc| *dlc <= 15).map_or(usize::MAX, fd_len_of),
    };
    let wanted = "a length that CAN FD frames can have";
    if len > Frame::CAPACITY {
        return Err(length.problem(wanted));
    }
    let data = data(words, len)?;
    let recorded = socketcan::fd(id_of(id)?, switch, passive, data.as_slice());
    recorded.map(Content::Frame).ok_or_else(|| length.problem(wanted))
}

/// Four digits for 11 bits, eight for 29.
fn id_of(word: &Word<'_>) -> Result<crate::frame::CanId, LineProblem> {
    let raw = number::hex(word.text).and_then(|raw| can_id(raw, word.text.len() > 4));
    raw.ok_or_else(|| word.problem("an id of four or eight hexadecimal digits"))
}

/// Kind, direction, place, and the counters of receive and transmit errors.
fn error(bytes: &[u8]) -> Content {
    let byte = |at: usize| bytes.get(at).copied().unwrap_or(0);
    // Bit, form and stuff error have the same numbers as in SocketCAN.
    let kind = if byte(0) < 8 { byte(0) } else { 0 };
    let data = [0, 0, kind, byte(2), 0, 0, byte(4), byte(3)];
    Content::Error(ErrorFrame { class: ErrorFrame::PROTOCOL | ErrorFrame::BUS_ERROR, data })
}

struct Data {
    bytes: [u8; Frame::CAPACITY],
    len: usize,
}

impl Default for Data {
    fn default() -> Self {
        Self { bytes: [0; Frame::CAPACITY], len: 0 }
    }
}

impl Data {
    fn as_slice(&self) -> &[u8] {
        &self.bytes[..self.len]
    }
}

fn data(words: &mut Words<'_>, len: usize) -> Result<Data, LineProblem> {
    let mut data = Data { len: len.min(Frame::CAPACITY), ..Data::default() };
    for byte in &mut data.bytes[..len.min(Frame::CAPACITY)] {
        let word = words.expect("another byte of data")?;
        // What the tool could not show of a frame it writes as dashes.
        *byte = match word.text {
            b"--" => 0,
            text => number::hex(text)
                .and_then(|byte| u8::try_from(byte).ok())
                .ok_or_else(|| word.problem("a byte of data"))?,
        };
    }
    Ok(data)
}
