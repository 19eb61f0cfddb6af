//! From the tokens of a DBC file to its statements. A statement that makes no
//! sense is reported and passed over; the next one is read as if nothing had
//! happened.

use std::ops::Range;

use super::cursor::{Cursor, Misfit};
use super::findings::Findings;
use super::statements::{At, Message, Signal, Statements};
use super::tokens::{Kind, tokens};

/// Statements that say nothing of how a frame is read or written.
const PASSED_OVER: [&str; 21] = [
    "BA_DEF_DEF_REL_",
    "BA_DEF_REL_",
    "BA_DEF_SGTYPE_",
    "BA_REL_",
    "BA_SGTYPE_",
    "BO_TX_BU_",
    "BU_BO_REL_",
    "BU_EV_REL_",
    "BU_SG_REL_",
    "CAT_",
    "CAT_DEF_",
    "ENVVAR_DATA_",
    "EV_",
    "EV_DATA_",
    "FILTER",
    "NS_DESC_",
    "SGTYPE_",
    "SGTYPE_VAL_",
    "SIGTYPE_VALTYPE_",
    "SIG_GROUP_",
    "SIG_TYPE_REF_",
];

/// Statements without which frames are still read as they should be.
const DISPENSABLE: [&str; 6] = ["BA_DEF_", "BS_", "BU_", "CM_", "NS_", "VERSION"];

/// Reads all statements of the file whose `findings` these are.
pub(super) fn statements<'t>(findings: &mut Findings<'t>) -> Statements<'t> {
    let text = findings.source.text.as_str();
    let cursor = Cursor::new(text, tokens(text));
    let mut reader = Reader { findings, cursor, found: Statements::default(), last_message_failed: false };
    while reader.cursor.peek().is_some() {
        reader.statement();
    }
    reader.found
}

/// How a statement is written.
fn form(keyword: &str) -> &'static str {
    match keyword {
        "BO_" => "a message is written as BO_ 256 Name: 8 Sender",
        "SG_" => "a signal is written as SG_ Name : 0|16@1+ (1,0) [0|0] \"unit\" Receiver",
        "CM_" => "a comment is written as CM_ SG_ 256 Name \"Text.\";",
        "BA_" => "an attribute is written as BA_ \"Name\" BO_ 256 10;",
        "BA_DEF_" => "an attribute is defined as BA_DEF_ BO_ \"Name\" INT 0 65535;",
        "BA_DEF_DEF_" => "the default of an attribute is written as BA_DEF_DEF_ \"Name\" 0;",
        "VAL_" => "names of values are written as VAL_ 256 Name 0 \"Off\" 1 \"On\" ;",
        "VAL_TABLE_" => "a value table is written as VAL_TABLE_ Name 0 \"Off\" 1 \"On\" ;",
        "SIG_VALTYPE_" => "a floating-point signal is marked as SIG_VALTYPE_ 256 Name : 1;",
        "SG_MUL_VAL_" => "switch values are written as SG_MUL_VAL_ 256 Name Switch 0-3, 7-7;",
        "VERSION" => "a version is written as VERSION \"1.0\"",
        _ => "such a list is written with a colon, as BU_: A B",
    }
}

pub(super) struct Reader<'t, 'f> {
    findings: &'f mut Findings<'t>,
    pub(super) cursor: Cursor<'t>,
    pub(super) found: Statements<'t>,
    /// The signals that follow are nobody's, which goes without saying.
    last_message_failed: bool,
}

