//! The loop's end of a log: a queue to the thread that writes it.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

use super::batch::Batch;
use super::writer::{Writer, Written};
use crate::event::{Event, Sink};
use crate::schema::Dbc;
use crate::time::Instant;

/// What a log is told before its first event.
#[derive(Clone, Debug, Default)]
pub struct LogContents<'a> {
    /// The run's buses; [`crate::event::BusFrame::bus`] is an index into them.
    pub buses: Vec<LoggedBus<'a>>,
    /// Files to keep in the log: (name, media type, content).
    pub attachments: Vec<(String, String, Vec<u8>)>,
    /// Names of what a scenario planned; [`crate::event::Mark::event`] is an
    /// index into them.
    pub planned: Vec<String>,
    /// What else is to be known of the run, such as version and seed.
    pub metadata: BTreeMap<String, String>,
}

/// A bus whose frames are logged.
#[derive(Clone, Debug)]
pub struct LoggedBus<'a> {
    /// Its name, such as `can0`.
    pub name: &'a str,
    /// What its frames are decoded with.
    pub dbcs: Vec<&'a Dbc>,
}

/// What to do with an event when the log's thread has not caught up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WhenFull {
    /// Wait: for simulated time, which can.
    Wait,
    /// Lose it and count it: for real time, which cannot.
    Drop,
}

/// What a log has written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LogReport {
    /// Messages in the file; a frame that the DBC knows makes two.
    pub messages: u64,
    /// Bytes in the file.
    pub bytes: u64,
    /// Events that are not in the file: with [`WhenFull::Drop`] those that
    /// found no room, and always those of a bus that the log was not told of.
    pub events_lost: u64,
    /// Times that the loop waited for room, with [`WhenFull::Wait`].
    pub waits: u64,
}

/// Why there is no log, or only part of one.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file could not be made, or not even its beginning be written.
    #[error("cannot create the log {path}: {source}")]
    Create {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file took no more. What was written before can be read.
    #[error("cannot go on writing the log {path}: {source}; it ends early, but what it has can be read")]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// MCAP counts channels with 16 bits.
    #[error("the DBC files of the logged buses have more messages than the 65000 that an MCAP file has channels for")]
    TooManyChannels,
}

/// A log being written to an MCAP file. Dropping it ends the file properly,
/// but only [`Self::finish`] says whether all went well.
///
/// | topic | encoding | what |
/// |---|---|---|
/// | `/can/<bus>` | ROS 2 CDR, `can_msgs/msg/Frame` | every classic frame |
/// | `/can/<bus>/fd` | protobuf, `canloop.CanFdFrame` | every CAN FD frame, which that has no room for |
/// | `/can/<bus>/<Message>` | protobuf, `canloop.<bus>.<Message>` | its signals, if the DBC knows it |
/// | `/canloop/stack` | protobuf, `canloop.Stack` | [`crate::event::Tick`] |
/// | `/canloop/truth` | protobuf, `canloop.Truth` | [`crate::event::Truth`] |
/// | `/canloop/loop` | protobuf, `canloop.Loop` | [`crate::event::Timing`] |
/// | `/canloop/exchange` | protobuf, `canloop.Exchange` | [`crate::exchange::Exchange`] |
/// | `/canloop/notices` | protobuf, `foxglove.Log` | [`crate::event::Notice`], [`crate::event::Mark`] |
///
/// Log and publish time are the event's nanoseconds; an event before the
/// origin is logged at the origin, but the stamp in a raw frame stays exact.
/// The same events give the same bytes. Chunks are written at least once a
/// second of the events' time, so a killed program loses little more than that.
///
/// A loop in real time makes its log before it raises its own priority, which
/// the log's threads would inherit.
pub struct McapLog {
    path: PathBuf,
    when_full: WhenFull,
    /// The batch being filled; none while there is no room.
    filling: Option<Batch>,
    /// Events lost since the last batch went out.
    lost: u64,
    waits: u64,
    to_writer: Option<SyncSender<Batch>>,
    from_writer: Receiver<Batch>,
    failed: Arc<AtomicBool>,
    thread: Option<JoinHandle<io::Result<Written>>>,
}

