//! A log of nothing but frames, whose buses are heard of one after the other:
//! what a capture or another program's log becomes.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::bus::{BusLog, FrameSchemas, LoggedFrame};
use super::channels::Channels;
use super::chunk_queue::ChunkQueue;
use super::descriptor::foxglove_log;
use super::file::LogFile;
use super::filling::Filling;
use super::medium::{Catalogue, Medium};
use super::protobuf::{Level, put_log};
use super::{LogError, LogReport, LoggedBus, NOTICES_TOPIC};
use crate::time::Instant;

/// Frames being written to an MCAP file, in the channels of
/// [`super::McapLog`]. Compressed and written on a thread of its own; taken
/// and encoded on the caller's.
pub struct FrameLog {
    path: PathBuf,
    /// None once the file has failed.
    queue: Option<ChunkQueue>,
    failed: Arc<AtomicBool>,
    filling: Filling,
    schemas: FrameSchemas,
    buses: Vec<BusLog>,
    notices: u16,
}

impl FrameLog {
    /// Makes or empties the file; `metadata` is kept in it under `canloop`.
    ///
    /// # Errors
    /// The file cannot be made.
    pub fn create(path: &Path, metadata: &BTreeMap<String, String>) -> Result<Self, LogError> {
        Self::with_attachments(path, metadata, &[])
    }

    /// The same with files kept in it: (name, media type, content).
    ///
    /// # Errors
    /// The file cannot be made.
    pub fn with_attachments(
        path: &Path,
        metadata: &BTreeMap<String, String>,
        attachments: &[(String, String, Vec<u8>)],
    ) -> Result<Self, LogError> {
        let mut channels = Channels::default();
        let schemas = FrameSchemas::new(&mut channels)?;
        let log = channels.schema("foxglove.Log", "protobuf", &foxglove_log())?;
        let notices = channels.channel(log, NOTICES_TOPIC.to_owned(), "protobuf", BTreeMap::new())?;
        let failed = Arc::new(AtomicBool::new(false));
        let start = || {
            let mut file = LogFile::create(path)?;
            file.metadata("canloop", metadata)?;
            for (name, media_type, data) in attachments {
                file.attachment(name, media_type, data)?;
            }
            ChunkQueue::start(file, 0, Arc::clone(&failed))
        };
        let (queue, chunk) = start().map_err(|source| LogError::Create { path: path.to_owned(), source })?;
        let (path, queue) = (path.to_owned(), Some(queue));
        Ok(Self { path, queue, failed, filling: Filling { chunk, channels }, schemas, buses: Vec::new(), notices })
    }

    /// Adds a bus; returns its index. Its frames are also decoded where its
    /// DBC files know them.
    ///
    /// # Errors
    /// There are too many channels.
    pub fn add_bus(&mut self, bus: &LoggedBus<'_>) -> Result<usize, LogError> {
        self.buses.push(BusLog::new(bus, &self.schemas, &mut self.filling.channels)?);
        Ok(self.buses.len() - 1)
    }

    /// Logs a frame of a bus that has been added.
    ///
    /// # Errors
    /// The file took no more.
    pub fn put(&mut self, bus: usize, at: Instant, frame: &LoggedFrame<'_>) -> Result<(), LogError> {
        self.buses[bus].put(&mut self.filling, at, frame);
        self.send_if_full()
    }

    /// Logs an error frame of a bus that has been added: classes and data as
    /// in `linux/can/error.h`.
    ///
    /// # Errors
    /// The file took no more.
    pub fn put_error(&mut self, bus: usize, at: Instant, class: u32, data: [u8; 8]) -> Result<(), LogError> {
        self.buses[bus].put_error(&mut self.filling, at, class, data);
        self.send_if_full()
    }

    /// Logs that `frames` of a bus were lost before this moment, `total` of them
    /// so far.
    ///
    /// # Errors
    /// The file took no more.
    pub fn put_lost(&mut self, bus: usize, at: Instant, frames: u64, total: u64) -> Result<(), LogError> {
        self.buses[bus].put_lost(&mut self.filling, at, frames, total);
        self.send_if_full()
    }

    /// Logs a line for people.
    ///
    /// # Errors
    /// The file took no more.
    pub fn notice(&mut self, at: Instant, name: &str, text: &str) -> Result<(), LogError> {
        self.filling.message(self.notices, at, |out| put_log(out, at, Level::Info, name, text));
        self.send_if_full()
    }

    /// Lets what has come so far be written, though a chunk is not full.
    ///
    /// # Errors
    /// The file took no more.
    pub fn flush(&mut self) -> Result<(), LogError> {
        if let (Some(queue), false) = (&self.queue, self.filling.chunk.is_empty()) {
            queue.send(&mut self.filling.chunk);
        }
        self.check()
    }

    /// Bytes in the file so far.
    pub fn bytes(&self) -> u64 {
        std::fs::metadata(&self.path).map_or(0, |file| file.len())
    }

    /// Writes what is left and ends the file, which says that `frames_lost`
    /// are not in it.
    ///
    /// # Errors
    /// The file took no more.
    pub fn finish(mut self, frames_lost: u64) -> Result<LogReport, LogError> {
        if let (Some(queue), false) = (&self.queue, self.filling.chunk.is_empty()) {
            queue.send(&mut self.filling.chunk);
        }
        let mut file = self.end_queue()?;
        let messages = file.end(&self.filling.channels, frames_lost).map_err(|source| self.cannot_write(source))?;
        Ok(LogReport { messages, bytes: file.len(), events_lost: frames_lost, waits: 0 })
    }

    fn send_if_full(&mut self) -> Result<(), LogError> {
        if !self.filling.chunk.is_full() {
            return Ok(());
        }
        if let Some(queue) = &self.queue {
            queue.send(&mut self.filling.chunk);
        }
        self.check()
    }

    fn check(&mut self) -> Result<(), LogError> {
        if self.failed.load(Ordering::Relaxed) { self.end_queue().map(drop) } else { Ok(()) }
    }

    fn end_queue(&mut self) -> Result<LogFile, LogError> {
        let ended = || Err(io::Error::other("it has failed before"));
        self.queue.take().map_or_else(ended, ChunkQueue::finish).map_err(|source| self.cannot_write(source))
    }

    fn cannot_write(&self, source: io::Error) -> LogError {
        LogError::Write { path: self.path.clone(), source }
    }
}
