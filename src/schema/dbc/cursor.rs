//! Reading tokens one after the other, and saying what was expected where
//! something else stands.

use std::ops::Range;

use super::statements::At;
use super::tokens::{Kind, Token};

/// Steps through the tokens of a text.
pub(super) struct Cursor<'t> {
    text: &'t str,
    tokens: Vec<Token>,
    at: usize,
}

/// Something that does not belong where it stands.
pub(super) struct Misfit {
    pub span: Range<usize>,
    pub label: String,
}

/// What begins a statement.
const KEYWORDS: [&str; 35] = [
    "BA_",
    "BA_DEF_",
    "BA_DEF_DEF_",
    "BA_DEF_DEF_REL_",
    "BA_DEF_REL_",
    "BA_DEF_SGTYPE_",
    "BA_REL_",
    "BA_SGTYPE_",
    "BO_",
    "BO_TX_BU_",
    "BS_",
    "BU_",
    "BU_BO_REL_",
    "BU_EV_REL_",
    "BU_SG_REL_",
    "CAT_",
    "CAT_DEF_",
    "CM_",
    "ENVVAR_DATA_",
    "EV_",
    "EV_DATA_",
    "FILTER",
    "NS_",
    "NS_DESC_",
    "SG_",
    "SGTYPE_",
    "SGTYPE_VAL_",
    "SG_MUL_VAL_",
    "SIGTYPE_VALTYPE_",
    "SIG_GROUP_",
    "SIG_TYPE_REF_",
    "SIG_VALTYPE_",
    "VAL_",
    "VAL_TABLE_",
    "VERSION",
];

/// Keywords that name what kind of thing a statement speaks of.
const OBJECTS: [&str; 4] = ["BO_", "BU_", "EV_", "SG_"];

impl<'t> Cursor<'t> {
    pub const fn new(text: &'t str, tokens: Vec<Token>) -> Self {
        Self { text, tokens, at: 0 }
    }

    pub fn peek(&self) -> Option<&Token> {
        self.tokens.get(self.at)
    }

    /// Whether the next word, which may stand in a list of keywords, begins a
    /// statement instead: what follows it is no keyword.
    pub fn is_before_content(&self, in_first_line: bool) -> bool {
        let Some(second) = self.tokens.get(self.at + 1) else { return false };
        match second.kind {
            Kind::Sign(':') => true,
            _ if second.begins_line => false,
            Kind::Word if looks_like_keyword(self.text_of(second)) => {
                !in_first_line && self.peek_text() == "CM_" && OBJECTS.contains(&self.text_of(second))
            }
            _ => true,
        }
    }

    pub fn next(&mut self) -> Option<Token> {
        let token = self.tokens.get(self.at).cloned()?;
        self.at += 1;
        Some(token)
    }