impl<'t> Reader<'t, '_> {
    fn statement(&mut self) {
        let Some(first) = self.cursor.next() else { return };
        let keyword = self.cursor.text_of(&first);
        let read = match keyword {
            "BO_" => self.message(),
            "SG_" => self.signal(first.span.start),
            "CM_" => self.comment(),
            "BA_" => self.attribute(),
            "BA_DEF_" => self.definition(),
            "BA_DEF_DEF_" => self.default(),
            "VAL_" => self.values(),
            "VAL_TABLE_" => self.table(),
            "SIG_VALTYPE_" => self.number_type(),
            "SG_MUL_VAL_" => self.selection(first.span.start),
            "VERSION" => self.version(),
            "NS_" => self.new_symbols(),
            "BS_" => self.bit_timing(),
            "BU_" => self.nodes(),
            _ if PASSED_OVER.contains(&keyword) => self.pass_over(keyword),
            _ => self.unknown(keyword, first.span),
        };
        if let Err(Misfit { span, label }) = read {
            let title = format!("this {keyword} statement cannot be read");
            let hint = form(keyword);
            if DISPENSABLE.contains(&keyword) {
                self.findings.warn(&span, title, label, hint);
            } else {
                self.findings.error(&span, title, label, hint);
            }
            self.last_message_failed |= keyword == "BO_";
            self.cursor.skip_statement();
        }
    }

    /// Something without a closing `;` is read as if it had one.
    pub(super) fn semicolon(&mut self, keyword: &str) -> Result<(), Misfit> {
        if self.cursor.take_sign(';') {
            return Ok(());
        }
        if !self.cursor.is_at_statement() {
            return Err(self.cursor.misfit("`;`"));
        }
        let end = self.cursor.end();
        self.findings.warn(&(end..end), format!("this {keyword} statement has no end"), "expected `;`", "add a `;`");
        Ok(())
    }

    fn unknown(&mut self, keyword: &str, span: Range<usize>) -> Result<(), Misfit> {
        let shown: String = keyword.chars().take(30).collect();
        let label = "expected a statement such as BO_, SG_, CM_ or VAL_";
        self.findings.warn(&span, format!("`{shown}` is no DBC statement"), label, "it is passed over; take it out");
        if !self.cursor.skip_past_semicolon() {
            self.cursor.skip_statement();
        }
        Ok(())
    }

    fn pass_over(&mut self, keyword: &str) -> Result<(), Misfit> {
        let end = self.cursor.end();
        if !self.cursor.skip_past_semicolon() {
            self.findings.warn(
                &(end..end),
                format!("this {keyword} statement has no end"),
                "expected `;`",
                "add a `;`",
            );
        }
        Ok(())
    }

    fn version(&mut self) -> Result<(), Misfit> {
        self.cursor.string("a string").map(|_| ())
    }

    /// The list of keywords that a tool knew: it runs to the first that says
    /// something.
    fn new_symbols(&mut self) -> Result<(), Misfit> {
        self.cursor.sign(':')?;
        let mut shares_line = true;
        while let Some(token) = self.cursor.peek().filter(|token| token.kind == Kind::Word) {
            shares_line &= !token.begins_line;
            if self.cursor.is_before_content(shares_line) {
                break;
            }
            self.cursor.next();
        }
        Ok(())
    }

    /// `BS_:`, the bit rate, which nobody fills in any more.
    fn bit_timing(&mut self) -> Result<(), Misfit> {
        self.cursor.sign(':')?;
        while self.cursor.peek().is_some_and(|token| token.kind != Kind::Word) {
            self.cursor.next();
        }
        Ok(())
    }

    fn nodes(&mut self) -> Result<(), Misfit> {
        self.cursor.sign(':')?;
        while !self.cursor.is_at_statement() {
            let node = self.cursor.word("the name of a node")?;
            self.found.nodes.push(node);
            while self.cursor.take_sign(',') || self.cursor.take_sign(';') {}
        }
        Ok(())
    }

    fn message(&mut self) -> Result<(), Misfit> {
        let id = self.cursor.word("the id of a message")?;
        let name = self.cursor.word("the name of a message")?;
        self.cursor.sign(':')?;
        let len = self.cursor.word("a number of bytes")?;
        let end = self.cursor.end();
        let sender = match self.cursor.is_at_statement() {
            true => At { is: "", span: end..end },
            false => self.cursor.word("the name of the sender")?,
        };
        self.last_message_failed = false;
        self.found.messages.push(Message { id, name, len, sender, signals: Vec::new() });
        Ok(())
    }

    fn signal(&mut self, start: usize) -> Result<(), Misfit> {
        let signal = self.signal_parts(start)?;
        if self.last_message_failed {
            return Ok(());
        }
        match self.found.messages.last_mut() {
            Some(message) => message.signals.push(signal),
            None => return Err(Misfit { span: signal.span, label: "found a signal before any BO_".to_owned() }),
        }
        Ok(())
    }

    fn signal_parts(&mut self, start: usize) -> Result<Signal<'t>, Misfit> {
        let name = self.cursor.word("the name of a signal")?;
        let multiplexing = match self.cursor.peek() {
            Some(token) if token.kind == Kind::Word => Some(self.cursor.word("`:`")?),
            _ => None,
        };
        self.cursor.sign(':')?;
        let layout_start = self.cursor.peek().map_or(start, |token| token.span.start);
        let first_bit = self.cursor.count("a start bit")?.is;
        self.cursor.sign('|')?;
        let size = self.cursor.count("a number of bits")?.is;
        self.cursor.sign('@')?;
        let is_motorola = match self.cursor.count("0 for Motorola or 1 for Intel")? {
            At { is: 0, .. } => true,
            At { is: 1, .. } => false,
            At { is, span } => {
                let label = format!("found {is}, expected 0 for Motorola or 1 for Intel");
                self.findings.error(
                    &span,
                    "no byte order has this number",
                    label,
                    "nobody can tell which end comes first",
                );
                false
            }
        };
        let is_signed = if self.cursor.take_sign('-') {
            true
        } else {
            self.cursor.sign('+').map_err(|_| self.cursor.misfit("`+` or `-`"))?;
            false
        };
        let layout = layout_start..self.cursor.end();
        let scale_start = self.cursor.peek().map_or(start, |token| token.span.start);
        self.cursor.sign('(')?;
        let factor = self.cursor.number("a factor")?;
        self.cursor.sign(',')?;
        let offset = self.cursor.number("an offset")?;
        self.cursor.sign(')')?;
        let scale = scale_start..self.cursor.end();
        let range_start = self.cursor.peek().map_or(start, |token| token.span.start);
        self.cursor.sign('[')?;
        let minimum = self.limit('|')?;
        let maximum = self.limit(']')?;
        let range = range_start..self.cursor.end();
        let unit = self.cursor.string("a unit in quotes")?;
        self.receivers();
        let as_usize = |number| usize::try_from(number).unwrap_or(usize::MAX);
        Ok(Signal {
            span: start..self.cursor.end(),
            name,
            multiplexing,
            start: as_usize(first_bit),
            size: as_usize(size),
            is_motorola,
            is_signed,
            layout,
            factor,
            offset,
            scale,
            minimum,
            maximum,
            range,
            unit,
        })
    }

    /// An end of a range; one that is no number (`1.#QNAN`) is none.
    fn limit(&mut self, end: char) -> Result<f64, Misfit> {
        if let Ok(number) = self.cursor.number("a number") {
            self.cursor.sign(end)?;
            return Ok(number);
        }
        let start = self.cursor.peek().map_or(0, |token| token.span.start);
        while !self.cursor.take_sign(end) {
            if self.cursor.is_at_statement() || self.cursor.peek().is_some_and(|token| token.kind == Kind::Text) {
                return Err(self.cursor.misfit(&format!("`{end}`")));
            }
            self.cursor.next();
        }
        let (span, label) = (start..self.cursor.end(), "expected a number");
        self.findings.warn(
            &span,
            "this limit is no number",
            label,
            "the signal is taken to have no range: write [0|0]",
        );
        Ok(f64::NAN)
    }

    /// Who listens is of no use here.
    fn receivers(&mut self) {
        while !self.cursor.is_at_statement() {
            let word = self.cursor.peek().is_some_and(|token| matches!(token.kind, Kind::Word | Kind::Number));
            if !word && !self.cursor.take_sign(',') && !self.cursor.take_sign(';') {
                return;
            }
            if word {
                self.cursor.next();
            }
        }
    }
}
