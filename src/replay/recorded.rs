//! What a log holds for a replay, in the order in which it was written.

use std::borrow::Cow;
use std::collections::BTreeMap;

use mcap::McapError;
use mcap::read::{ChunkFlattener, Options};
use mcap::records::Record;
use prost::bytes::Buf;
use prost::encoding::{DecodeContext, WireType, decode_key, double, skip_field, string};

use crate::event::{Tick, Timing};
use crate::exchange::Exchange;
use crate::log::{EXCHANGE_TOPIC, LOOP_TOPIC, NOTICES_TOPIC, STACK_TOPIC, exchange_from};

/// Goes through a log. One that was never ended is read as far as its whole
/// chunks reach; [`Self::is_cut`] says so then.
pub struct Recorded<'l> {
    records: ChunkFlattener<'l>,
    topics: BTreeMap<u16, Topic>,
    is_cut: bool,
}

/// Something that a replay has a use for.
#[derive(Clone, Debug)]
pub enum RecordedItem<'l> {
    /// A file that was attached.
    Attachment {
        /// Its name.
        name: String,
        /// Its content.
        data: Cow<'l, [u8]>,
    },
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
        if !log.starts_with(mcap::MAGIC) {
            return Err("it does not begin as an MCAP file does".to_owned());
        }
        let records = ChunkFlattener::new_with_options(log, Options::IgnoreEndMagic.into());
        let records = records.map_err(|error| error.to_string())?;
        Ok(Self { records, topics: BTreeMap::new(), is_cut: false })
    }

    /// Whether the log was never ended.
    pub const fn is_cut(&self) -> bool {
        self.is_cut
    }

    fn item(&mut self, record: Record<'l>) -> Result<Option<RecordedItem<'l>>, String> {
        match record {
            Record::Channel(channel) => {
                let topic = match channel.topic.as_str() {
                    EXCHANGE_TOPIC => Topic::Exchange,
                    STACK_TOPIC => Topic::Stack,
                    LOOP_TOPIC => Topic::Loop,
                    NOTICES_TOPIC => Topic::Notices,
                    _ => return Ok(None),
                };
                self.topics.insert(channel.id, topic);
                Ok(None)
            }
            Record::Attachment { header, data, .. } => Ok(Some(RecordedItem::Attachment { name: header.name, data })),
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
    type Item = Result<RecordedItem<'l>, String>;

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

/// Fields numbered from 1; one that is missing is no number.
fn doubles<const N: usize>(mut message: &[u8]) -> Result<Box<[f64; N]>, String> {
    let mut values = Box::new([f64::NAN; N]);
    while message.has_remaining() {
        let mut field = || {
            let (number, wire): (u32, WireType) = decode_key(&mut message)?;
            match values.get_mut(number as usize - 1) {
                Some(value) => double::merge(wire, value, &mut message, DecodeContext::default()),
                None => skip_field(wire, number, &mut message, DecodeContext::default()),
            }
        };
        field().map_err(|error: prost::DecodeError| error.to_string())?;
    }
    Ok(values)
}

/// Name and message of a `foxglove.Log`.
fn notice(mut message: &[u8]) -> Result<(String, String), String> {
    let (mut kind, mut text) = (String::new(), String::new());
    while message.has_remaining() {
        let mut field = || {
            let (number, wire): (u32, WireType) = decode_key(&mut message)?;
            match number {
                3 => string::merge(wire, &mut text, &mut message, DecodeContext::default()),
                4 => string::merge(wire, &mut kind, &mut message, DecodeContext::default()),
                _ => skip_field(wire, number, &mut message, DecodeContext::default()),
            }
        };
        field().map_err(|error: prost::DecodeError| error.to_string())?;
    }
    Ok((kind, text))
}
