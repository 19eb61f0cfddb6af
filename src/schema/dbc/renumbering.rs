//! The same DBC with other arbitration ids.

use std::sync::Arc;

use super::cursor::parse_whole;
use super::reader::EXTENDED;
use super::tokens::tokens;
use super::{Dbc, MessageLayout};
use crate::config::Source;
use crate::frame::CanId;

/// Words after which a number is a message's id.
const BEFORE_ID: [&str; 7] = ["BO_", "SG_", "VAL_", "SIG_VALTYPE_", "SG_MUL_VAL_", "BO_TX_BU_", "SIG_GROUP_"];

impl Dbc {
    /// The text of this DBC in which each message has the id that `id_of`
    /// gives it, wherever the text speaks of it. The rest stays as it is.
    pub(in crate::schema) fn renumbered(&self, id_of: impl Fn(&MessageLayout) -> CanId) -> Arc<Source> {
        let text = &self.source.text;
        let (mut renumbered, mut copied) = (String::with_capacity(text.len()), 0);
        let tokens = tokens(text);
        for pair in tokens.windows(2) {
            let [word, number] = pair else { continue };
            if !BEFORE_ID.contains(&&text[word.span.clone()]) {
                continue;
            }
            let known = parse_whole(&text[number.span.clone()]);
            let message = self.messages.iter().find(|message| known == Some(number_of(message.id).into()));
            if let Some(message) = message {
                renumbered += &text[copied..number.span.start];
                renumbered += &number_of(id_of(message)).to_string();
                copied = number.span.end;
            }
        }
        renumbered += &text[copied..];
        Source::new(self.source.name.clone(), renumbered)
    }
}

/// What a DBC calls the message with this id by.
const fn number_of(id: CanId) -> u32 {
    if id.is_extended() { id.raw() | EXTENDED } else { id.raw() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_id_changes_wherever_the_text_speaks_of_it_and_nothing_else_does() {
        let text = "BU_: A\nBO_ 257 One: 2 A\n SG_ Mode : 0|8@1+ (1,257) [0|257] \"257\" A\n\n\
            BO_ 2147483905 Other: 1 A\n SG_ Mode : 0|8@1+ (1,0) [0|1] \"\" A\n\n\
            BO_TX_BU_ 257 : A;\nCM_ BO_ 257 \"of BO_ 257\";\nCM_ SG_ 257 Mode \"257\";\n\
            BA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 257;\nBA_ \"GenMsgCycleTime\" BO_ 257 257;\n\
            VAL_ 257 Mode 257 \"On\";\n";
        let dbc = Dbc::parse(&Source::new("a.dbc", text)).unwrap_or_else(|problems| panic!("{problems}"));
        let moved = |message: &MessageLayout| match message.id {
            CanId::Standard(_) => CanId::Standard(0x205),
            id @ CanId::Extended(_) => id,
        };
        let expected = text
            .replace("BO_ 257 One", "BO_ 517 One")
            .replace("BO_TX_BU_ 257", "BO_TX_BU_ 517")
            .replace("CM_ BO_ 257", "CM_ BO_ 517")
            .replace("CM_ SG_ 257", "CM_ SG_ 517")
            .replace("BO_ 257 257", "BO_ 517 257")
            .replace("VAL_ 257", "VAL_ 517");
        assert_eq!(dbc.renumbered(moved).text, expected);
    }
}
