//! What is wrong with a log, and where.

use std::fmt;

use crate::config::Severity;

/// One thing wrong with a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// An error where something that was logged could not be read, a warning
    /// where it could, but may not be what it seems.
    pub severity: Severity,
    /// Where.
    pub place: Place,
    /// What was found and what was expected.
    pub title: String,
}

/// Somewhere in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// Counted from 1, columns in bytes.
    Line {
        /// The line.
        line: u64,
        /// The byte in it.
        column: u64,
    },
    /// Counted from 0.
    Byte(u64),
    /// In what the chunk at byte `chunk` holds, before compression.
    Inside {
        /// Where the chunk begins in the file.
        chunk: u64,
        /// The byte in what it holds.
        byte: u64,
    },
}

impl Finding {
    /// Something that could not be read.
    pub fn error(place: Place, title: impl Into<String>) -> Self {
        Self { severity: Severity::Error, place, title: title.into() }
    }

    /// Something that could, but is doubtful.
    pub fn warning(place: Place, title: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(place, title) }
    }

    /// As a message about the file called `name`.
    pub fn of(&self, name: &str) -> String {
        let level = if self.severity == Severity::Error { "error" } else { "warning" };
        format!("{level}: {}\n --> {name}:{}", self.title, self.place)
    }
}

impl fmt::Display for Place {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line { line, column } => write!(out, "{line}:{column}"),
            Self::Byte(byte) => write!(out, "byte {byte}"),
            Self::Inside { chunk, byte } => write!(out, "byte {chunk}, there byte {byte} of what it holds"),
        }
    }
}
