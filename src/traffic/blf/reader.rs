//! Finds the objects among the bytes, and gives out what they say.

use std::io::Read;

use super::containers::{Containers, More};
use super::header::{HEADER_BYTES, Header};
use super::objects::{Said, body_bytes, parse};
use super::{MARK, OBJECT_BASE_BYTES, OBJECT_HEADER_BYTES};
use crate::time::Instant;
use crate::traffic::bytes::{Window, u16_at, u32_at, u64_at};
use crate::traffic::{Buses, Finding, Place, Reader, Record};

/// Longer objects of ours are damaged.
const LONGEST: usize = 64 << 10;
/// Zeros that may stand between objects, to fill up.
const PADDING: usize = 8;
const TEN_MICROSECONDS: u32 = 1;

/// Reads `.blf`.
pub(in crate::traffic) struct BlfReader<R> {
    containers: Containers<R>,
    header: Option<Header>,
    buses: Buses,
    /// Bytes of objects that have not been read yet, from `at` on.
    bytes: Vec<u8>,
    at: usize,
    /// The number of the byte at `at`, counted through all objects.
    position: u64,
    /// Bytes still to be passed over.
    to_skip: u64,
    is_wrong: bool,
    ended: bool,
}

/// What is at the beginning of the bytes.
enum Next {
    Object {
        kind: u32,
        size: usize,
        head: usize,
    },
    Wrong(&'static str),
    /// Not enough bytes to tell.
    More,
}

impl<R: Read> BlfReader<R> {
    /// Reads `reader`.
    pub fn new(reader: R) -> Self {
        Self {
            containers: Containers::of(Window::of(reader)),
            header: None,
            buses: Buses::default(),
            bytes: Vec::new(),
            at: 0,
            position: 0,
            to_skip: 0,
            is_wrong: false,
            ended: false,
        }
    }

    fn step(&mut self) -> std::io::Result<Option<Result<Record, Finding>>> {
        if self.header.is_none() {
            return self.read_header();
        }
        self.skip_padding();
        match self.next_object() {
            Next::Object { kind, size, head } => Ok(self.object(kind, size, head)),
            Next::Wrong(title) => {
                let place = self.place();
                self.skip_to_mark();
                Ok(Some(Err(Finding::error(place, title))))
            }
            Next::More => self.more(),
        }
    }

    fn read_header(&mut self) -> std::io::Result<Option<Result<Record, Finding>>> {
        let file = &mut self.containers.file;
        let there = file.fill(HEADER_BYTES)?;
        let (header, whole) = (Header::parse(there), there.len() >= HEADER_BYTES);
        let is_log = header.is_some();
        let header = header.unwrap_or_default();
        // A length that cannot be is not believed: objects are found by their mark.
        let len = if (64..4096).contains(&header.len) { header.len } else { 0 };
        self.header = Some(header);
        file.skip(len)?;
        if is_log && whole {
            return Ok(None);
        }
        file.skip_to(MARK)?;
        let title = if is_log { "the file ends in its header" } else { "expected the header of a BLF file, LOGG" };
        Ok(Some(Err(Finding::error(Place::Byte(0), title))))
    }

    /// Passes over what is left of an object of no interest, and over what
    /// fills up behind objects.
    fn skip_padding(&mut self) {
        let waiting = self.bytes.len() - self.at;
        let rest = waiting.min(usize::try_from(self.to_skip).unwrap_or(usize::MAX));
        self.to_skip -= rest as u64;
        self.advance(rest);
        if self.to_skip == 0 {
            let padding = self.bytes[self.at..].iter().take(PADDING).take_while(|byte| **byte == 0).count();
            self.advance(padding);
        }
    }

    fn next_object(&self) -> Next {
        let waiting = &self.bytes[self.at..];
        if self.to_skip > 0 || waiting.len() < OBJECT_BASE_BYTES {
            return Next::More;
        }
        if !waiting.starts_with(MARK) {
            return Next::Wrong("expected an object, which begins with LOBJ: what is before the next one is lost");
        }
        let (head, size, kind) = (usize::from(u16_at(waiting, 4)), u32_at(waiting, 8) as usize, u32_at(waiting, 12));
        if size < OBJECT_BASE_BYTES {
            return Next::Wrong("an object says that it is shorter than its own head: it is lost");
        }
        let Some(body) = body_bytes(kind) else { return Next::Object { kind, size, head } };
        if head < OBJECT_HEADER_BYTES || size < head + body || size > LONGEST {
            return Next::Wrong("an object says that it has a size which its type cannot have: it is lost");
        }
        if waiting.len() < size { Next::More } else { Next::Object { kind, size, head } }
    }

