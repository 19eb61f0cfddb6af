//! Comma-separated values. The header says whose they are: ours
//! ([`COLUMNS`]), python-can's, or SavvyCAN's (GVRET).
//!
//! Read by our own code: where a quotation mark is damaged, the `csv` crate
//! takes all that follows for one field. Here a record is a line.

mod cells;
mod writer;

pub(super) use writer::{CsvWriter, PythonCsvWriter};

use cells::{Cells, base64};

use super::line_reader::LineFormat;
use super::words::{LineProblem, Word};
use super::{Buses, Content, Direction, ErrorFrame, Record, number};
use crate::frame::Frame;
use crate::time::Instant;
use crate::traffic::record::fd_len_of;
use crate::traffic::socketcan::{self, can_id};

/// Our header.
pub(super) const COLUMNS: &str = "time_s,bus,direction,kind,id,id_bits,bit_rate_switch,error_passive,dlc,data";
/// python-can's header.
pub(super) const PYTHON_COLUMNS: &str = "timestamp,arbitration_id,extended,remote,error,dlc,data";

/// Reads any of them.
#[derive(Default)]
pub(super) struct Csv {
    dialect: Option<Dialect>,
}

#[derive(Clone, Copy)]
enum Dialect {
    Ours,
    Python,
    Gvret,
}

impl Dialect {
    fn of(header: &[u8]) -> Option<Self> {
        let header = header.trim_ascii();
        let begins = |wanted: &str| {
            header.get(..wanted.len()).is_some_and(|begun| begun.eq_ignore_ascii_case(wanted.as_bytes()))
        };
        if begins(COLUMNS) {
            Some(Self::Ours)
        } else if begins(PYTHON_COLUMNS) {
            Some(Self::Python)
        } else if begins("Time Stamp,ID,Extended,Dir,Bus,LEN") {
            Some(Self::Gvret)
        } else {
            None
        }
    }
}

impl LineFormat for Csv {
    fn line(&mut self, line: &[u8], buses: &mut Buses) -> Result<Option<Record>, LineProblem> {
        if line.trim_ascii().is_empty() {
            return Ok(None);
        }
        let Some(dialect) = self.dialect else {
            self.dialect = Dialect::of(line);
            // Rows without a header are most likely ours.
            let title = format!("expected a header, as `{COLUMNS}`");
            return match self.dialect.replace(self.dialect.unwrap_or(Dialect::Ours)) {
                Some(_) => Ok(None),
                None => Err(LineProblem::new(1, title)),
            };
        };
        let mut cells = Cells::of(line);
        match dialect {
            Dialect::Ours => ours(&mut cells, buses),
            Dialect::Python => python(&mut cells, buses),
            Dialect::Gvret => gvret(&mut cells, buses),
        }
        .map(Some)
    }

    fn tells_cut_lines(&self) -> bool {
        !matches!(self.dialect, Some(Dialect::Gvret))
    }
}

fn ours(cells: &mut Cells<'_>, buses: &mut Buses) -> Result<Record, LineProblem> {
    let at = Instant::from_nanos(cells.next("a time")?.word().nanos(0)?);
    let name = cells.next("the name of a bus")?;
    let direction = cells.next("received or sent")?;
    let kind = cells.next("a kind")?;
    let id = cells.next("an id")?;
    let id_bits = cells.next("11 or 29")?;
    let switch = cells.next("0 or 1")?.text.as_ref() == b"1";
    let passive = cells.next("0 or 1")?.text.as_ref() == b"1";
    let dlc = cells.next("a length code")?;
    let data = cells.next("data")?;

    let direction = match direction.text.as_ref() {
        b"received" => Direction::Received,
        b"sent" => Direction::Sent,
        _ => return Err(direction.word().problem("received or sent")),
    };
    let code = || {
        dlc.word()
            .decimal("a length code")
            .and_then(|code| u8::try_from(code).map_err(|_| dlc.word().problem("a length code")))
    };
    let can_id = || frame_id(&id.word(), id_bits.text.as_ref() == b"29");
    let (mut bytes, digits) = ([0; Frame::CAPACITY], data.word());
    let len = hex_data(&digits, &mut bytes)?;
    let bytes = &bytes[..len];
    let content = match kind.text.as_ref() {
        b"data" if code()?.min(8) as usize == len => {
            Content::Frame(socketcan::with_dlc(can_id()?, false, code()?, bytes))
        }
        b"remote" => Content::Frame(socketcan::with_dlc(can_id()?, true, code()?.min(15), &[])),
        b"fd" if fd_len_of(code()?) == len => {
            let recorded = socketcan::fd(can_id()?, switch, passive, bytes);
            Content::Frame(recorded.ok_or_else(|| digits.problem("data as long as CAN FD frames can be"))?)
        }
        b"error" if len == 8 => {
            let class = id.word().number(16, "the classes of an error")? | ErrorFrame::FLAG;
            socketcan::error_in(class, bytes).map_or(Content::Error(ErrorFrame::UNSPECIFIED), Content::Error)
        }
        b"lost" => {
            let lost = dlc.word().decimal("how many frames were lost")?;
            Content::Lost(u32::try_from(lost).map_err(|_| dlc.word().problem("how many frames were lost"))?)
        }
        b"data" | b"fd" | b"error" => return Err(digits.problem("as much data as the length code says")),
        _ => return Err(kind.word().problem("data, remote, fd, error or lost")),
    };
    let bus = buses.index_of_bytes(&name.text);
    let bus = bus.map_err(|error| LineProblem::new(name.column, error.to_string()))?;
    Ok(Record { at, bus, direction, content })
}

