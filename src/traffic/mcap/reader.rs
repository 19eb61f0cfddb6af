//! Goes through the records of a file, one chunk in memory at a time, without
//! the index at its end: a file that was never ended is read as far as its
//! whole chunks reach.

use std::io::{self, Read};

use mcap::records::{Record as McapRecord, op};

use super::channels::Channels;
use super::messages::{log_time, parse};
use crate::time::Instant;
use crate::traffic::bytes::{Window, u16_at, u32_at, u64_at};
use crate::traffic::{Buses, Content, Direction, Finding, Place, Reader, Record};

/// Opcode and length.
const PREFIX_BYTES: usize = 9;
/// Longer chunks, compressed or not, are those of a damaged file.
const LONGEST: u64 = 256 << 20;
/// Channel, sequence, log time, publish time.
const MESSAGE_HEAD_BYTES: usize = 22;
/// Start, end, size, checksum, then the name of the compression.
const CHUNK_HEAD_BYTES: usize = 8 + 8 + 8 + 4;

/// Reads `.mcap`.
pub(in crate::traffic) struct McapReader<R> {
    file: Window<R>,
    has_begun: bool,
    state: State,
    /// What the current chunk holds, read up to `at`.
    chunk: Vec<u8>,
    at: usize,
    /// Where the current chunk begins.
    chunk_offset: u64,
    ended: bool,
}

/// What the records so far have said.
#[derive(Default)]
struct State {
    channels: Channels,
    buses: Buses,
    latest: Instant,
    /// Frames that the log says at its end it has lost, and those of them
    /// whose moment it told.
    lost: u64,
    told: u64,
    /// Messages found, and how many the log says there are.
    messages: u64,
    stated_messages: Option<u64>,
    is_wrong: bool,
}

type Item = Result<Record, Finding>;

impl<R: Read> McapReader<R> {
    /// Reads `reader`.
    pub fn new(reader: R) -> Self {
        Self {
            file: Window::of(reader).with_checksum(),
            has_begun: false,
            state: State::default(),
            chunk: Vec::new(),
            at: 0,
            chunk_offset: 0,
            ended: false,
        }
    }

    fn step(&mut self) -> io::Result<Option<Item>> {
        if self.at < self.chunk.len() {
            return Ok(self.record_in_chunk());
        }
        let offset = self.file.offset;
        if !std::mem::replace(&mut self.has_begun, true) {
            if !self.file.fill(mcap::MAGIC.len())?.starts_with(mcap::MAGIC) {
                return Ok(self.give_up(0, "expected the beginning of an MCAP file"));
            }
            self.file.consume(mcap::MAGIC.len());
            return Ok(None);
        }
        let head = self.file.fill(PREFIX_BYTES)?;
        if head.len() < PREFIX_BYTES {
            return Ok(self.give_up(offset, "the log was not ended: all chunks before were read"));
        }
        let (opcode, len) = (head[0], u64_at(head, 1));
        match opcode {
            op::FOOTER => {
                self.ended = true;
                let all = PREFIX_BYTES + len.min(LONGEST) as usize + mcap::MAGIC.len();
                let is_whole = self.file.fill(all)?.get(..all).is_some_and(|end| end.ends_with(mcap::MAGIC));
                let cut = || {
                    let title = "the file ends in its last record, but all messages are there";
                    (!is_whole).then(|| Err(Finding::warning(Place::Byte(offset), title)))
                };
                Ok(self.state.what_is_missing(offset).or_else(|| self.lost()).or_else(cut))
            }
            op::DATA_END if len <= LONGEST => self.data_end(offset, len as usize),
            op::CHUNK | op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA | op::STATISTICS if len <= LONGEST => {
                self.whole_record(offset, opcode, len as usize)
            }
            op::HEADER | op::MESSAGE_INDEX..op::DATA_END | 0x80.. if len < u64::MAX / 2 => {
                match self.file.skip(PREFIX_BYTES as u64 + len)? {
                    true => Ok(None),
                    false => Ok(self.give_up(offset, "the file ends in the middle of this record")),
                }
            }
            _ => Ok(self.give_up(offset, "expected a record: nothing behind it can be read")),
        }
    }

