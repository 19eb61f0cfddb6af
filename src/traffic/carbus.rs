//! Logs of CarBus Analyzer, `.trc` too: `@ TEXT @ ...`, then columns between
//! tabs: seconds, bus, flags, id, length, data.

use super::line_reader::LineFormat;
use super::words::{LineProblem, Word};
use super::{Buses, Content, Direction, Record, number};
use crate::time::Instant;
use crate::traffic::socketcan::{can_id, classic};

/// Reads it.
pub(super) struct CarBus;

impl LineFormat for CarBus {
    fn line(&mut self, line: &[u8], buses: &mut Buses) -> Result<Option<Record>, LineProblem> {
        if line.trim_ascii().is_empty() || line.starts_with(b"@") {
            return Ok(None);
        }
        let mut column = 1;
        let mut cells = line.split(|&byte| byte == b'\t').map(|text| {
            let cell = Word { text: text.trim_ascii(), column };
            column += text.len() as u64 + 1;
            cell
        });
        let mut expect = |wanted: &str| {
            let end = line.len() as u64 + 1;
            cells.next().ok_or_else(|| LineProblem::new(end, format!("the line ends where {wanted} was expected")))
        };
        let at = Instant::from_nanos(expect("a time")?.nanos(0)?);
        let number = expect("the number of a bus")?;
        expect("flags")?;
        let id = expect("an id")?;
        let length = expect("a length")?;
        let data = expect("data")?;
        let raw = id.number(16, "an id")?;
        let can_id = can_id(raw, id.text.len() > 3).ok_or_else(|| id.problem("an id of three or eight digits"))?;
        let wanted = format!("{} bytes of data", length.decimal("a length")?);
        let bytes: Option<Vec<u8>> = data
            .text
            .split(|&byte| byte == b' ')
            .filter(|text| !text.is_empty())
            .map(|text| number::hex(text).and_then(|byte| u8::try_from(byte).ok()))
            .collect();
        let bytes = bytes.filter(|bytes| length.decimal("").ok() == Some(bytes.len() as u64));
        let recorded = bytes.and_then(|bytes| classic(can_id, &bytes)).ok_or_else(|| data.problem(&wanted))?;
        let index = buses.numbered(number.decimal("the number of a bus")?.try_into().unwrap_or(u32::MAX));
        let bus = index.map_err(|error| LineProblem::new(number.column, error.to_string()))?;
        Ok(Some(Record { at, bus, direction: Direction::Received, content: Content::Frame(recorded) }))
    }
}