fn python(cells: &mut Cells<'_>, buses: &mut Buses) -> Result<Record, LineProblem> {
    let time = cells.next("a time")?;
    let id = cells.next("an id")?;
    let extended = cells.next("0 or 1")?.text.as_ref() == b"1";
    let remote = cells.next("0 or 1")?.text.as_ref() == b"1";
    let error = cells.next("0 or 1")?.text.as_ref() == b"1";
    let dlc = cells.next("a length")?;
    let data = cells.next("data")?;
    let at = Instant::from_nanos(python_time(&time.word())?);
    let digits = id.text.strip_prefix(b"0x").unwrap_or(&id.text);
    let id = Word { text: digits, column: id.column };
    let len = dlc.word().decimal("a length")?;
    let bytes = base64(&data.text).ok_or_else(|| data.word().problem("data in base 64"))?;
    let content = if error {
        Content::Error(ErrorFrame::UNSPECIFIED)
    } else {
        let id = frame_id(&id, extended)?;
        let recorded = match len {
            _ if remote => Some(socketcan::with_dlc(id, true, len.min(8) as u8, &[])),
            _ if len != bytes.len() as u64 => None,
            0..=8 => socketcan::classic(id, &bytes),
            // CAN FD is not marked, but nothing else is so long.
            _ => socketcan::fd(id, false, false, &bytes),
        };
        Content::Frame(recorded.ok_or_else(|| data.word().problem("as much data as the length says"))?)
    };
    let bus = buses.numbered(1).map_err(|error| LineProblem::new(1, error.to_string()))?;
    Ok(Record { at, bus, direction: Direction::Received, content })
}

/// Python writes small times as 1e-05.
fn python_time(word: &Word<'_>) -> Result<i64, LineProblem> {
    word.nanos(0).or_else(|problem| {
        let seconds = std::str::from_utf8(word.text).ok().and_then(|text| text.parse::<f64>().ok());
        seconds.filter(|seconds| seconds.abs() < 9e9).map(|seconds| (seconds * 1e9).round() as i64).ok_or(problem)
    })
}

/// Microseconds, id, extended, direction, bus from 0, length, bytes.
fn gvret(cells: &mut Cells<'_>, buses: &mut Buses) -> Result<Record, LineProblem> {
    let time = cells.next("a time")?.word().nanos(-6)?;
    let id = cells.next("an id")?;
    let extended = cells.next("true or false")?.text.eq_ignore_ascii_case(b"true");
    let direction = cells.next("Rx or Tx")?;
    let number = cells.next("the number of a bus")?;
    let length = cells.next("a length")?;
    let len = length.word().decimal("a length")? as usize;
    if len > Frame::CAPACITY {
        return Err(length.word().problem("a length of at most 64"));
    }
    let mut bytes = [0; Frame::CAPACITY];
    for byte in &mut bytes[..len] {
        let cell = cells.next("another byte of data")?;
        let value = cell.word().number(16, "a byte of data")?;
        *byte = u8::try_from(value).map_err(|_| cell.word().problem("a byte of data"))?;
    }
    let id = frame_id(&id.word(), extended)?;
    let recorded = match len {
        0..=8 => socketcan::classic(id, &bytes[..len]),
        _ => socketcan::fd(id, false, false, &bytes[..len]),
    };
    let content = Content::Frame(recorded.ok_or_else(|| length.word().problem("a length that frames can have"))?);
    let from_1 = number.word().decimal("the number of a bus")?.saturating_add(1);
    let bus = buses.numbered(from_1.try_into().unwrap_or(u32::MAX));
    let bus = bus.map_err(|error| LineProblem::new(number.column, error.to_string()))?;
    let direction = if direction.text.as_ref() == b"Tx" { Direction::Sent } else { Direction::Received };
    Ok(Record { at: Instant::from_nanos(time), bus, direction, content })
}

fn frame_id(word: &Word<'_>, is_extended: bool) -> Result<crate::frame::CanId, LineProblem> {
    let id = number::hex(word.text).and_then(|raw| can_id(raw, is_extended));
    id.ok_or_else(|| word.problem("an id of 11 or 29 bits, hexadecimal"))
}

fn hex_data(word: &Word<'_>, bytes: &mut [u8; Frame::CAPACITY]) -> Result<usize, LineProblem> {
    let pairs = word.text.chunks(2);
    if word.text.len() > 2 * bytes.len() {
        return Err(word.problem("at most 64 bytes of data"));
    }
    for (byte, pair) in bytes.iter_mut().zip(pairs) {
        let value = (pair.len() == 2).then(|| number::hex(pair)).flatten();
        *byte = value.ok_or_else(|| word.problem("data, two hexadecimal digits a byte"))? as u8;
    }
    Ok(word.text.len() / 2)
}