    fn whole_record(&mut self, offset: u64, opcode: u8, len: usize) -> io::Result<Option<Item>> {
        let all = PREFIX_BYTES + len;
        let Some(bytes) = self.file.fill(all)?.get(..all) else {
            return Ok(self.give_up(offset, "the file ends in the middle of this record: all chunks before were read"));
        };
        let body = &bytes[PREFIX_BYTES..];
        let item = if opcode == op::CHUNK {
            self.at = 0;
            self.chunk_offset = offset;
            inflate(body, &mut self.chunk).err().map(|title| Err(Finding::error(Place::Byte(offset), title)))
        } else {
            self.state.record(opcode, body, Place::Byte(offset))
        };
        self.file.consume(all);
        Ok(item)
    }

    /// Compares the checksum of all before with what it should be, if that is known.
    fn data_end(&mut self, offset: u64, len: usize) -> io::Result<Option<Item>> {
        let is = self.file.checksum();
        let body = self.file.fill(PREFIX_BYTES + len)?.get(PREFIX_BYTES..).unwrap_or_default();
        let should_be = u32_at(body, 0);
        self.file.consume(PREFIX_BYTES + len);
        let is_damaged = should_be != 0 && is != Some(should_be) && !self.state.is_wrong;
        let title = "the checksum of the whole log is wrong: something in it is damaged";
        Ok(is_damaged.then(|| Err(Finding::error(Place::Byte(offset), title))))
    }

    fn record_in_chunk(&mut self) -> Option<Item> {
        let place = Place::Inside { chunk: self.chunk_offset, byte: self.at as u64 };
        let rest = &self.chunk[self.at..];
        let len = usize::try_from(u64_at(rest, 1)).unwrap_or(usize::MAX);
        let body = rest.get(PREFIX_BYTES..).and_then(|behind| behind.get(..len));
        let Some(body) = body else {
            self.at = self.chunk.len();
            return Some(Err(Finding::error(place, "a record does not end within its chunk")));
        };
        self.at += PREFIX_BYTES + len;
        self.state.record(rest[0], body, place)
    }

    fn give_up(&mut self, offset: u64, title: &str) -> Option<Item> {
        self.ended = true;
        Some(Err(Finding::error(Place::Byte(offset), title)))
    }

    fn lost(&mut self) -> Option<Item> {
        let untold = self.state.lost.saturating_sub(self.state.told);
        let lost = u32::try_from(untold).unwrap_or(u32::MAX);
        (lost > 0).then(|| {
            let content = Content::Lost(lost);
            Ok(Record { at: self.state.latest, bus: 0, direction: Direction::Received, content })
        })
    }
}

impl State {
    fn record(&mut self, opcode: u8, body: &[u8], place: Place) -> Option<Item> {
        if opcode == op::MESSAGE {
            self.messages += 1;
            return self.message(body, place);
        }
        if !matches!(opcode, op::SCHEMA | op::CHANNEL | op::METADATA | op::STATISTICS) {
            return None;
        }
        match mcap::parse_record(opcode, body) {
            Ok(McapRecord::Schema { header, .. }) => self.channels.schema(&header),
            Ok(McapRecord::Channel(channel)) => self.channels.channel(&channel),
            Ok(McapRecord::Metadata(metadata)) if metadata.name == "canloop.log" => {
                let lost = metadata.metadata.get("events_lost").and_then(|lost| lost.parse().ok());
                self.lost = lost.unwrap_or(0);
            }
            Ok(McapRecord::Statistics(statistics)) => self.stated_messages = Some(statistics.message_count),
            Ok(_) => {}
            Err(error) => return Some(Err(Finding::error(place, format!("a record cannot be read: {error}")))),
        }
        None
    }

