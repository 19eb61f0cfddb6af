//! Where messages go: into a file, or to whoever looks on.

use std::collections::BTreeMap;

use super::LogError;
use crate::time::Instant;

/// Is told beforehand which channels there may be, each with a schema that
/// explains its messages.
pub(crate) trait Catalogue {
    /// Adds a schema; returns its id.
    fn schema(&mut self, name: &str, encoding: &str, data: &[u8]) -> Result<u16, LogError>;

    /// Adds a channel whose messages have the schema `schema_id`; returns its id.
    fn channel(
        &mut self,
        schema_id: u16,
        topic: String,
        message_encoding: &str,
        metadata: BTreeMap<String, String>,
    ) -> Result<u16, LogError>;
}

/// Takes messages on the channels of a catalogue.
pub(crate) trait Medium {
    /// Takes a message, which `write` appends to what it is given.
    fn message(&mut self, channel_id: u16, at: Instant, write: impl FnOnce(&mut Vec<u8>));
}
