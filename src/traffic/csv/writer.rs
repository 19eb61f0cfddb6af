//! Our columns, which hold everything, and python-can's, which it reads.

use std::io::{self, Write};

use super::cells::put_base64;
use super::{COLUMNS, PYTHON_COLUMNS};
use crate::frame::FrameKind;
use crate::traffic::losses::{Loss, Losses};
use crate::traffic::number::{put_bytes, put_decimal, put_hex, put_seconds};
use crate::traffic::{Buses, Content, Direction, ErrorFrame, Record, RecordedFrame, Writer};

/// Writes our columns.
pub(in crate::traffic) struct CsvWriter<W> {
    lines: HeadedLines<W>,
    losses: Losses,
}

/// Writes python-can's columns.
pub(in crate::traffic) struct PythonCsvWriter<W> {
    lines: HeadedLines<W>,
    only_bus: Option<u16>,
    losses: Losses,
}

/// Lines, and a header before the first.
struct HeadedLines<W> {
    out: W,
    header: Option<&'static str>,
    line: Vec<u8>,
}

impl<W: Write> HeadedLines<W> {
    fn new(out: W, header: &'static str) -> Self {
        Self { out, header: Some(header), line: Vec::new() }
    }

    fn write(&mut self) -> io::Result<()> {
        if let Some(header) = self.header.take() {
            writeln!(self.out, "{header}")?;
        }
        self.line.push(b'\n');
        self.out.write_all(&self.line)?;
        self.line.clear();
        Ok(())
    }

    fn finish(&mut self) -> io::Result<()> {
        if let Some(header) = self.header.take() {
            writeln!(self.out, "{header}")?;
        }
        self.out.flush()
    }
}

impl<W: Write> CsvWriter<W> {
    /// Writes to `out`.
    pub fn new(out: W) -> Self {
        Self { lines: HeadedLines::new(out, COLUMNS), losses: Losses::default() }
    }

    fn put_name(&mut self, name: &str) {
        let needs_quotes = |c: char| matches!(c, ',' | '"') || c.is_whitespace();
        let line = &mut self.lines.line;
        if name.contains(char::is_control) {
            self.losses.note(Loss::BusNames);
            line.extend_from_slice(name.replace(char::is_control, "_").replace([',', '"'], "_").as_bytes());
        } else if name.contains(needs_quotes) {
            let _ = write!(line, "\"{}\"", name.replace('"', "\"\""));
        } else {
            line.extend_from_slice(name.as_bytes());
        }
    }
}

impl<W: Write> Writer for CsvWriter<W> {
    fn put(&mut self, record: &Record, buses: &Buses) -> io::Result<()> {
        put_seconds(&mut self.lines.line, record.at.as_nanos(), 1, 9);
        self.lines.line.push(b',');
        self.put_name(buses.name(record.bus));
        let line = &mut self.lines.line;
        line.extend_from_slice(if record.direction == Direction::Sent { b",sent," } else { b",received," });
        match &record.content {
            Content::Frame(recorded) => put_frame(line, recorded),
            Content::Error(error) => {
                line.extend_from_slice(b"error,");
                put_hex(line, error.class, 8);
                line.extend_from_slice(b",,,,8,");
                put_bytes(line, &error.data, b"");
            }
            Content::Lost(count) => {
                let _ = write!(line, "lost,,,,,{count},");
            }
        }
        self.lines.write()
    }

    fn finish(mut self: Box<Self>) -> io::Result<Losses> {
        self.lines.finish()?;
        Ok(self.losses)
    }
}

fn put_frame(line: &mut Vec<u8>, recorded: &RecordedFrame) {
    let frame = &recorded.frame;
    let (kind, switch) = match frame.kind {
        FrameKind::Classic => ("data,", ",,"),
        FrameKind::Remote => ("remote,", ",,"),
        FrameKind::Fd => ("fd,", "0,"),
        FrameKind::FdBitRateSwitch => ("fd,", "1,"),
    };
    line.extend_from_slice(kind.as_bytes());
    let is_extended = frame.id.is_extended();
    put_hex(line, frame.id.raw(), if is_extended { 8 } else { 3 });
    line.extend_from_slice(if is_extended { b",29," } else { b",11," });
    line.extend_from_slice(switch.as_bytes());
    if recorded.is_fd() {
        line.extend_from_slice(if recorded.error_passive { b"1," } else { b"0," });
    }
    put_decimal(line, recorded.dlc().into(), 1);
    line.push(b',');
    if frame.kind != FrameKind::Remote {
        put_bytes(line, frame.payload(), b"");
    }
}

impl<W: Write> PythonCsvWriter<W> {
    /// Writes to `out`.
    pub fn new(out: W) -> Self {
        Self { lines: HeadedLines::new(out, PYTHON_COLUMNS), only_bus: None, losses: Losses::default() }
    }

    fn note_losses(&mut self, record: &Record, buses: &Buses) {
        if *self.only_bus.get_or_insert(record.bus) != record.bus {
            self.losses.note(Loss::Buses);
        } else if buses.name(record.bus) != "can0" {
            self.losses.note(Loss::BusNames);
        }
        if record.direction == Direction::Sent {
            self.losses.note(Loss::Directions);
        }
        match &record.content {
            Content::Frame(recorded) if recorded.dlc_above_8.is_some() => self.losses.note(Loss::LengthCodes),
            Content::Error(error) if *error != ErrorFrame::UNSPECIFIED => self.losses.note(Loss::ErrorDetails),
            _ => {}
        }
    }
}

impl<W: Write> Writer for PythonCsvWriter<W> {
    fn put(&mut self, record: &Record, buses: &Buses) -> io::Result<()> {
        let left_out = match &record.content {
            Content::Frame(recorded) if recorded.is_fd() => Some(Loss::FdFrames),
            Content::Lost(_) => Some(Loss::LostCounts),
            _ => None,
        };
        if let Some(loss) = left_out {
            self.losses.note(loss);
            return Ok(());
        }
        self.note_losses(record, buses);
        let line = &mut self.lines.line;
        put_seconds(line, record.at.as_nanos(), 1, 9);
        match &record.content {
            Content::Frame(recorded) => {
                let frame = &recorded.frame;
                let is_remote = frame.kind == FrameKind::Remote;
                let flags = (u8::from(frame.id.is_extended()), u8::from(is_remote));
                let _ = write!(line, ",{:#x},{},{},0,{},", frame.id.raw(), flags.0, flags.1, frame.len());
                put_base64(line, if is_remote { &[] } else { frame.payload() });
            }
            _ => line.extend_from_slice(b",0x0,1,0,1,0,"),
        }
        self.lines.write()
    }

    fn finish(mut self: Box<Self>) -> io::Result<Losses> {
        self.lines.finish()?;
        Ok(self.losses)
    }
}
