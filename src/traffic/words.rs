//! A line taken apart into words, with the column of each for complaints.

use super::number;

/// What is left of a line.
#[derive(Clone)]
pub(super) struct Words<'l> {
    line: &'l [u8],
    at: usize,
}

/// A word and where it stands.
#[derive(Clone, Copy)]
pub(super) struct Word<'l> {
    pub text: &'l [u8],
    /// From 1.
    pub column: u64,
}

/// What is wrong with a line.
#[derive(Debug)]
pub(super) struct LineProblem {
    /// From 1.
    pub column: u64,
    pub title: String,
    /// Whether the line was read all the same.
    pub is_warning: bool,
}

/// Words longer than this are shortened in complaints.
const SHOWN: usize = 24;

impl<'l> Words<'l> {
    /// All words of a line.
    pub fn of(line: &'l [u8]) -> Self {
        Self { line, at: 0 }
    }

    /// The next word, or a complaint that there is no `wanted`.
    pub fn expect(&mut self, wanted: &str) -> Result<Word<'l>, LineProblem> {
        let end = self.line.len() as u64 + 1;
        self.next().ok_or_else(|| LineProblem::new(end, format!("the line ends where {wanted} was expected")))
    }

    /// The rest of the line, without blanks around it.
    pub fn rest(&self) -> &'l [u8] {
        self.line[self.at..].trim_ascii()
    }

    /// The column of what comes next.
    pub fn column(&self) -> u64 {
        self.at as u64 + 1
    }
}

impl<'l> Iterator for Words<'l> {
    type Item = Word<'l>;

    fn next(&mut self) -> Option<Word<'l>> {
        let rest = &self.line[self.at..];
        let start = rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
        let rest = &rest[start..];
        let len = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let column = (self.at + start) as u64 + 1;
        self.at += start + len;
        Some(Word { text: &rest[..len], column })
    }
}

impl Word<'_> {
    /// A complaint about it.
    pub fn problem(&self, wanted: &str) -> LineProblem {
        LineProblem::new(self.column, format!("found `{}`, expected {wanted}", shown(self.text)))
    }

    /// A whole number.
    pub fn decimal(&self, wanted: &str) -> Result<u64, LineProblem> {
        number::decimal(self.text).ok_or_else(|| self.problem(wanted))
    }

    /// A number in `radix` 10 or 16.
    pub fn number(&self, radix: u32, wanted: &str) -> Result<u32, LineProblem> {
        let value = match radix {
            16 => number::hex(self.text),
            _ => number::decimal(self.text).and_then(|number| u32::try_from(number).ok()),
        };
        value.ok_or_else(|| self.problem(wanted))
    }

    /// Time in units of 10^`exponent` s.
    pub fn nanos(&self, exponent: i32) -> Result<i64, LineProblem> {
        number::nanos(self.text, exponent).ok_or_else(|| self.problem("a time"))
    }
}

impl LineProblem {
    /// A complaint.
    pub fn new(column: u64, title: impl Into<String>) -> Self {
        Self { column, title: title.into(), is_warning: false }
    }

    /// Word about a line that could be read all the same.
    pub fn warning(column: u64, title: impl Into<String>) -> Self {
        Self { is_warning: true, ..Self::new(column, title) }
    }
}

/// Text for a message: on one line, and not too long.
pub(super) fn shown(text: &[u8]) -> String {
    let all = String::from_utf8_lossy(&text[..text.len().min(4 * SHOWN)]);
    let mut shown: String = all.chars().take(SHOWN).flat_map(char::escape_debug).collect();
    if text.len() > SHOWN {
        shown.push_str("...");
    }
    shown
}
