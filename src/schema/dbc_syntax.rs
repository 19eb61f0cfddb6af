//! The `can-dbc` crate's parser, with a place for each of its complaints.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use can_dbc::{Dbc, DbcError};
use pest::error::{ErrorVariant, InputLocation};

use super::statements;
use crate::config::{Problem, Source};

/// Editors' mark at the start of a UTF-8 file, which is no part of a DBC.
const BYTE_ORDER_MARK: &str = "\u{FEFF}";

/// The text with blanks for a byte order mark, so that every place stays
/// where it was.
pub(super) fn without_byte_order_mark(text: &str) -> Cow<'_, str> {
    match text.strip_prefix(BYTE_ORDER_MARK) {
        Some(rest) => Cow::Owned(" ".repeat(BYTE_ORDER_MARK.len()) + rest),
        None => Cow::Borrowed(text),
    }
}

/// Parses `text`, which is the text of `source` but for a byte order mark.
pub(super) fn parse(source: &Arc<Source>, text: &str) -> Result<Dbc, Problem> {
    Dbc::try_from(text).map_err(|error| {
        let title = "this is not a valid DBC file";
        match &error {
            DbcError::Pest(error) => {
                let at = match error.location {
                    InputLocation::Pos(at) | InputLocation::Span((at, _)) => at,
                };
                let expected = match &error.variant {
                    ErrorVariant::ParsingError { positives, .. } => expected(positives),
                    ErrorVariant::CustomError { message } => message.clone(),
                };
                Problem::at(source, word(text, at), title, format!("found {}, expected {expected}", found(text, at)))
            }
            error => Problem::at(source, line_of_conversion_error(text), title, error.to_string()),
        }
    })
}

/// The line whose values cannot be converted. The parser names no place once
/// the grammar is satisfied, so look for the shortest text that it refuses.
fn line_of_conversion_error(text: &str) -> Range<usize> {
    let lines = statements::lines_outside_strings(text);
    let sound = lines.partition_point(|line| Dbc::try_from(&text[..line.end]).is_ok());
    lines.get(sound).map_or(0..0, |line| line.span.clone())
}

fn word(text: &str, at: usize) -> Range<usize> {
    let rest = &text[at..];
    at..at + rest.find(char::is_whitespace).unwrap_or(rest.len())
}

fn found(text: &str, at: usize) -> String {
    let word = &text[word(text, at)];
    if text[at..].is_empty() {
        "the end of the file".to_owned()
    } else if word.is_empty() {
        "the end of the line or a blank".to_owned()
    } else {
        let shown: String = word.chars().take(30).collect();
        format!("`{shown}`")
    }
}

/// The grammar's own names for what may stand here; where a new statement may
/// begin there are too many to list.
fn expected(rules: &[impl std::fmt::Debug]) -> String {
    let mut names: Vec<String> = rules.iter().map(|rule| format!("{rule:?}").replace('_', " ")).collect();
    names.sort();
    names.dedup();
    if names.len() > 8 { "a DBC statement such as BO_, SG_, CM_ or VAL_".to_owned() } else { names.join(" or ") }
}
