//! The lines of a file of any size, one at a time.

use std::io::{self, Read};

/// A line longer than this is none of a log.
const LONGEST: usize = 64 << 10;

/// Reads lines, whichever of LF, CR LF and CR ends them.
pub(super) struct Lines<R> {
    reader: R,
    buffer: Vec<u8>,
    /// What has been read and not yet been given out.
    waiting: std::ops::Range<usize>,
    /// Of the line given out last, from 1.
    pub number: u64,
    at_end: bool,
    after_cr: bool,
}

/// A line.
pub(super) enum Line<'b> {
    /// Without its end.
    Whole(&'b [u8]),
    /// The file ends in it.
    Unended(&'b [u8]),
    /// It was skipped.
    TooLong,
}

/// Where a line in the buffer is.
enum Found {
    Whole { end: usize, next: usize },
    TooLong,
    Unended,
    Nothing,
}

impl<R: Read> Lines<R> {
    /// The lines of `reader`.
    pub fn of(reader: R) -> Self {
        Self { reader, buffer: vec![0; 2 * LONGEST], waiting: 0..0, number: 0, at_end: false, after_cr: false }
    }

    /// The next line; `None` at the end.
    pub fn next(&mut self) -> io::Result<Option<Line<'_>>> {
        let start = self.waiting.start;
        let found = self.find()?;
        let start = if matches!(found, Found::Nothing) { start } else { self.waiting.start };
        self.number += u64::from(!matches!(found, Found::Nothing));
        let text = |start: usize, end: usize| {
            let text = &self.buffer[start..end];
            // Some editors put a mark at the beginning of a file.
            if self.number == 1 { text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text) } else { text }
        };
        Ok(match found {
            Found::Whole { end, next } => {
                self.waiting.start = next;
                Some(Line::Whole(text(start, end)))
            }
            Found::Unended => {
                let end = self.waiting.end;
                self.waiting.start = end;
                Some(Line::Unended(text(start, end)))
            }
            Found::TooLong => Some(Line::TooLong),
            Found::Nothing => None,
        })
    }

    fn find(&mut self) -> io::Result<Found> {
        if self.after_cr {
            self.skip_lf_after_cr()?;
        }
        let mut searched = 0;
        loop {
            let waiting = &self.buffer[self.waiting.clone()];
            if let Some(len) = memchr::memchr2(b'\n', b'\r', &waiting[searched..]).map(|at| at + searched) {
                let end = self.waiting.start + len;
                self.after_cr = self.buffer[end] == b'\r';
                return Ok(Found::Whole { end, next: end + 1 });
            }
            searched = waiting.len();
            if searched > LONGEST {
                self.skip_line()?;
                return Ok(Found::TooLong);
            }
            if self.at_end {
                return Ok(if searched == 0 { Found::Nothing } else { Found::Unended });
            }
            self.fill()?;
        }
    }

    fn skip_lf_after_cr(&mut self) -> io::Result<()> {
        self.after_cr = false;
        if self.waiting.is_empty() && !self.at_end {
            self.fill()?;
        }
        if self.buffer[self.waiting.clone()].first() == Some(&b'\n') {
            self.waiting.start += 1;
        }
        Ok(())
    }

    fn skip_line(&mut self) -> io::Result<()> {
        loop {
            if let Some(len) = memchr::memchr(b'\n', &self.buffer[self.waiting.clone()]) {
                self.waiting.start += len + 1;
                return Ok(());
            }
            self.waiting.start = self.waiting.end;
            if self.at_end {
                return Ok(());
            }
            self.fill()?;
        }
    }

    /// Moves what is waiting to the front and reads more behind it.
    fn fill(&mut self) -> io::Result<()> {
        self.buffer.copy_within(self.waiting.clone(), 0);
        self.waiting = 0..self.waiting.len();
        let room = &mut self.buffer[self.waiting.end..];
        let read = loop {
            match self.reader.read(room) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                read => break read?,
            }
        };
        self.at_end = read == 0;
        self.waiting.end += read;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(bytes: &[u8]) -> Vec<String> {
        let mut lines = Lines::of(bytes);
        let mut all = Vec::new();
        while let Some(line) = lines.next().unwrap() {
            all.push(match line {
                Line::Whole(text) => String::from_utf8_lossy(text).into_owned(),
                Line::Unended(text) => format!("{}...", String::from_utf8_lossy(text)),
                Line::TooLong => "too long".to_owned(),
            });
        }
        assert_eq!(lines.number, all.len() as u64);
        all
    }

    #[test]
    fn lines_end_in_each_way_that_there_is() {
        assert_eq!(all(b"a\nb\r\nc\rd\r\r\n\ne"), ["a", "b", "c", "d", "", "", "e..."]);
        assert_eq!(all(b""), [""; 0]);
        assert_eq!(all(b"a\r"), ["a"]);
        assert_eq!(all(b"\xEF\xBB\xBFa\n\xEF\xBB\xBFb\n"), ["a", "\u{FEFF}b"]);
    }

    #[test]
    fn an_endless_line_is_skipped_in_little_memory() {
        let mut bytes = b"a\n".to_vec();
        bytes.resize(1 << 20, b'x');
        bytes.extend_from_slice(b"\nb\n");
        assert_eq!(all(&bytes), ["a", "too long", "b"]);
    }
}
