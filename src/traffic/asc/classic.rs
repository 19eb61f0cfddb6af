//! `0.015600 1  1ABCDx  Rx   d 8 11 22 33 44 55 66 77 88`, with more behind it
//! in newer logs.

use super::{Asc, ERROR, Event, is_error};
use crate::traffic::words::{LineProblem, Word, Words};
use crate::traffic::{Content, Direction, number, socketcan};

impl Asc {
    /// What follows the number of the bus; `None` for what is no frame.
    pub(super) fn classic_event(&mut self, words: &mut Words<'_>) -> Result<Option<Event>, LineProblem> {
        let Some(id) = words.next() else { return Ok(None) };
        if is_error(&id) {
            return Ok(Some((Direction::Received, ERROR)));
        }
        let Some(direction) = words.next() else {
            return self
                .id(&id, self.radix)
                .map(|_| None)
                .or_else(|_| is_word_of_others(&id).then_some(None).ok_or_else(|| id.problem("an id")));
        };
        let sent_by = match self.direction(&direction) {
            Ok(Some(sent_by)) => sent_by,
            Ok(None) => return Ok(None),
            // "Statistic: D 0 R 0" and its like have no direction there.
            Err(_) if is_word_of_others(&id) => return Ok(None),
            Err(problem) => return Err(problem),
        };
        let can_id = self.id(&id, self.radix)?;
        let kind = words.expect("d or r")?;
        let recorded = match kind.text {
            b"d" | b"D" => {
                let dlc = self.dlc(&words.expect("a length code")?)?;
                let mut data = [0; 8];
                for byte in &mut data[..usize::from(dlc.min(8))] {
                    *byte = self.byte(&words.expect("another byte of data")?)?;
                }
                socketcan::with_dlc(can_id, false, dlc, &data)
            }
            b"r" | b"R" => {
                // Logs before version 8.5 have no length here.
                let dlc = words.next().map_or(Some(0), |word| self.dlc(&word).ok()).unwrap_or(0);
                socketcan::with_dlc(can_id, true, dlc, &[])
            }
            _ => return Err(kind.problem("d or r")),
        };
        Ok(Some((sent_by, Content::Frame(recorded))))
    }

    /// A length code: one digit, hexadecimal whatever the radix, or two decimal ones.
    fn dlc(&self, word: &Word<'_>) -> Result<u8, LineProblem> {
        let dlc = match word.text {
            [digit] => number::nibble(*digit),
            digits => number::decimal(digits).and_then(|dlc| u8::try_from(dlc).ok()),
        };
        dlc.filter(|dlc| *dlc <= 15).ok_or_else(|| word.problem("a length code"))
    }

    fn byte(&self, word: &Word<'_>) -> Result<u8, LineProblem> {
        let byte = word.number(self.radix, "a byte of data")?;
        u8::try_from(byte).map_err(|_| word.problem("a byte of data"))
    }
}

/// Whether a word begins something other than a frame: a name of letters.
fn is_word_of_others(word: &Word<'_>) -> bool {
    let letters = word.text.iter().filter(|byte| byte.is_ascii_alphabetic()).count();
    letters >= 4 && word.text[0].is_ascii_alphabetic()
}
