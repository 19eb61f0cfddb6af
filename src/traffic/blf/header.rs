//! The header of a file.

use crate::traffic::bytes::{u16_at, u32_at, u64_at};
use crate::traffic::date::Date;

/// Bytes of a header, with what is reserved in it.
pub(super) const HEADER_BYTES: usize = 144;
/// The part that says something.
const STATED_BYTES: usize = 72;
const MAGIC: &[u8; 4] = b"LOGG";

/// What the header says.
#[derive(Default)]
pub(super) struct Header {
    /// Its length.
    pub len: u64,
    /// Bytes of the whole file; 0 or just the header where it was not ended.
    pub file_bytes: u64,
    /// With the containers inflated.
    pub inflated_bytes: u64,
    /// Number of objects.
    pub objects: u32,
    /// When the measurement began, nanoseconds since the epoch.
    pub start_ns: i64,
    /// The time of the last object.
    pub end_ns: i64,
}

impl Header {
    /// From the beginning of a file; `None` where it is none, or too short.
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        (bytes.len() >= STATED_BYTES && bytes.starts_with(MAGIC)).then(|| Self {
            len: u32_at(bytes, 4).into(),
            file_bytes: u64_at(bytes, 16),
            inflated_bytes: u64_at(bytes, 24),
            objects: u32_at(bytes, 32),
            start_ns: system_time(&bytes[40..56]).unwrap_or(0),
            end_ns: system_time(&bytes[56..72]).unwrap_or(0),
        })
    }

    /// As bytes.
    pub fn bytes(&self) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        out.extend_from_slice(&(HEADER_BYTES as u32).to_le_bytes());
        // Who wrote it (5 is what python-can says, 0 is unknown), and the version of the format.
        out.extend_from_slice(&[5, 0, 0, 0, 2, 6, 8, 1]);
        out.extend_from_slice(&self.file_bytes.to_le_bytes());
        out.extend_from_slice(&self.inflated_bytes.to_le_bytes());
        out.extend_from_slice(&self.objects.to_le_bytes());
        out.extend_from_slice(&[0; 4]);
        put_system_time(&mut out, self.start_ns);
        put_system_time(&mut out, self.end_ns);
        out.resize(HEADER_BYTES, 0);
        out
    }
}

/// A SYSTEMTIME of Windows: year, month, weekday, day, hour, minute, second,
/// millisecond.
fn system_time(bytes: &[u8]) -> Option<i64> {
    let part = |index: usize| u32::from(u16_at(bytes, 2 * index));
    Date {
        year: part(0).into(),
        month: part(1),
        day: part(3),
        hour: part(4),
        minute: part(5),
        second: part(6),
        nanos: part(7).min(999) * 1_000_000,
    }
    .to_nanos()
}

fn put_system_time(out: &mut Vec<u8>, nanos: i64) {
    let date = Date::from_nanos(nanos);
    let weekday = date.weekday();
    let year = date.year as u32;
    for part in [year, date.month, weekday, date.day, date.hour, date.minute, date.second, date.nanos / 1_000_000] {
        out.extend_from_slice(&(part as u16).to_le_bytes());
    }
}
