//! The chunk being filled, and the channels of its file.

use super::channels::Channels;
use super::chunk::Chunk;
use super::medium::Medium;
use crate::time::Instant;

/// Takes messages into a chunk.
pub(super) struct Filling {
    pub chunk: Chunk,
    pub channels: Channels,
}

impl Medium for Filling {
    fn message(&mut self, channel_id: u16, at: Instant, write: impl FnOnce(&mut Vec<u8>)) {
        self.channels.message(&mut self.chunk, channel_id, at, write);
    }
}