    fn object(&mut self, kind: u32, size: usize, head: usize) -> Option<Result<Record, Finding>> {
        if body_bytes(kind).is_none() {
            self.to_skip = size as u64;
            return None;
        }
        let object = &self.bytes[self.at..self.at + size];
        let said = parse(kind, &object[head..], head);
        let (flags, time) = (u32_at(object, 16), u64_at(object, 24));
        let unit = if flags == TEN_MICROSECONDS { 10_000 } else { 1 };
        let since_start = i64::try_from(time).unwrap_or(i64::MAX).saturating_mul(unit);
        let start_ns = self.header.as_ref().map_or(0, |header| header.start_ns);
        let at = Instant::from_nanos(start_ns.saturating_add(since_start));
        let found = match said {
            Ok(Said::Happened { number, direction, content }) => match self.buses.numbered(number) {
                Ok(bus) => Some(Ok(Record { at, bus, direction, content })),
                Err(error) => Some(Err(Finding::error(self.place(), error.to_string()))),
            },
            Ok(Said::Name { number, name }) => {
                // One name for several channels tells none of them.
                if !self.buses.names().contains(&name) {
                    let _ = self.buses.declare(number, &name);
                }
                None
            }
            Ok(Said::Nothing) => None,
            Err(title) => Some(Err(Finding::error(self.place(), title))),
        };
        self.advance(size);
        found
    }

    fn more(&mut self) -> std::io::Result<Option<Result<Record, Finding>>> {
        self.bytes.drain(..self.at);
        self.at = 0;
        Ok(match self.containers.more(&mut self.bytes)? {
            More::Bytes => None,
            More::Wrong(finding) => {
                // What was begun does not go on in what comes next.
                self.drop_waiting();
                Some(Err(finding))
            }
            More::End => {
                self.ended = true;
                self.what_is_missing().map(Err)
            }
        })
    }

    /// At the end: what there should have been.
    fn what_is_missing(&mut self) -> Option<Finding> {
        if !self.bytes.is_empty() || self.to_skip > 0 {
            return Some(Finding::error(self.place(), "the file ends in the middle of this object"));
        }
        let (is, should_be) = (self.containers.file.offset, self.header.as_ref()?.file_bytes);
        let title = format!("the file ends here, but its header says that it has {should_be} bytes");
        (is < should_be && !self.is_wrong).then(|| Finding::error(Place::Byte(is), title))
    }

    fn drop_waiting(&mut self) {
        let len = self.bytes.len() - self.at;
        self.advance(len);
        self.to_skip = 0;
    }

    fn skip_to_mark(&mut self) {
        let waiting = &self.bytes[self.at..];
        let next = memchr::memmem::find(&waiting[1..], MARK).map(|at| at + 1);
        // The beginning of a mark may be the last that there is.
        let next = next.unwrap_or_else(|| waiting.len().saturating_sub(MARK.len() - 1).max(1));
        self.advance(next);
    }

    fn advance(&mut self, count: usize) {
        self.at += count;
        self.position += count as u64;
    }

    fn place(&mut self) -> Place {
        self.containers.place_of(self.position)
    }
}

impl<R: Read> Iterator for BlfReader<R> {
    type Item = Result<Record, Finding>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.ended {
            let step = self.step().unwrap_or_else(|error| {
                self.ended = true;
                let place = Place::Byte(self.containers.file.offset);
                Some(Err(Finding::error(place, format!("cannot read on: {error}"))))
            });
            if let Some(item) = step {
                self.is_wrong |= item.is_err();
                return Some(item);
            }
        }
        None
    }
}

impl<R: Read> Reader for BlfReader<R> {
    fn buses(&self) -> &Buses {
        &self.buses
    }
}
