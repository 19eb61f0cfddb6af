//! Reads formats that have a line for each record.

use std::io::Read;

use super::lines::{Line, Lines};
use super::words::LineProblem;
use super::{Buses, Finding, Place, Reader, Record};
use crate::config::Severity;

/// Understands the lines of one format.
pub(super) trait LineFormat {
    /// What a line says: a record, or nothing, such as a comment does.
    fn line(&mut self, line: &[u8], buses: &mut Buses) -> Result<Option<Record>, LineProblem>;

    /// Something to be said of the file as a whole, once it has been read.
    fn remark(&mut self) -> Option<&'static str> {
        None
    }

    /// Whether the latest line, which said a record, would not have said it had
    /// its end been missing, as where a line gives the length of its data.
    fn tells_cut_lines(&self) -> bool {
        true
    }
}

/// Goes through the lines of a file.
pub(super) struct LineReader<R, F> {
    lines: Lines<R>,
    format: F,
    buses: Buses,
    /// To be said after the record that it is about.
    waiting: Option<Finding>,
    ended: bool,
}

impl<R: Read, F: LineFormat> LineReader<R, F> {
    /// Reads `reader` as `format`.
    pub fn new(reader: R, format: F) -> Self {
        Self { lines: Lines::of(reader), format, buses: Buses::default(), waiting: None, ended: false }
    }

    fn step(&mut self) -> Step {
        let line = match self.lines.next() {
            Ok(Some(line)) => line,
            Ok(None) => return Step::End,
            Err(error) => {
                self.ended = true;
                let place = Place::Line { line: self.lines.number + 1, column: 1 };
                return Step::Found(Finding::error(place, format!("cannot read on: {error}")));
            }
        };
        let (text, ended) = match line {
            Line::Whole(text) => (text, true),
            Line::Unended(text) => (text, false),
            Line::TooLong => {
                let place = Place::Line { line: self.lines.number, column: 1 };
                return Step::Found(Finding::error(place, "the line is too long to be one of a log"));
            }
        };
        let end = text.len() as u64 + 1;
        // The first digit of a byte whose second is missing is a number, too.
        let ends_in_a_digit = matches!(text.trim_ascii_end(), [.., b' ', _]);
        let said = self.format.line(text, &mut self.buses);
        let place = |column| Place::Line { line: self.lines.number, column };
        match said {
            Ok(Some(record)) => {
                if !ended && (ends_in_a_digit || !self.format.tells_cut_lines()) {
                    let title = "the file ends in the middle of a line: its last frame may be cut short";
                    self.waiting = Some(Finding::warning(place(end), title));
                }
                Step::Read(record)
            }
            Ok(None) => Step::Nothing,
            Err(LineProblem { column, mut title, is_warning }) => {
                if !ended {
                    title.push_str(", and the file ends in the middle of this line");
                }
                let severity = if is_warning { Severity::Warning } else { Severity::Error };
                Step::Found(Finding { severity, place: place(column), title })
            }
        }
    }
}

/// What became of a line.
#[allow(clippy::large_enum_variant, reason = "it is taken apart at once")]
enum Step {
    Read(Record),
    Found(Finding),
    Nothing,
    End,
}

impl<R: Read, F: LineFormat> Iterator for LineReader<R, F> {
    type Item = Result<Record, Finding>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Some(finding) = self.waiting.take() {
            return Some(Err(finding));
        }
        while !self.ended {
            match self.step() {
                Step::Read(record) => return Some(Ok(record)),
                Step::Found(finding) => return Some(Err(finding)),
                Step::Nothing => {}
                Step::End => {
                    self.ended = true;
                    let place = Place::Line { line: 1, column: 1 };
                    return self.format.remark().map(|remark| Err(Finding::warning(place, remark)));
                }
            }
        }
        None
    }
}

impl<R: Read, F: LineFormat> Reader for LineReader<R, F> {
    fn buses(&self) -> &Buses {
        &self.buses
    }
}
