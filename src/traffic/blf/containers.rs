//! The bytes of all objects in a file, one behind the other, whether they
//! stand in the file itself or in compressed containers. Inflated a piece at
//! a time: what a container says of its size is not believed.

use std::collections::VecDeque;
use std::io::{self, Read};

use flate2::{Decompress, FlushDecompress, Status};

use super::{MARK, OBJECT_BASE_BYTES, kind};
use crate::traffic::bytes::{Window, u16_at, u32_at};
use crate::traffic::{Finding, Place};

/// Behind the base of a container: method, reserved, size inflated, reserved.
const CONTAINER_BYTES: usize = OBJECT_BASE_BYTES + 2 + 6 + 4 + 4;
const STORED: u16 = 0;
const ZLIB: u16 = 2;
/// Bytes inflated, or copied, at a time.
const PIECE: usize = 64 << 10;
/// Zeros that may stand between objects, to fill up.
const PADDING: usize = 8;

/// Gives out the bytes of objects.
pub(super) struct Containers<R> {
    pub file: Window<R>,
    current: Option<Current>,
    /// How many bytes have been given out.
    given: u64,
    /// Where what begins at which byte given out comes from.
    origins: VecDeque<(u64, Place)>,
}

/// An object of the file that is being given out.
struct Current {
    place: Place,
    /// Bytes of it that are still in the file.
    left: u64,
    inflater: Option<Decompress>,
}

/// What came of asking for more.
pub(super) enum More {
    /// Bytes.
    Bytes,
    /// Something is wrong; there may be more all the same.
    Wrong(Finding),
    /// That was all.
    End,
}

impl<R: Read> Containers<R> {
    /// Those in `file`, which stands behind the header.
    pub fn of(file: Window<R>) -> Self {
        Self { file, current: None, given: 0, origins: VecDeque::new() }
    }

    /// Where the byte given out as number `at` comes from.
    pub fn place_of(&mut self, at: u64) -> Place {
        while self.origins.get(1).is_some_and(|(start, _)| *start <= at) {
            self.origins.pop_front();
        }
        match self.origins.front() {
            Some(&(start, Place::Inside { chunk, .. })) => Place::Inside { chunk, byte: at - start },
            Some(&(start, Place::Byte(byte))) => Place::Byte(byte + (at - start)),
            _ => Place::Byte(self.file.offset),
        }
    }

    /// Appends some more bytes.
    pub fn more(&mut self, out: &mut Vec<u8>) -> io::Result<More> {
        let before = out.len();
        let more = match self.current.take() {
            Some(current) => self.go_on(current, out)?,
            None => self.next_object()?,
        };
        self.given += (out.len() - before) as u64;
        Ok(more)
    }

    /// Finds the next object of the file.
    fn next_object(&mut self) -> io::Result<More> {
        let there = self.file.fill(PADDING + CONTAINER_BYTES)?;
        let padding = there.iter().take(PADDING).position(|&byte| byte != 0).unwrap_or(there.len().min(PADDING));
        self.file.consume(padding);
        let offset = self.file.offset;
        let wrong = |title: &str| Ok(More::Wrong(Finding::error(Place::Byte(offset), title)));
        let head = self.file.fill(CONTAINER_BYTES)?;
        if head.is_empty() {
            return Ok(More::End);
        }
        if head.len() < OBJECT_BASE_BYTES {
            let all = head.len();
            self.file.consume(all);
            return wrong("the file ends in the middle of the head of an object");
        }
        if !head.starts_with(MARK) {
            self.file.consume(1);
            self.file.skip_to(MARK)?;
            return wrong("expected an object, which begins with LOBJ: what is before the next one is lost");
        }
        let size = u32_at(head, 8) as usize;
        let is_container = u32_at(head, 12) == kind::CONTAINER;
        if size < if is_container { CONTAINER_BYTES } else { OBJECT_BASE_BYTES } {
            self.file.consume(MARK.len());
            self.file.skip_to(MARK)?;
            return wrong("an object says that it is shorter than its own head: it is lost");
        }
        if !is_container {
            self.begin(Place::Byte(offset), size, None);
            return Ok(More::Bytes);
        }
        let inflater = match u16_at(head, OBJECT_BASE_BYTES) {
            _ if head.len() < CONTAINER_BYTES => {
                let all = head.len();
                self.file.consume(all);
                return wrong("the file ends in the middle of the head of a container");
            }
            STORED => None,
            ZLIB => Some(Decompress::new(true)),
            method => {
                self.file.skip(size as u64)?;
                return wrong(&format!(
                    "a container is compressed by method {method}, expected 0 or 2: it is left out"
                ));
            }
        };
        self.file.consume(CONTAINER_BYTES);
        self.begin(Place::Inside { chunk: offset, byte: 0 }, size - CONTAINER_BYTES, inflater);
        Ok(More::Bytes)
    }

    fn begin(&mut self, place: Place, left: usize, inflater: Option<Decompress>) {
        self.origins.push_back((self.given, place));
        self.current = Some(Current { place, left: left as u64, inflater });
    }

    /// Gives out a piece of the current object.
    fn go_on(&mut self, mut current: Current, out: &mut Vec<u8>) -> io::Result<More> {
        let there = self.file.fill(PIECE.min(current.left as usize).max(1))?;
        let input = &there[..there.len().min(current.left as usize)];
        if input.is_empty() {
            let cut_short = current.left > 0;
            let title = "the file ends in the middle of this object";
            return Ok(if cut_short { More::Wrong(Finding::error(current.place, title)) } else { More::Bytes });
        }
        let (used, ended) = match &mut current.inflater {
            None => {
                let piece = input.len().min(PIECE);
                out.extend_from_slice(&input[..piece]);
                (piece, false)
            }
            Some(inflater) => {
                let before = inflater.total_in();
                out.reserve(PIECE);
                match inflater.decompress_vec(input, out, FlushDecompress::None) {
                    Ok(status) => {
                        let used = (inflater.total_in() - before) as usize;
                        (used, status == Status::StreamEnd || status == Status::BufError)
                    }
                    Err(_) => return self.give_up(&current),
                }
            }
        };
        self.file.consume(used);
        current.left -= used as u64;
        if ended {
            self.file.skip(current.left)?;
        } else {
            self.current = Some(current);
        }
        Ok(More::Bytes)
    }

    /// The rest of a container cannot be inflated.
    fn give_up(&mut self, current: &Current) -> io::Result<More> {
        let at = self.file.offset;
        self.file.skip(current.left)?;
        let title = format!("the compressed data is damaged behind byte {at}: the rest of this container is lost");
        Ok(More::Wrong(Finding::error(current.place, title)))
    }
}
