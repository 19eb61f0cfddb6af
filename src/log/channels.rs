//! The channels of a log and the schemas that explain them. Both are written
//! with the first message that needs them, so that a reader's list of topics
//! shows what there is and not what there might have been.

use std::collections::BTreeMap;

use mcap::records::{Channel, MessageHeader};

use super::LogError;
use super::chunk::Chunk;
use super::file::{channel_record, schema_record};
use super::medium::Catalogue;
use crate::time::Instant;

/// Every channel that a log may need.
#[derive(Default)]
pub(super) struct Channels {
    /// The schema with id n is at n - 1: MCAP keeps 0 for "none".
    schemas: Vec<Schema>,
    /// By channel id.
    channels: Vec<State>,
}

struct Schema {
    record: Vec<u8>,
    written: bool,
}

struct State {
    schema_id: u16,
    record: Vec<u8>,
    messages: u64,
}

impl Catalogue for Channels {
    fn schema(&mut self, name: &str, encoding: &str, data: &[u8]) -> Result<u16, LogError> {
        let id = u16::try_from(self.schemas.len() + 1).map_err(|_| LogError::TooManyChannels)?;
        self.schemas.push(Schema { record: schema_record(id, name, encoding, data), written: false });
        Ok(id)
    }

    fn channel(
        &mut self,
        schema_id: u16,
        topic: String,
        message_encoding: &str,
        metadata: BTreeMap<String, String>,
    ) -> Result<u16, LogError> {
        let id = u16::try_from(self.channels.len()).map_err(|_| LogError::TooManyChannels)?;
        let channel = Channel { id, schema_id, topic, message_encoding: message_encoding.to_owned(), metadata };
        self.channels.push(State { schema_id, record: channel_record(&channel), messages: 0 });
        Ok(id)
    }
}

impl Channels {
    /// How many channels there are.
    pub fn len(&self) -> usize {
        self.channels.len()
    }

    /// Puts a message into `chunk`, before it what explains it if that is its
    /// first. MCAP's times have no sign: what happens before the origin is
    /// logged at the origin.
    pub fn message(&mut self, chunk: &mut Chunk, channel_id: u16, at: Instant, write: impl FnOnce(&mut Vec<u8>)) {
        let channel = &mut self.channels[usize::from(channel_id)];
        if channel.messages == 0 {
            let schema = &mut self.schemas[usize::from(channel.schema_id) - 1];
            if !schema.written {
                chunk.record(&schema.record);
                schema.written = true;
            }
            chunk.record(&channel.record);
        }
        let time = u64::try_from(at.as_nanos()).unwrap_or(0);
        let sequence = channel.messages as u32;
        channel.messages += 1;
        chunk.message(MessageHeader { channel_id, sequence, log_time: time, publish_time: time }, write);
    }

    /// Records of the schemas written.
    pub fn schemas_written(&self) -> Vec<&[u8]> {
        self.schemas.iter().filter(|schema| schema.written).map(|schema| schema.record.as_slice()).collect()
    }

    /// Records of the channels written.
    pub fn channels_written(&self) -> Vec<&[u8]> {
        self.channels.iter().filter(|channel| channel.messages > 0).map(|channel| channel.record.as_slice()).collect()
    }

    /// Messages by the id of the channels written.
    pub fn counts(&self) -> BTreeMap<u16, u64> {
        (0..).zip(&self.channels).filter(|(_, channel)| channel.messages > 0).map(|(id, c)| (id, c.messages)).collect()
    }
}
