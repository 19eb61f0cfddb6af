//! Writes the messages of events to a file, on a thread of the log's own.

use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::batch::Batch;
use super::channels::Channels;
use super::chunk_queue::ChunkQueue;
use super::file::LogFile;
use super::filling::Filling;
use super::messages::Messages;
use super::{LogContents, LogError};
use crate::event::{Event, Sink};
use crate::time::Instant;

/// Writes the events of a run to an MCAP file.
pub(super) struct Writer {
    queue: ChunkQueue,
    filling: Filling,
    messages: Messages,
}

/// What became of the events.
pub(super) struct Written {
    pub messages: u64,
    pub events_lost: u64,
    pub bytes: u64,
}

impl Writer {
    /// Makes the file and writes all of it that comes before the messages.
    /// Sets `failed` once the file takes no more.
    pub fn create(path: &Path, contents: &LogContents<'_>, failed: Arc<AtomicBool>) -> Result<Self, LogError> {
        let mut channels = Channels::default();
        let messages = Messages::new(contents, &mut channels)?;
        let start = || {
            let mut file = LogFile::create(path)?;
            file.metadata("canloop", &contents.metadata)?;
            for (name, media_type, data) in &contents.attachments {
                file.attachment(name, media_type, data)?;
            }
            ChunkQueue::start(file, channels.len(), failed)
        };
        let (queue, chunk) = start().map_err(|source| LogError::Create { path: path.to_owned(), source })?;
        Ok(Self { queue, filling: Filling { chunk, channels }, messages })
    }

    /// Writes a batch and leaves it empty.
    pub fn take(&mut self, batch: &mut Batch) {
        let lost = std::mem::take(&mut batch.lost_before);
        if lost > 0 {
            self.messages.put_lost(&mut self.filling, batch.start(), lost);
        }
        batch.drain_into(self);
    }

    /// Writes what is left and ends the file.
    pub fn finish(mut self) -> io::Result<Written> {
        if !self.filling.chunk.is_empty() {
            self.queue.send(&mut self.filling.chunk);
        }
        let mut file = self.queue.finish()?;
        let events_lost = self.messages.lost();
        let messages = file.end(&self.filling.channels, events_lost)?;
        Ok(Written { messages, events_lost, bytes: file.len() })
    }
}

impl Sink for Writer {
    fn event(&mut self, at: Instant, event: &Event) {
        self.messages.put(&mut self.filling, at, event);
        if self.filling.chunk.is_full() {
            self.queue.send(&mut self.filling.chunk);
        }
    }
}
