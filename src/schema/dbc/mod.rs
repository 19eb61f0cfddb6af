//! A DBC file: the messages of a bus and the signals in them.

mod cursor;
mod findings;
mod grammar;
mod grammar_notes;
mod lints;
mod multiplexing;
mod notes;
mod overlaps;
mod reader;
mod renumbering;
mod signals;
mod statements;
mod tokens;

use std::path::Path;
use std::sync::Arc;

use encoding_rs::{Encoding, WINDOWS_1252};

use self::reader::Contents;
use super::codec::Plan;
use super::signal::Signal;
use crate::config::{Problem, Problems, Severity, Source};
use crate::frame::CanId;
use crate::time::Duration;

/// What a DBC file says.
#[derive(Clone, Debug)]
pub struct Dbc {
    /// The text it came from.
    pub source: Arc<Source>,
    /// In the order of the file.
    pub messages: Vec<MessageLayout>,
    /// Signals that belong to no message (`VECTOR__INDEPENDENT_SIG_MSG`).
    pub independent_signals: Vec<Signal>,
    /// The bus's bit rate (`Baudrate`), bit/s.
    pub bitrate_bit_s: Option<u32>,
    /// Indices of `messages`, sorted by [`sort_key`] of their ids.
    by_id: Vec<usize>,
}

/// One message.
#[derive(Clone, Debug, PartialEq)]
pub struct MessageLayout {
    /// Arbitration id, unique in the file.
    pub id: CanId,
    /// Name, unique in the file: the long one where the DBC gives one
    /// (`SystemMessageLongSymbol`).
    pub name: String,
    /// The name in the DBC's `BO_` statement, cut to 32 characters by some
    /// tools.
    pub short_name: String,
    /// Bytes of payload. More than 64 take a transport protocol.
    pub len: usize,
    /// Whether the DBC says that CAN FD frames carry it (`VFrameFormat`).
    pub is_fd: bool,
    /// What it is for (`CM_`); empty when the DBC does not say.
    pub comment: String,
    /// How often it is sent (`GenMsgCycleTime`), unless 0 or not given.
    pub cycle: Option<Duration>,
    /// The node that sends it; empty when the DBC names none.
    pub sender: String,
    /// In the order of the file.
    pub signals: Vec<Signal>,
    pub(super) plan: Plan,
}

impl Dbc {
    /// Reads a file's text for [`Self::parse`]: UTF-8, or what its byte order
    /// mark says, or else Windows-1252, which older tools write.
    pub fn read_source(path: &Path) -> Result<Arc<Source>, Problem> {
        let name = path.display().to_string();
        let bytes = std::fs::read(path).map_err(|error| Problem::bare(format!("cannot read {name}: {error}")))?;
        Ok(Source::new(name, decode_text(bytes)))
    }

    /// Parses a DBC file. Refused is one that does not say what it means: a
    /// statement that cannot be read, a signal past its message's end, signals
    /// that overlap, an id or a name given twice. The problems name line and
    /// column and come all together; [`Self::check`] has warnings besides.
    pub fn parse(source: &Arc<Source>) -> Result<Self, Problems> {
        let (dbc, mut problems) = Self::parse_leniently(source);
        problems.retain(|problem| problem.severity == Severity::Error);
        if problems.is_empty() { Ok(dbc) } else { Err(Problems(problems)) }
    }

    /// Takes from a DBC file whatever can be understood, and gives all that is
    /// wrong with it, in its order, warnings too. For looking at a bus, where a
    /// message too few is better than none; a robot wants [`Self::parse`].
    ///
    /// In spite of errors, a message or signal that is given twice is there
    /// twice, and found by name and id is the first; a signal past its
    /// message's end is there, and read from frames long enough.
    pub fn parse_leniently(source: &Arc<Source>) -> (Self, Vec<Problem>) {
        Self::read(source, false)
    }

    /// As [`Self::parse_leniently`], and finds besides what is only worth a
    /// second look: a physical signal without a unit, a range that the bits do
    /// not hold, a sender that is no node.
    pub fn check(source: &Arc<Source>) -> (Self, Vec<Problem>) {
        Self::read(source, true)
    }

    fn read(source: &Arc<Source>, is_thorough: bool) -> (Self, Vec<Problem>) {
        let Contents { messages, parked, bit_rate, findings } = reader::contents(source, is_thorough);
        let mut by_id: Vec<usize> = (0..messages.len()).collect();
        by_id.sort_by_key(|&index| sort_key(messages[index].id));
        by_id.dedup_by_key(|index| sort_key(messages[*index].id));
        let source = Arc::clone(source);
        (Self { source, messages, independent_signals: parked, bitrate_bit_s: bit_rate, by_id }, findings)
    }

    /// The message of this name, long or short.
    pub fn message(&self, name: &str) -> Option<&MessageLayout> {
        let by_short_name = || self.messages.iter().find(|message| message.short_name == name);
        self.messages.iter().find(|message| message.name == name).or_else(by_short_name)
    }

    /// The message with this arbitration id.
    pub fn message_by_id(&self, id: CanId) -> Option<&MessageLayout> {
        let at = self.by_id.binary_search_by_key(&sort_key(id), |&index| sort_key(self.messages[index].id)).ok()?;
        Some(&self.messages[self.by_id[at]])
    }
}

impl MessageLayout {
    /// The signal of this name, long or short.
    pub fn signal(&self, name: &str) -> Option<&Signal> {
        self.signal_index(name).map(|index| &self.signals[index])
    }

    pub(super) fn signal_index(&self, name: &str) -> Option<usize> {
        let by_short_name = || self.signals.iter().position(|signal| signal.short_name == name);
        self.signals.iter().position(|signal| signal.name == name).or_else(by_short_name)
    }
}

/// Text in whichever encoding a DBC has.
fn decode_text(bytes: Vec<u8>) -> String {
    if let Some((encoding, mark_len)) = Encoding::for_bom(&bytes) {
        return encoding.decode_without_bom_handling(&bytes[mark_len..]).0.into_owned();
    }
    String::from_utf8(bytes).unwrap_or_else(|error| {
        let (text, _) = WINDOWS_1252.decode_without_bom_handling(error.as_bytes());
        text.into_owned()
    })
}

const fn sort_key(id: CanId) -> (bool, u32) {
    (id.is_extended(), id.raw())
}
