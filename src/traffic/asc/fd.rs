//! `0.015600 CANFD 1 Rx 1ABCDx Name 1 0 9 12 11 22 ... 33 0 0 3000 0 0 0 0 0`:
//! bit-rate switch, ESI, length code, length, data, and behind the data the
//! duration, the bits, and flags that say whether it was CAN FD at all.

use super::{Asc, ERROR, Event, is_error};
use crate::frame::Frame;
use crate::traffic::words::{LineProblem, Word, Words};
use crate::traffic::{Content, number, socketcan};

const FLAG_REMOTE: u32 = 0x10;
const FLAG_FD: u32 = 0x1000;
const HEX: u32 = 16;

impl Asc {
    /// What follows the number of the bus; `None` for what is no frame.
    pub(super) fn fd_event(&mut self, words: &mut Words<'_>) -> Result<Option<Event>, LineProblem> {
        let direction = words.expect("Rx or Tx")?;
        if is_error(&direction) {
            return Ok(Some((crate::traffic::Direction::Received, ERROR)));
        }
        let Some(sent_by) = self.direction(&direction)? else { return Ok(None) };
        let id_word = words.expect("an id")?;
        if is_error(&id_word) {
            return Ok(Some((sent_by, ERROR)));
        }
        // These lines are hexadecimal in decimal logs, too.
        let id = self.id(&id_word, HEX)?;
        let switch = self.first_flag(words)?;
        let error_passive = words.expect("0 or 1")?.text == b"1";
        let code = words.expect("a length code")?;
        let dlc = code.number(HEX, "a length code")?.min(255) as u8;
        let length = words.expect("a length")?;
        let len = length.decimal("a length")? as usize;
        if dlc > 15 || len > Frame::CAPACITY {
            return Err(length.problem("a length of at most 64 bytes, and a length code to match"));
        }
        let mut data = [0; Frame::CAPACITY];
        for byte in &mut data[..len] {
            let word = words.expect("another byte of data")?;
            *byte = number::hex(word.text)
                .and_then(|byte| u8::try_from(byte).ok())
                .ok_or_else(|| word.problem("a byte of data"))?;
        }
        let flags = words.nth(2).and_then(|word| number::hex(word.text)).unwrap_or(FLAG_FD);
        self.latest_is_fd = true;
        let recorded = if flags & FLAG_FD != 0 || len > 8 {
            socketcan::fd(id, switch, error_passive, &data[..len])
                .ok_or_else(|| length.problem("a length that CAN FD frames can have"))?
        } else {
            socketcan::with_dlc(id, flags & FLAG_REMOTE != 0, dlc, &data[..len.min(8)])
        };
        Ok(Some((sent_by, Content::Frame(recorded))))
    }

    /// The bit-rate switch; the name of the message may stand before it.
    fn first_flag(&self, words: &mut Words<'_>) -> Result<bool, LineProblem> {
        let is_flag = |word: &Word<'_>| matches!(word.text, b"0" | b"1");
        let word = words.expect("0 or 1")?;
        let flag = if is_flag(&word) { word } else { words.expect("0 or 1")? };
        if is_flag(&flag) { Ok(flag.text == b"1") } else { Err(flag.problem("0 or 1")) }
    }
}
