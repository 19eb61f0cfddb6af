//! The log form, as `candump -L` prints it: whoever reads that reads this.

use std::io::{self, Write};

use crate::frame::{Frame, FrameKind};
use crate::traffic::losses::{Loss, Losses};
use crate::traffic::number::{put_bytes, put_hex, put_seconds};
use crate::traffic::socketcan::{fd_flags, id_word};
use crate::traffic::{Buses, Content, Direction, ErrorFrame, Record, RecordedFrame, Writer};

/// Writes the log form. Stamps have nine decimals where six are too few; sent
/// frames have a T behind them.
pub(in crate::traffic) struct Candump<W> {
    out: W,
    line: Vec<u8>,
    losses: Losses,
}

impl<W: Write> Candump<W> {
    /// Writes to `out`.
    pub fn new(out: W) -> Self {
        Self { out, line: Vec::new(), losses: Losses::default() }
    }

    fn put_name(&mut self, name: &str) {
        let is_blank = |c: char| c.is_whitespace() || c.is_control();
        if name.is_empty() || name.contains(is_blank) {
            self.losses.note(Loss::BusNames);
            let name = if name.is_empty() { "_".to_owned() } else { name.replace(is_blank, "_") };
            self.line.extend_from_slice(name.as_bytes());
        } else {
            self.line.extend_from_slice(name.as_bytes());
        }
    }
}

impl<W: Write> Writer for Candump<W> {
    fn put(&mut self, record: &Record, buses: &Buses) -> io::Result<()> {
        if matches!(record.content, Content::Lost(_)) {
            self.losses.note(Loss::LostCounts);
            return Ok(());
        }
        let nanos = record.at.as_nanos();
        self.line.clear();
        self.line.push(b'(');
        put_seconds(&mut self.line, nanos, 10, if nanos % 1_000 == 0 { 6 } else { 9 });
        self.line.extend_from_slice(b") ");
        self.put_name(buses.name(record.bus));
        self.line.push(b' ');
        match &record.content {
            Content::Frame(recorded) => put_frame(&mut self.line, recorded),
            Content::Error(error) => put_error(&mut self.line, error, &record.content),
            Content::Lost(_) => {}
        }
        if record.direction == Direction::Sent {
            self.line.extend_from_slice(b" T");
        }
        self.line.push(b'\n');
        self.out.write_all(&self.line)
    }

    fn finish(mut self: Box<Self>) -> io::Result<Losses> {
        self.out.flush()?;
        Ok(self.losses)
    }
}

fn put_frame(line: &mut Vec<u8>, recorded: &RecordedFrame) {
    let frame: &Frame = &recorded.frame;
    put_hex(line, frame.id.raw(), if frame.id.is_extended() { 8 } else { 3 });
    line.push(b'#');
    match frame.kind {
        FrameKind::Classic => put_bytes(line, frame.payload(), b""),
        FrameKind::Remote => {
            line.push(b'R');
            if !frame.is_empty() {
                put_hex(line, frame.len() as u32, 1);
            }
        }
        FrameKind::Fd | FrameKind::FdBitRateSwitch => {
            line.push(b'#');
            put_hex(line, u32::from(fd_flags(recorded)), 1);
            put_bytes(line, frame.payload(), b"");
        }
    }
    if let Some(dlc) = recorded.dlc_above_8 {
        line.push(b'_');
        put_hex(line, u32::from(dlc), 1);
    }
}

fn put_error(line: &mut Vec<u8>, error: &ErrorFrame, content: &Content) {
    put_hex(line, id_word(content), 8);
    line.push(b'#');
    put_bytes(line, &error.data, b"");
}
