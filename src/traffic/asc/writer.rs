//! As CANoe writes it: the date, then a line for each frame, its time counted
//! from there in microseconds. Comments say what numbers of buses stand for.

use std::io::{self, Write};

use crate::frame::FrameKind;
use crate::traffic::date::Date;
use crate::traffic::losses::{Loss, Losses};
use crate::traffic::number::{put_bytes, put_decimal, put_seconds};
use crate::traffic::numbering::Numbering;
use crate::traffic::socketcan::fd_flags;
use crate::traffic::{Buses, Content, Direction, ErrorFrame, Record, RecordedFrame, Writer};

const MICROSECOND_NS: i64 = 1_000;
const MILLISECOND_NS: i64 = 1_000_000;

/// Writes `.asc`.
pub(in crate::traffic) struct Asc<W> {
    out: W,
    line: Vec<u8>,
    /// When the measurement began, once it has.
    start_ns: Option<i64>,
    numbering: Numbering,
    losses: Losses,
}

impl<W: Write> Asc<W> {
    /// Writes to `out`.
    pub fn new(out: W) -> Self {
        Self { out, line: Vec::new(), start_ns: None, numbering: Numbering::default(), losses: Losses::default() }
    }

    /// Writes the header before the first record; returns when it says that
    /// the measurement began. The date has milliseconds.
    fn begin(&mut self, nanos: i64) -> io::Result<i64> {
        if let Some(start_ns) = self.start_ns {
            return Ok(start_ns);
        }
        let start_ns = nanos - nanos.rem_euclid(MILLISECOND_NS);
        self.start_ns = Some(start_ns);
        let date = Date::from_nanos(start_ns).english();
        write!(
            self.out,
            "date {date}\nbase hex  timestamps absolute\ninternal events logged\n// version 9.0.0\n\
             Begin Triggerblock {date}\n   0.000000 Start of measurement\n"
        )?;
        Ok(start_ns)
    }

    fn put_classic(&mut self, number: u32, record: &Record, recorded: &RecordedFrame) {
        let line = &mut self.line;
        put_decimal(line, number.into(), 1);
        line.extend_from_slice(b"  ");
        put_id(line, recorded, 15);
        line.extend_from_slice(if record.direction == Direction::Sent { b" Tx   " } else { b" Rx   " });
        let is_remote = recorded.frame.kind == FrameKind::Remote;
        line.extend_from_slice(if is_remote { b"r " } else { b"d " });
        let _ = write!(line, "{:x}", recorded.dlc());
        if !is_remote && !recorded.frame.is_empty() {
            line.push(b' ');
            put_bytes(line, recorded.frame.payload(), b" ");
        }
    }

    fn put_fd(&mut self, number: u32, record: &Record, recorded: &RecordedFrame) {
        let line = &mut self.line;
        let direction = if record.direction == Direction::Sent { "Tx" } else { "Rx" };
        let _ = write!(line, "CANFD {number:>3} {direction}   ");
        put_id(line, recorded, 8);
        // No name; then the flags of the frame.
        line.resize(line.len() + 34, b' ');
        let flags = fd_flags(recorded);
        let (dlc, len) = (recorded.dlc(), recorded.frame.len());
        let _ = write!(line, " {} {} {dlc:x} {len:>2} ", flags & 1, flags >> 1 & 1);
        put_bytes(line, recorded.frame.payload(), b" ");
        let all_flags = 0x1000_u32 | u32::from(flags & 1) << 13 | u32::from(flags >> 1 & 1) << 14;
        let _ = write!(line, " {:>8} {:>4} {all_flags:>8X}", 0, 0);
        line.extend_from_slice(b"        0        0        0        0        0");
    }
}

impl<W: Write> Writer for Asc<W> {
    fn put(&mut self, record: &Record, buses: &Buses) -> io::Result<()> {
        if matches!(record.content, Content::Lost(_)) {
            self.losses.note(Loss::LostCounts);
            return Ok(());
        }
        let nanos = record.at.as_nanos();
        let start_ns = self.begin(nanos)?;
        let mut offset_ns = nanos.saturating_sub(start_ns);
        if offset_ns < 0 {
            self.losses.note(Loss::EarlierStamps);
            offset_ns = 0;
        }
        self.losses.note_stamp(offset_ns, MICROSECOND_NS);
        let numbered = self.numbering.of(record.bus, buses);
        if numbered.is_news {
            writeln!(self.out, "// bus {} = {}", numbered.number, buses.name(record.bus).escape_debug())?;
        }
        self.line.clear();
        self.line.extend_from_slice(if offset_ns < 10_000_000_000 { b"   " } else { b"  " });
        put_seconds(&mut self.line, offset_ns, 1, 6);
        self.line.push(b' ');
        match &record.content {
            Content::Frame(recorded) if recorded.is_fd() => self.put_fd(numbered.number, record, recorded),
            Content::Frame(recorded) => self.put_classic(numbered.number, record, recorded),
            Content::Error(error) => {
                if *error != ErrorFrame::UNSPECIFIED {
                    self.losses.note(Loss::ErrorDetails);
                }
                put_decimal(&mut self.line, numbered.number.into(), 1);
                self.line.extend_from_slice(b"  ErrorFrame");
            }
            Content::Lost(_) => {}
        }
        self.line.push(b'\n');
        self.out.write_all(&self.line)
    }

    fn finish(mut self: Box<Self>) -> io::Result<Losses> {
        self.begin(0)?;
        self.out.write_all(b"End TriggerBlock\n")?;
        self.out.flush()?;
        Ok(self.losses)
    }
}

/// `123` or `1ABCDx`, filled up with blanks.
fn put_id(line: &mut Vec<u8>, recorded: &RecordedFrame, width: usize) {
    let id = recorded.frame.id;
    let start = line.len();
    let _ = write!(line, "{:X}{}", id.raw(), if id.is_extended() { "x" } else { "" });
    line.resize(line.len().max(start + width), b' ');
}
