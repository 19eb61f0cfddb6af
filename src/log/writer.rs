//! Turns events into the messages of a file, on a thread of the log's own.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use prost_types::field_descriptor_proto::Type;

use super::batch::Batch;
use super::bus::{BusLog, FrameSchemas};
use super::channels::Channels;
use super::chunk::Chunk;
use super::chunk_queue::ChunkQueue;
use super::descriptor::{flat_message, foxglove_log};
use super::exchange::{EXCHANGE_FIELDS, put_exchange};
use super::file::LogFile;
use super::protobuf::{Level, put_doubles, put_log};
use super::{EXCHANGE_TOPIC, LOOP_TOPIC, LogContents, LogError, NOTICES_TOPIC, STACK_TOPIC};
use crate::event::{Event, Mark, Notice, Sink, Tick, Timing, Truth};
use crate::time::Instant;

/// Writes the events of a run to an MCAP file.
pub(super) struct Writer {
    queue: ChunkQueue,
    chunk: Chunk,
    channels: Channels,
    buses: Vec<BusLog>,
    stack: u16,
    truth: u16,
    timing: u16,
    notices: u16,
    exchange: u16,
    /// Names of what a [`Mark`] counts.
    planned: Vec<String>,
    /// The latest event's time.
    now: Instant,
    lost: u64,
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
        let frames = FrameSchemas::new(&mut channels)?;
        let buses: Result<Vec<_>, _> =
            contents.buses.iter().map(|bus| BusLog::new(bus, &frames, &mut channels)).collect();
        let buses = buses?;
        let stack = doubles_channel(&mut channels, STACK_TOPIC, "Stack", &Tick::NAMES)?;
        let truth = doubles_channel(&mut channels, "/canloop/truth", "Truth", &Truth::NAMES)?;
        let timing = doubles_channel(&mut channels, LOOP_TOPIC, "Loop", &Timing::NAMES)?;
        let exchange = flat_message("canloop", "Exchange", &EXCHANGE_FIELDS);
        let exchange = channels.schema("canloop.Exchange", "protobuf", &exchange)?;
        let exchange = channels.channel(exchange, EXCHANGE_TOPIC.to_owned(), "protobuf", BTreeMap::new())?;
        let log = channels.schema("foxglove.Log", "protobuf", &foxglove_log())?;
        let notices = channels.channel(log, NOTICES_TOPIC.to_owned(), "protobuf", BTreeMap::new())?;

        let start = || {
            let mut file = LogFile::create(path)?;
            file.metadata("canloop", &contents.metadata)?;
            for (name, media_type, data) in &contents.attachments {
                file.attachment(name, media_type, data)?;
            }
            ChunkQueue::start(file, channels.len(), failed)
        };
        let (queue, chunk) = start().map_err(|source| LogError::Create { path: path.to_owned(), source })?;
        let (planned, now) = (contents.planned.clone(), Instant::ZERO);
        Ok(Self { queue, chunk, channels, buses, stack, truth, timing, notices, exchange, planned, now, lost: 0 })
    }

    /// Writes a batch and leaves it empty.
    pub fn take(&mut self, batch: &mut Batch) {
        let lost = std::mem::take(&mut batch.lost_before);
        if lost > 0 {
            self.lost += lost;
            let text = format!("{lost} events are not in this log: it was written slower than they came");
            self.notice(batch.start().unwrap_or(self.now), Level::Error, "log", &text);
        }
        batch.drain_into(self);
    }

    /// Writes what is left and ends the file.
    pub fn finish(mut self) -> io::Result<Written> {
        if !self.chunk.is_empty() {
            self.queue.send(&mut self.chunk);
        }
        let mut file = self.queue.finish()?;
        let messages = file.end(&self.channels, self.lost)?;
        Ok(Written { messages, events_lost: self.lost, bytes: file.len() })
    }

    fn notice(&mut self, at: Instant, level: Level, name: &str, text: &str) {
        self.channels.message(&mut self.chunk, self.notices, at, |out| put_log(out, at, level, name, text));
    }
}

impl Sink for Writer {
    fn event(&mut self, at: Instant, event: &Event) {
        self.now = at;
        match event {
            Event::Frame(on_bus) => match self.buses.get(usize::from(on_bus.bus)) {
                Some(bus) => bus.put(&mut self.channels, &mut self.chunk, at, &on_bus.into()),
                None => self.lost += 1,
            },
            Event::Sync(_) => {}
            Event::Tick(tick) => {
                self.channels.message(&mut self.chunk, self.stack, at, |out| put_doubles(out, &tick.values()));
            }
            Event::Truth(truth) => {
                self.channels.message(&mut self.chunk, self.truth, at, |out| put_doubles(out, &truth.values()));
            }
            Event::Timing(timing) => {
                self.channels.message(&mut self.chunk, self.timing, at, |out| put_doubles(out, &timing.values()));
            }
            Event::Exchange(exchange) => {
                self.channels.message(&mut self.chunk, self.exchange, at, |out| put_exchange(out, exchange));
            }
            Event::Notice(Notice { kind, text }) => self.notice(at, Level::Info, kind, text),
            Event::Mark(Mark { event, has_begun }) => {
                let name = self.planned.get(usize::from(*event)).map_or("an event", String::as_str);
                let text = format!("{name} {}", if *has_begun { "begins" } else { "ends" });
                self.notice(at, Level::Info, "event", &text);
            }
        }
        if self.chunk.is_full() {
            self.queue.send(&mut self.chunk);
        }
    }
}

/// Adds a channel whose messages are doubles with these names.
fn doubles_channel(channels: &mut Channels, topic: &str, name: &str, fields: &[&str]) -> Result<u16, LogError> {
    let fields: Vec<_> = fields.iter().map(|&field| (field, Type::Double)).collect();
    let schema = channels.schema(&format!("canloop.{name}"), "protobuf", &flat_message("canloop", name, &fields))?;
    channels.channel(schema, topic.to_owned(), "protobuf", BTreeMap::new())
}
