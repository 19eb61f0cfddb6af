//! The `can-dbc` crate's parser, with a place for each of its complaints.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use can_dbc::{Dbc, DbcError};

use super::statements;
use crate::config::{Problem, Source};

/// Editors' mark at the start of a UTF-8 file, which is no part of a DBC.
const BYTE_ORDER_MARK: &str = "\u{FEFF}";
/// More than so many things that may stand somewhere help nobody.
const EXPECTED_MOST: usize = 8;

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
        let (place, label) = match &error {
            DbcError::Pest(_) => syntax_error(text),
            error => (line_of_conversion_error(text), error.to_string()),
        };
        Problem::at(source, place, "this is not a valid DBC file", label)
    })
}

/// Where a text stops making sense, and what would have made some there. The
/// parser only keeps track of all it tried when told to, so it runs again. The
/// switch is the process's: left on, no other thread can turn it off midway.
fn syntax_error(text: &str) -> (Range<usize>, String) {
    pest::set_error_detail(true);
    let Err(DbcError::Pest(error)) = Dbc::try_from(text) else {
        unreachable!("the same text was refused a moment ago")
    };
    let Some(attempts) = error.parse_attempts() else { return (0..0, error.to_string()) };
    let at = attempts.max_position;
    let label = format!(
        "found {}, expected {}",
        found(text, at),
        expected(attempts.expected_tokens().iter().map(ToString::to_string))
    );
    (word(text, at), label)
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
        "a blank or the end of the line".to_owned()
    } else {
        let shown: String = word.chars().take(30).collect();
        format!("`{shown}`")
    }
}

fn expected(tokens: impl Iterator<Item = String>) -> String {
    let mut names: Vec<String> = tokens.filter_map(|token| name(&token)).collect();
    names.dedup();
    match names.len() {
        1..=EXPECTED_MOST => names.join(" or "),
        _ => "a DBC statement such as BO_, SG_, CM_ or VAL_".to_owned(),
    }
}

/// What a person calls a token of the parser; nothing for blanks and
/// comments, which may stand anywhere.
fn name(token: &str) -> Option<String> {
    match token {
        " " | "\t" | "//" | "BUILTIN_RULE" => None,
        "\n" | "\r" | "\r\n" => Some("the end of the line".to_owned()),
        "0..9" => Some("a digit".to_owned()),
        "a..z" | "A..Z" => Some("a letter".to_owned()),
        token => Some(format!("`{token}`")),
    }
}
