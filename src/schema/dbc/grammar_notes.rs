//! The statements that say something of what others have laid out: comments,
//! attributes, value names, number types and switch values.

use super::cursor::Misfit;
use super::grammar::Reader;
use super::statements::{At, AttributeValue, Definition, Note, Object, Selection, ValueList, ValueNames};
use super::tokens::Kind;

impl<'t> Reader<'t, '_> {
    pub(super) fn comment(&mut self) -> Result<(), Misfit> {
        let of = self.object()?;
        let is = self.cursor.string("a comment in quotes")?.is;
        self.found.comments.push(Note { of, is });
        self.semicolon("CM_")
    }

    pub(super) fn attribute(&mut self) -> Result<(), Misfit> {
        let name = self.cursor.quoted_name("the name of an attribute in quotes")?;
        let of = self.object()?;
        let value = self.attribute_value()?;
        self.found.attributes.push(Note { of, is: (name, value) });
        self.semicolon("BA_")
    }

    pub(super) fn definition(&mut self) -> Result<(), Misfit> {
        if self.cursor.peek().is_some_and(|token| token.kind == Kind::Word) {
            self.cursor.next();
        }
        let name = self.cursor.quoted_name("the name of an attribute in quotes")?;
        self.cursor.word("INT, HEX, FLOAT, ENUM or STRING")?;
        let mut words = Vec::new();
        while let Ok(word) = self.cursor.string("a word") {
            words.push(word.is);
            self.cursor.take_sign(',');
        }
        while self.cursor.take_number() || self.cursor.take_sign(',') {}
        self.found.definitions.push(Definition { name, words });
        self.semicolon("BA_DEF_")
    }

    pub(super) fn default(&mut self) -> Result<(), Misfit> {
        let name = self.cursor.quoted_name("the name of an attribute in quotes")?;
        let value = self.attribute_value()?;
        self.found.defaults.push((name, value));
        self.semicolon("BA_DEF_DEF_")
    }

    fn attribute_value(&mut self) -> Result<AttributeValue, Misfit> {
        if self.cursor.peek().is_some_and(|token| token.kind == Kind::Text) {
            return Ok(AttributeValue::Text(self.cursor.string("a value")?.is));
        }
        self.cursor.number("a number or a string").map(AttributeValue::Number)
    }

    /// What a statement speaks of; the network where it does not say.
    fn object(&mut self) -> Result<At<Object<'t>>, Misfit> {
        let start = self.cursor.peek().map_or(self.cursor.end(), |token| token.span.start);
        let is = match self.cursor.peek_text() {
            "BU_" => {
                self.cursor.next();
                Object::Node(self.cursor.word("the name of a node")?.is)
            }
            "BO_" => {
                self.cursor.next();
                Object::Message(self.cursor.count("the id of a message")?.is)
            }
            "SG_" => {
                self.cursor.next();
                let message = self.cursor.count("the id of a message")?.is;
                Object::Signal(message, self.cursor.word("the name of a signal")?.is)
            }
            "EV_" => {
                self.cursor.next();
                Object::EnvironmentVariable(self.cursor.word("the name of an environment variable")?.is)
            }
            _ => return Ok(At { is: Object::Network, span: start..start }),
        };
        Ok(At { is, span: start..self.cursor.end() })
    }

    pub(super) fn values(&mut self) -> Result<(), Misfit> {
        let start = self.cursor.peek().map_or(0, |token| token.span.start);
        let of = match self.cursor.peek() {
            Some(token) if token.kind == Kind::Number => {
                let message = self.cursor.count("the id of a message")?.is;
                Object::Signal(message, self.cursor.word("the name of a signal")?.is)
            }
            _ => Object::EnvironmentVariable(self.cursor.word("the id of a message")?.is),
        };
        let of = At { is: of, span: start..self.cursor.end() };
        let names_a_table =
            self.cursor.peek().is_some_and(|token| token.kind == Kind::Word) && !self.cursor.is_at_statement();
        let is = if names_a_table {
            ValueList::Table(self.cursor.word("the name of a VAL_TABLE_")?)
        } else {
            ValueList::Names(self.value_names()?)
        };
        self.found.values.push(Note { of, is });
        self.semicolon("VAL_")
    }

    pub(super) fn table(&mut self) -> Result<(), Misfit> {
        let name = self.cursor.word("the name of a value table")?;
        let names = self.value_names()?;
        self.found.tables.push((name, names));
        self.semicolon("VAL_TABLE_")
    }

    fn value_names(&mut self) -> Result<ValueNames, Misfit> {
        let mut names = Vec::new();
        while self.cursor.peek().is_some_and(|token| token.kind == Kind::Number) {
            let value = self.cursor.whole("a whole number")?;
            names.push((value, self.cursor.string("a name in quotes")?.is));
        }
        Ok(names)
    }

    pub(super) fn number_type(&mut self) -> Result<(), Misfit> {
        let start = self.cursor.peek().map_or(0, |token| token.span.start);
        let message = self.cursor.count("the id of a message")?.is;
        let signal = self.cursor.word("the name of a signal")?.is;
        let of = At { is: Object::Signal(message, signal), span: start..self.cursor.end() };
        self.cursor.take_sign(':');
        let is = self.cursor.count("0 for a whole number, 1 for float, 2 for double")?.is;
        self.found.number_types.push(Note { of, is });
        self.semicolon("SIG_VALTYPE_")
    }

    pub(super) fn selection(&mut self, start: usize) -> Result<(), Misfit> {
        let message = self.cursor.count("the id of a message")?.is;
        let signal = self.cursor.word("the name of a signal")?.is;
        let switch = self.cursor.word("the name of a multiplexer switch")?;
        let mut ranges = Vec::new();
        while self.cursor.peek().is_some_and(|token| token.kind == Kind::Number) {
            let first = self.cursor.count("a switch value")?.is;
            ranges.push((first, self.last_of_range()?.unwrap_or(first)));
            self.cursor.take_sign(',');
        }
        let span = start..self.cursor.end();
        self.found.selections.push(Selection { message, signal, switch, ranges, span });
        self.semicolon("SG_MUL_VAL_")
    }

    /// `0-3` is cut into `0` and `-3`, `0 - 3` into three.
    fn last_of_range(&mut self) -> Result<Option<u64>, Misfit> {
        if self.cursor.take_sign('-') {
            return Ok(Some(self.cursor.count("a switch value")?.is));
        }
        let Some(digits) = self.cursor.peek_text().strip_prefix('-') else { return Ok(None) };
        let last = digits.parse().map_err(|_| self.cursor.misfit("a switch value"))?;
        self.cursor.next();
        Ok(Some(last))
    }
}
