//! The words, numbers, strings and signs that a DBC file is made of, each with
//! its place.

use std::ops::Range;

/// One of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Token {
    pub kind: Kind,
    /// Bytes of the text; a string's quotes included.
    pub span: Range<usize>,
    /// Whether nothing but blanks and comments stands before it in its line.
    pub begins_line: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A name or a keyword.
    Word,
    /// As far as its look goes; its value may yet be out of range.
    Number,
    /// In double quotes, over several lines perhaps; `\"` is a quote in it.
    Text,
    /// A string that nothing ends; it is taken to end with its line.
    OpenText,
    /// `:`, `;`, `|` and the like, and whatever has no business in a DBC.
    Sign(char),
}

/// Takes `text` apart.
pub(super) fn tokens(text: &str) -> Vec<Token> {
    let mut scanner = Scanner { text, at: 0, begins_line: true };
    std::iter::from_fn(|| scanner.next()).collect()
}

struct Scanner<'t> {
    text: &'t str,
    at: usize,
    begins_line: bool,
}

impl Scanner<'_> {
    fn next(&mut self) -> Option<Token> {
        self.skip_blanks();
        let rest = &self.text[self.at..];
        let first = rest.chars().next()?;
        let (kind, len) = match first {
            '"' => text_len(rest),
            _ if starts_number(rest) => number_len(rest),
            _ if is_word(first) => (Kind::Word, word_len(rest)),
            sign => (Kind::Sign(sign), sign.len_utf8()),
        };
        let span = self.at..self.at + len;
        self.at = span.end;
        Some(Token { kind, span, begins_line: std::mem::take(&mut self.begins_line) })
    }

    /// Blanks, an editor's byte order mark, and `//` to the end of the line.
    fn skip_blanks(&mut self) {
        loop {
            let rest = &self.text[self.at..];
            let len = match rest.chars().next() {
                Some(blank) if blank.is_whitespace() || blank == '\u{FEFF}' => {
                    self.begins_line |= matches!(blank, '\n' | '\r');
                    blank.len_utf8()
                }
                Some('/') if rest.starts_with("//") => rest.find(['\n', '\r']).unwrap_or(rest.len()),
                _ => return,
            };
            self.at += len;
        }
    }
}

fn is_word(char: char) -> bool {
    char.is_alphanumeric() || char == '_'
}

fn word_len(rest: &str) -> usize {
    rest.find(|char| !is_word(char)).unwrap_or(rest.len())
}

fn starts_number(rest: &str) -> bool {
    let unsigned = rest.strip_prefix(['+', '-']).unwrap_or(rest);
    unsigned.strip_prefix('.').unwrap_or(unsigned).starts_with(|char: char| char.is_ascii_digit())
}

/// A number, or a word that begins like one: `3rdParty`, `0x1F`, `1.#QNAN`.
fn number_len(rest: &str) -> (Kind, usize) {
    let bytes = rest.as_bytes();
    let digits = |from: usize| bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let mut len = usize::from(matches!(bytes[0], b'+' | b'-'));
    len += digits(len);
    if bytes.get(len) == Some(&b'.') {
        len += 1;
        len += digits(len);
    }
    if matches!(bytes.get(len), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(len + 1), Some(b'+' | b'-')));
        let exponent = digits((len + 1 + sign).min(bytes.len()));
        if exponent > 0 {
            len += 1 + sign + exponent;
        }
    }
    let tail = rest[len..].find(|char| !is_word(char) && char != '#').unwrap_or(rest.len() - len);
    (if tail > 0 { Kind::Word } else { Kind::Number }, len + tail)
}

/// A quote after a backslash belongs to the string, unless nothing else ends
/// it: people write `"C:\"` too.
fn text_len(rest: &str) -> (Kind, usize) {
    let is_escaped = |at: usize| rest.as_bytes()[at - 1] == b'\\';
    let mut quotes = rest.match_indices('"').map(|(at, _)| at).skip(1);
    if let Some(at) = quotes.find(|&at| !is_escaped(at)) {
        return (Kind::Text, at + 1);
    }
    let line = &rest[..rest.find(['\n', '\r']).unwrap_or(rest.len())];
    match line.rfind('"') {
        Some(at) if at > 0 => (Kind::Text, at + 1),
        _ => (Kind::OpenText, line.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str) -> Vec<&str> {
        tokens(text).into_iter().map(|token| &text[token.span]).collect()
    }

    #[test]
    fn a_signal_falls_into_its_parts() {
        let text = "\u{FEFF}SG_ S m0M:0|8@1-(1E-05,-.5)[-1|1.#QNAN]\"°C\" A,3rd // end";
        let parts = [
            "SG_", "S", "m0M", ":", "0", "|", "8", "@", "1", "-", "(", "1E-05", ",", "-.5", ")", "[", "-1", "|",
            "1.#QNAN", "]", "\"°C\"", "A", ",", "3rd",
        ];
        assert_eq!(shown(text), parts);
    }

    #[test]
    fn strings_run_over_lines_and_may_hold_quotes_and_comments() {
        assert_eq!(shown("\"a \\\" // \n b\";"), ["\"a \\\" // \n b\"", ";"]);
        assert_eq!(shown("\"C:\\\" ;\n"), ["\"C:\\\"", ";"]);
    }

    #[test]
    fn a_string_that_nothing_ends_ends_with_its_line() {
        let found = tokens("CM_ \"open\nBO_");
        assert_eq!(found[1].kind, Kind::OpenText);
        assert_eq!((&found[2].kind, found[2].begins_line), (&Kind::Word, true));
    }
}
