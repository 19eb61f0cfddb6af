//! What a log holds for a replay, in the order in which it was written.

use std::collections::BTreeMap;

use mcap::McapError;
use mcap::read::{ChunkFlattener, Options};
use mcap::records::Record;

use crate::event::{Tick, Timing};
use crate::exchange::Exchange;
use crate::log::{EXCHANGE_TOPIC, LOOP_TOPIC, NOTICES_TOPIC, STACK_TOPIC, Value, exchange_from, read_fields};

/// Goes through a log. One that was never ended is read as far as its whole
/// chunks reach; [`Self::is_cut`] says so then.
pub struct Recorded<'l> {
    records: ChunkFlattener<'l>,
    topics: BTreeMap<u16, Topic>,
    only_exchange: bool,
    is_cut: bool,
}

/// Something that a replay has a use for.
#[derive(Clone, Debug)]
pub enum RecordedItem {
    /// What went into the stack or came out of it.
    Exchange(Exchange),
    /// The stack's own state after a tick, as in [`Tick::values`].
    Tick(Box<[f64; Tick::NAMES.len()]>),
    /// How punctual a loop was in a period, as in [`Timing::values`].
    Timing(Box<[f64; Timing::NAMES.len()]>),
    /// A line for people: when, ns; its kind; its text.
    Notice(u64, String, String),
}

#[derive(Clone, Copy, Debug)]
enum Topic {
    Exchange,
    Stack,
    Loop,
    Notices,
}

impl<'l> Recorded<'l> {
    /// Goes through the bytes of an MCAP file.
    ///
    /// # Errors
    /// They are not those of one.
    pub fn new(log: &'l [u8]) -> Result<Self, String> {
        Ok(Self { records: flattened(log)?, topics: BTreeMap::new(), only_exchange: false, is_cut: false })
    }

    /// The same, with nothing but [`RecordedItem::Exchange`]: all that a replay
    /// needs, and nothing else is read.
    ///
    /// # Errors
    /// They are not those of one.
    pub fn only_exchange(log: &'l [u8]) -> Result<Self, String> {
        Ok(Self { only_exchange: true, ..Self::new(log)? })
    }

    /// Whether the log was never ended.
    pub const fn is_cut(&self) -> bool {
        self.is_cut
    }

    fn item(&mut self, record: Record<'l>) -> Result<Option<RecordedItem>, String> {
        match record {
            Record::Channel(channel) => {
                let topic = match channel.topic.as_str() {
                    EXCHANGE_TOPIC => Topic::Exchange,
                    _ if self.only_exchange => return Ok(None),
                    STACK_TOPIC => Topic::Stack,
                    LOOP_TOPIC => Topic::Loop,
                    NOTICES_TOPIC => Topic::Notices,
                    _ => return Ok(None),
                };
                self.topics.insert(channel.id, topic);
                Ok(None)
            }
            Record::Message { header, data } => match self.topics.get(&header.channel_id) {
                Some(Topic::Exchange) => exchange_from(&data).map(RecordedItem::Exchange).map(Some),
                Some(Topic::Stack) => doubles(&data).map(RecordedItem::Tick).map(Some),
                Some(Topic::Loop) => doubles(&data).map(RecordedItem::Timing).map(Some),
                Some(Topic::Notices) => {
                    let (kind, text) = notice(&data)?;
                    Ok(Some(RecordedItem::Notice(header.log_time, kind, text)))
                }
                None => Ok(None),
            },
            _ => Ok(None),
        }
    }
}

impl<'l> Iterator for Recorded<'l> {
    type Item = Result<RecordedItem, String>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let record = match self.records.next()? {
                Ok(record) => record,
                Err(McapError::UnexpectedEof | McapError::UnexpectedEoc) => {
                    self.is_cut = true;
                    return None;
                }
                Err(error) => return Some(Err(error.to_string())),
            };
            if let Some(item) = self.item(record).transpose() {
                return Some(item);
            }
        }
    }
}

/// The files attached to a log, which come before its first message: name and
/// content.
///
/// # Errors
/// It is no log, or cannot be read so far.
pub fn attachments(log: &[u8]) -> Result<Vec<(String, Vec<u8>)>, String> {
    let mut found = Vec::new();
    for record in flattened(log)? {
        match record {
            Ok(Record::Attachment { header, data, .. }) => found.push((header.name, data.into_owned())),
            Ok(Record::Message { .. }) | Err(McapError::UnexpectedEof | McapError::UnexpectedEoc) => break,
            Ok(_) => {}
            Err(error) => return Err(error.to_string()),
        }
    }
    Ok(found)
}

fn flattened(log: &[u8]) -> Result<ChunkFlattener<'_>, String> {
    if !log.starts_with(mcap::MAGIC) {
        return Err("it does not begin as an MCAP file does".to_owned());
    }
    ChunkFlattener::new_with_options(log, Options::IgnoreEndMagic.into()).map_err(|error| error.to_string())
}

/// Fields numbered from 1; one that is missing is no number.
fn doubles<const N: usize>(message: &[u8]) -> Result<Box<[f64; N]>, String> {
    let mut values = Box::new([f64::NAN; N]);
    read_fields(message, |number, value| {
        if let (Some(slot), Value::Fixed(bits)) = (values.get_mut((number as usize).wrapping_sub(1)), value) {
            *slot = f64::from_bits(bits);
        }
    })?;
    Ok(values)
}

/// Name and message of a `foxglove.Log`.
fn notice(message: &[u8]) -> Result<(String, String), String> {
    let (mut kind, mut text): (&[u8], &[u8]) = (&[], &[]);
    read_fields(message, |number, value| match (number, value) {
        (3, Value::Bytes(bytes)) => text = bytes,
        (4, Value::Bytes(bytes)) => kind = bytes,
        _ => {}
    })?;
    let owned = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Ok((owned(kind), owned(text)))
}
