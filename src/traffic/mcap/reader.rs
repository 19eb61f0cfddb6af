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
    /// Frames that the log says it has lost.
    lost: u64,
}

type Item = Result<Record, Finding>;

impl<R: Read> McapReader<R> {
    /// Reads `reader`.
    pub fn new(reader: R) -> Self {
        Self {
            file: Window::of(reader),
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
                Ok(self.lost())
            }
            op::CHUNK | op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA if len <= LONGEST => {
                self.whole_record(offset, opcode, len as usize)
            }
            op::HEADER | op::MESSAGE_INDEX..=op::DATA_END | 0x80.. if len < u64::MAX / 2 => {
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
        let lost = u32::try_from(std::mem::take(&mut self.state.lost)).unwrap_or(u32::MAX);
        (lost > 0).then(|| {
            let content = Content::Lost(lost);
            Ok(Record { at: self.state.latest, bus: 0, direction: Direction::Received, content })
        })
    }
}

impl State {
    fn record(&mut self, opcode: u8, body: &[u8], place: Place) -> Option<Item> {
        if opcode == op::MESSAGE {
            return self.message(body, place);
        }
        if !matches!(opcode, op::SCHEMA | op::CHANNEL | op::METADATA) {
            return None;
        }
        match mcap::parse_record(opcode, body) {
            Ok(McapRecord::Schema { header, .. }) => self.channels.schema(&header),
            Ok(McapRecord::Channel(channel)) => self.channels.channel(&channel),
            Ok(McapRecord::Metadata(metadata)) if metadata.name == "canloop.log" => {
                let lost = metadata.metadata.get("events_lost").and_then(|lost| lost.parse().ok());
                self.lost = lost.unwrap_or(0);
            }
            Ok(_) => {}
            Err(error) => return Some(Err(Finding::error(place, format!("a record cannot be read: {error}")))),
        }
        None
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
            if step.is_some() {
                return step;
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