    pub fn text_of(&self, token: &Token) -> &'t str {
        &self.text[token.span.clone()]
    }

    /// The next token's text; empty at the end.
    pub fn peek_text(&self) -> &'t str {
        self.peek().map_or("", |token| self.text_of(token))
    }

    /// Where the token before the next one ends.
    pub fn end(&self) -> usize {
        self.at.checked_sub(1).map_or(0, |before| self.tokens[before].span.end)
    }

    /// Whether the next token begins another statement, or there is none.
    pub fn is_at_statement(&self) -> bool {
        self.peek().is_none_or(|token| {
            let text = self.text_of(token);
            token.kind == Kind::Word
                && match token.begins_line {
                    true => KEYWORDS.contains(&text) || looks_like_keyword(text),
                    false => KEYWORDS.contains(&text) && text.ends_with('_'),
                }
        })
    }

    /// Goes on to the next statement that begins a line, or to the end.
    pub fn skip_statement(&mut self) {
        while !(self.is_at_statement() && self.peek().is_none_or(|token| token.begins_line)) {
            self.at += 1;
        }
    }

    /// Goes past the next `;`; false when another statement comes first.
    pub fn skip_past_semicolon(&mut self) -> bool {
        while !(self.peek().is_none_or(|token| token.begins_line) && self.is_at_statement()) {
            if self.next().is_some_and(|token| token.kind == Kind::Sign(';')) {
                return true;
            }
        }
        false
    }

    pub fn take_sign(&mut self, sign: char) -> bool {
        let found = self.peek().is_some_and(|token| token.kind == Kind::Sign(sign));
        self.at += usize::from(found);
        found
    }

    pub fn take_number(&mut self) -> bool {
        let found = self.peek().is_some_and(|token| token.kind == Kind::Number);
        self.at += usize::from(found);
        found
    }

    pub fn sign(&mut self, sign: char) -> Result<(), Misfit> {
        if self.take_sign(sign) { Ok(()) } else { Err(self.misfit(&format!("`{sign}`"))) }
    }

    /// A name, or anything that looks like one.
    pub fn word(&mut self, what: &str) -> Result<At<&'t str>, Misfit> {
        match self.peek() {
            Some(token) if matches!(token.kind, Kind::Word | Kind::Number) => {
                let span = token.span.clone();
                self.at += 1;
                Ok(At { is: &self.text[span.clone()], span })
            }
            _ => Err(self.misfit(what)),
        }
    }

    /// A string, without its quotes.
    pub fn string(&mut self, what: &str) -> Result<At<String>, Misfit> {
        match self.peek() {
            Some(token) if token.kind == Kind::Text => {
                let span = token.span.clone();
                self.at += 1;
                Ok(At { is: self.text[span.start + 1..span.end - 1].replace("\\\"", "\""), span })
            }
            Some(token) if token.kind == Kind::OpenText => {
                Err(Misfit { span: token.span.clone(), label: "found a string without its closing `\"`".to_owned() })
            }
            _ => Err(self.misfit(what)),
        }
    }

    /// A string that is a name, as it is in the text.
    pub fn quoted_name(&mut self, what: &str) -> Result<&'t str, Misfit> {
        let At { span, .. } = self.string(what)?;
        Ok(&self.text[span.start + 1..span.end - 1])
    }

    /// A whole number, 0 or more.
    pub fn count(&mut self, what: &str) -> Result<At<u64>, Misfit> {
        let whole = self.whole(what)?;
        match u64::try_from(whole.is) {
            Ok(is) => Ok(At { is, span: whole.span }),
            Err(_) => Err(Misfit { label: format!("found {}, expected {what}", whole.is), span: whole.span }),
        }
    }

    /// A whole number; `1.0` will do, and `0x1F`.
    pub fn whole(&mut self, what: &str) -> Result<At<i128>, Misfit> {
        let text = self.peek_text();
        let number = parse_whole(text).ok_or_else(|| self.misfit(what))?;
        let span = self.next().expect("there was one").span;
        Ok(At { is: number, span })
    }

    /// A number.
    pub fn number(&mut self, what: &str) -> Result<f64, Misfit> {
        match self.peek() {
            Some(token) if token.kind == Kind::Number => {
                let number = self.text_of(token).parse().map_err(|_| self.misfit(what))?;
                self.at += 1;
                Ok(number)
            }
            _ => Err(self.misfit(what)),
        }
    }

    /// Says that the next token is not what was expected.
    pub fn misfit(&self, expected: &str) -> Misfit {
        match self.peek() {
            None => Misfit {
                span: self.end()..self.end(),
                label: format!("found the end of the file, expected {expected}"),
            },
            Some(token) => {
                let shown: String = self.text_of(token).lines().next().unwrap_or("").chars().take(30).collect();
                Misfit { span: token.span.clone(), label: format!("found `{shown}`, expected {expected}") }
            }
        }
    }
}

fn looks_like_keyword(text: &str) -> bool {
    text.len() > 2
        && text.ends_with('_')
        && text.chars().all(|char| char.is_ascii_uppercase() || char.is_ascii_digit() || char == '_')
}

pub(super) fn parse_whole(text: &str) -> Option<i128> {
    if let Some(digits) = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        return i128::from_str_radix(digits, 16).ok();
    }
    text.parse().ok().or_else(|| {
        let number: f64 = if starts_like_number(text) { text.parse().ok()? } else { return None };
        (number.fract() == 0.0 && number.abs() < 1e15).then_some(number as i128)
    })
}

fn starts_like_number(text: &str) -> bool {
    text.starts_with(|first: char| first.is_ascii_digit() || matches!(first, '+' | '-' | '.'))
}