    /// At the end: that messages have gone missing without a trace.
    fn what_is_missing(&self, offset: u64) -> Option<Item> {
        let (found, stated) = (self.messages, self.stated_messages?);
        let title = format!("the log says that it has {stated} messages, but {found} were found");
        (found != stated && !self.is_wrong).then(|| Err(Finding::error(Place::Byte(offset), title)))
    }

    fn message(&mut self, body: &[u8], place: Place) -> Option<Item> {
        let wrong = |title: &str| Some(Err(Finding::error(place, title)));
        let Some((head, data)) = body.split_at_checked(MESSAGE_HEAD_BYTES) else {
            return wrong("a message is shorter than its head");
        };
        let channel = self.channels.get(u16_at(head, 0))?;
        let message = match parse(channel.layout, data) {
            Ok(message) => message,
            Err(title) => return wrong(title),
        };
        let at = message.at.unwrap_or_else(|| log_time(head));
        let direction = message.direction.unwrap_or(channel.direction);
        let bus = match self.buses.index(message.bus.unwrap_or(&channel.bus)) {
            Ok(bus) => bus,
            Err(error) => return wrong(&error.to_string()),
        };
        self.latest = at;
        if let Content::Lost(count) = message.content {
            self.told += u64::from(count);
        }
        Some(Ok(Record { at, bus, direction, content: message.content }))
    }
}

/// Inflates the records of a chunk; `out` stays empty where that fails.
fn inflate(body: &[u8], out: &mut Vec<u8>) -> Result<(), String> {
    out.clear();
    let (size, crc) = (u64_at(body, 16), u32_at(body, 24));
    let name_len = u32_at(body, CHUNK_HEAD_BYTES) as usize;
    let behind = body.get(CHUNK_HEAD_BYTES + 4..).unwrap_or_default();
    let (name, rest) = behind.split_at_checked(name_len).ok_or("a chunk's head is damaged: it is left out")?;
    let records = rest.get(8..).filter(|records| records.len() as u64 == u64_at(rest, 0));
    let records = records.ok_or("a chunk's head is damaged: it is left out")?;
    if size > LONGEST {
        return Err(format!("a chunk says that it holds {size} bytes: it is left out"));
    }
    let inflated = match name {
        b"" => records.take(size + 1).read_to_end(out),
        b"zstd" => {
            zstd::stream::read::Decoder::with_buffer(records).and_then(|zstd| zstd.take(size + 1).read_to_end(out))
        }
        _ => {
            let name = String::from_utf8_lossy(name);
            return Err(format!("a chunk is compressed with {name}, expected zstd or nothing: it is left out"));
        }
    };
    let wrong = match inflated {
        Err(error) => Some(format!("a chunk cannot be inflated: {error}; it is left out")),
        Ok(_) if out.len() as u64 != size => Some("a chunk holds more or less than it says: it is left out".to_owned()),
        Ok(_) if crc != 0 && crc32fast::hash(out) != crc => {
            Some("the checksum of a chunk is wrong: it is left out".to_owned())
        }
        Ok(_) => None,
    };
    wrong.map_or(Ok(()), |title| {
        out.clear();
        Err(title)
    })
}

impl<R: Read> Iterator for McapReader<R> {
    type Item = Item;

    fn next(&mut self) -> Option<Item> {
        while !self.ended {
            let step = self.step().unwrap_or_else(|error| {
                self.ended = true;
                Some(Err(Finding::error(Place::Byte(self.file.offset), format!("cannot read on: {error}"))))
            });
            if let Some(item) = step {
                self.state.is_wrong |= item.is_err();
                return Some(item);
            }
        }
        None
    }
}

impl<R: Read> Reader for McapReader<R> {
    fn buses(&self) -> &Buses {
        &self.state.buses
    }
}
