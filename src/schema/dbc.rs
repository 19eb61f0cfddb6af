//! A DBC file: the messages of a bus and the signals in them.

use std::path::Path;
use std::sync::Arc;

use super::signal::Signal;
use crate::config::{Problem, Problems, Source};
use crate::frame::CanId;
use crate::time::Duration;

/// What a DBC file says, checked so that every signal can be read and
/// written safely.
///
/// Multiplexed signals are laid out like all others; which of them a frame
/// really carries is not asked here.
#[derive(Clone, Debug)]
pub struct Dbc {
    /// The text it came from.
    pub source: Arc<Source>,
    /// In the order of the file.
    pub messages: Vec<MessageLayout>,
    /// Indices of `messages`, sorted by [`sort_key`] of their ids.
    by_id: Vec<usize>,
}

/// One message.
#[derive(Clone, Debug, PartialEq)]
pub struct MessageLayout {
    /// Arbitration id, unique in the file.
    pub id: CanId,
    /// Name, unique in the file.
    pub name: String,
    /// Bytes of payload, at most 64.
    pub len: usize,
    /// What it is for (`CM_`); empty when the DBC does not say.
    pub comment: String,
    /// How often it is sent (`GenMsgCycleTime`), unless 0 or not given.
    pub cycle: Option<Duration>,
    /// The node that sends it; empty when the DBC names none.
    pub sender: String,
    /// In the order of the file.
    pub signals: Vec<Signal>,
}

impl Dbc {
    /// Reads a file's text for [`Self::parse`]: UTF-8, or else Windows-1252,
    /// which older tools write.
    pub fn read_source(path: &Path) -> Result<Arc<Source>, Problem> {
        let name = path.display().to_string();
        let bytes = std::fs::read(path).map_err(|error| Problem::bare(format!("cannot read {name}: {error}")))?;
        match String::from_utf8(bytes) {
            Ok(text) => Ok(Source::new(name, text)),
            Err(error) => match can_dbc::decode_cp1252(error.as_bytes()) {
                Some(text) => Ok(Source::new(name, text)),
                None => Err(Problem::bare(format!("{name} is neither UTF-8 nor Windows-1252 text"))),
            },
        }
    }

    /// Parses a DBC file. Errors name the line and column: those of syntax
    /// one at a time, those of meaning (a signal past its message's end, a
    /// duplicate name, ...) all together.
    pub fn parse(source: &Arc<Source>) -> Result<Self, Problems> {
        let messages = super::dbc_parser::messages(source)?;
        let mut by_id: Vec<usize> = (0..messages.len()).collect();
        by_id.sort_by_key(|&index| sort_key(messages[index].id));
        Ok(Self { source: Arc::clone(source), messages, by_id })
    }

    /// The message of this name.
    pub fn message(&self, name: &str) -> Option<&MessageLayout> {
        self.messages.iter().find(|message| message.name == name)
    }

    /// The message with this arbitration id.
    pub fn message_by_id(&self, id: CanId) -> Option<&MessageLayout> {
        let at = self.by_id.binary_search_by_key(&sort_key(id), |&index| sort_key(self.messages[index].id)).ok()?;
        Some(&self.messages[self.by_id[at]])
    }
}

impl MessageLayout {
    /// The signal of this name.
    pub fn signal(&self, name: &str) -> Option<&Signal> {
        self.signals.iter().find(|signal| signal.name == name)
    }
}

const fn sort_key(id: CanId) -> (bool, u32) {
    (id.is_extended(), id.raw())
}
