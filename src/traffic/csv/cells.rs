//! The cells of a line, and what is in some of them.

use std::borrow::Cow;

use crate::traffic::words::{LineProblem, Word};

/// What is left of a line.
pub(super) struct Cells<'l> {
    line: &'l [u8],
    /// Past the end once the last cell has been taken.
    at: usize,
}

/// A cell and where it stands.
pub(super) struct Cell<'l> {
    pub text: Cow<'l, [u8]>,
    /// From 1.
    pub column: u64,
}

impl Cell<'_> {
    /// Its text as a word.
    pub fn word(&self) -> Word<'_> {
        Word { text: self.text.trim_ascii(), column: self.column }
    }
}

impl<'l> Cells<'l> {
    /// All cells of a line.
    pub fn of(line: &'l [u8]) -> Self {
        Self { line, at: 0 }
    }

    /// The next cell, or a complaint that there is no `wanted`.
    pub fn next(&mut self, wanted: &str) -> Result<Cell<'l>, LineProblem> {
        let column = self.at as u64 + 1;
        let Some(rest) = self.line.get(self.at..) else {
            let end = self.line.len() as u64 + 1;
            return Err(LineProblem::new(end, format!("the line ends where {wanted} was expected")));
        };
        if rest.first() == Some(&b'"') {
            return self.quoted(&rest[1..], column);
        }
        let len = memchr::memchr(b',', rest).unwrap_or(rest.len());
        self.at += len + 1;
        Ok(Cell { text: Cow::Borrowed(&rest[..len]), column })
    }

    /// Two quotation marks are one, one ends the cell.
    fn quoted(&mut self, rest: &[u8], column: u64) -> Result<Cell<'l>, LineProblem> {
        let mut text = Vec::new();
        let mut at = 0;
        loop {
            match (rest.get(at), rest.get(at + 1)) {
                (Some(b'"'), Some(b'"')) => {
                    text.push(b'"');
                    at += 2;
                }
                (Some(b'"'), None | Some(b',')) => {
                    self.at += at + 3;
                    return Ok(Cell { text: Cow::Owned(text), column });
                }
                (Some(b'"') | None, _) => {
                    return Err(LineProblem::new(
                        column,
                        "a cell begins with a quotation mark and does not end with one",
                    ));
                }
                (Some(&byte), _) => {
                    text.push(byte);
                    at += 1;
                }
            }
        }
    }
}

/// Bytes in base 64 (RFC 4648), filled up or not.
pub(super) fn base64(text: &[u8]) -> Option<Vec<u8>> {
    let text = text.trim_ascii();
    let padding = text.iter().rev().take_while(|byte| **byte == b'=').count();
    let digits = &text[..text.len() - padding];
    if padding > 2 || digits.len() % 4 == 1 {
        return None;
    }
    let mut bytes = Vec::with_capacity(digits.len() / 4 * 3 + 2);
    for group in digits.chunks(4) {
        let bits = group.iter().try_fold(0, |bits: u32, &digit| Some(bits << 6 | sextet(digit)?))?;
        let word = (bits << (6 * (4 - group.len()))).to_be_bytes();
        bytes.extend_from_slice(&word[1..group.len()]);
    }
    Some(bytes)
}

/// Appends bytes in base 64, filled up.
pub(super) fn put_base64(out: &mut Vec<u8>, bytes: &[u8]) {
    for group in bytes.chunks(3) {
        let byte = |at: usize| group.get(at).copied().unwrap_or(0);
        let bits = u32::from_be_bytes([0, byte(0), byte(1), byte(2)]);
        for digit in 0..4 {
            let sextet = bits >> (18 - 6 * digit) & 63;
            out.push(if digit > group.len() { b'=' } else { ALPHABET[sextet as usize] });
        }
    }
}

const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

fn sextet(digit: u8) -> Option<u32> {
    Some(match digit {
        b'A'..=b'Z' => u32::from(digit - b'A'),
        b'a'..=b'z' => u32::from(digit - b'a') + 26,
        b'0'..=b'9' => u32::from(digit - b'0') + 52,
        b'+' => 62,
        b'/' => 63,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base_64_is_read_as_it_is_written() {
        // The examples of RFC 4648.
        let examples = ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"];
        for (len, text) in examples.into_iter().enumerate() {
            let bytes = &b"foobar"[..len];
            let mut out = Vec::new();
            put_base64(&mut out, bytes);
            assert_eq!(out, text.as_bytes());
            assert_eq!(base64(text.as_bytes()).as_deref(), Some(bytes));
        }
        for bad in ["Z", "Zg=a", "Z===", "Zm9\u{e9}"] {
            assert_eq!(base64(bad.as_bytes()), None, "{bad}");
        }
    }

    #[test]
    fn cells_may_be_quoted() {
        let mut cells = Cells::of(b"1,\"a \"\"b\"\", c\",,\"\"");
        let texts: Vec<_> = (0..4).map(|_| cells.next("a cell").unwrap().text.into_owned()).collect();
        assert_eq!(texts, [&b"1"[..], b"a \"b\", c", b"", b""]);
        assert!(cells.next("a cell").is_err());
        assert!(Cells::of(b"\"open").next("a cell").is_err());
        assert!(Cells::of(b"\"a\"b").next("a cell").is_err());
    }
}