impl McapLog {
    /// Makes or overwrites the file at `path`, writes all that comes before
    /// the first event, and starts the thread that writes the rest.
    pub fn create(path: &Path, contents: &LogContents<'_>, when_full: WhenFull) -> Result<Self, LogError> {
        let failed = Arc::new(AtomicBool::new(false));
        let mut writer = Writer::create(path, contents, Arc::clone(&failed))?;
        let batches = when_full.batches();
        // Room for every batch and the empty one at the end: sending never waits.
        let (to_writer, full) = sync_channel::<Batch>(batches + 1);
        let (empty, from_writer) = sync_channel(batches + 1);
        for _ in 1..batches {
            let _ = empty.send(Batch::with_room());
        }
        let write = move || {
            for mut batch in full {
                writer.take(&mut batch);
                // Nobody takes it back once the log is being closed.
                let _ = empty.send(batch);
            }
            writer.finish()
        };
        let thread = Builder::new().name("log".to_owned()).spawn(write);
        let thread = thread.map_err(|source| LogError::Create { path: path.to_owned(), source })?;
        Ok(Self {
            path: path.to_owned(),
            when_full,
            filling: Some(Batch::with_room()),
            lost: 0,
            waits: 0,
            to_writer: Some(to_writer),
            from_writer,
            failed,
            thread: Some(thread),
        })
    }

    /// Whether the file takes no more; [`Self::finish`] says why.
    pub fn failed(&self) -> bool {
        self.failed.load(Ordering::Relaxed)
    }

    /// Writes what is left, ends the file and waits for the thread to be done.
    pub fn finish(mut self) -> Result<LogReport, LogError> {
        let written = self.close().map_err(|source| LogError::Write { path: self.path.clone(), source })?;
        let Written { messages, events_lost, bytes } = written;
        Ok(LogReport { messages, bytes, events_lost, waits: self.waits })
    }

    /// Hands the batch over and gets an empty one, if there is one.
    #[cold]
    fn hand_over(&mut self) {
        if let (Some(batch), Some(to_writer)) = (self.filling.take(), &self.to_writer) {
            let _ = to_writer.send(batch);
        }
        self.filling = self.from_writer.try_recv().ok();
        if self.filling.is_none() && self.when_full == WhenFull::Wait {
            self.waits += 1;
            self.filling = self.from_writer.recv().ok();
        }
        if let Some(batch) = &mut self.filling {
            batch.lost_before = std::mem::take(&mut self.lost);
        }
    }

    fn close(&mut self) -> io::Result<Written> {
        if let Some(to_writer) = self.to_writer.take() {
            let mut last = self.filling.take().unwrap_or_default();
            last.lost_before += std::mem::take(&mut self.lost);
            let _ = to_writer.send(last);
        }
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(written)) => written,
            _ => Err(io::Error::other("the thread that writes it has panicked")),
        }
    }
}

impl Sink for McapLog {
    fn event(&mut self, at: Instant, event: &Event) {
        if self.filling.as_ref().is_none_or(|batch| batch.is_full(at)) {
            self.hand_over();
        }
        match &mut self.filling {
            Some(batch) => batch.push(at, event),
            None => self.lost += u64::from(Batch::keeps(event)),
        }
    }
}

impl Drop for McapLog {
    fn drop(&mut self) {
        let _ = self.close();
    }
}

impl WhenFull {
    /// Batches between loop and thread: in real time enough for a disk that
    /// pauses for seconds, in simulated time few, to stay in the cache.
    const fn batches(self) -> usize {
        match self {
            Self::Wait => 4,
            Self::Drop => 32,
        }
    }
}
