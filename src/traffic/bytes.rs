//! Bytes of binary formats: a window that moves over a file, and numbers in it.

use std::io::{self, Read};

/// A part of a file that is in memory.
pub(super) struct Window<R> {
    reader: R,
    buffer: Vec<u8>,
    start: usize,
    /// Where in the file the window begins.
    pub offset: u64,
    at_end: bool,
    /// Of all bytes that the window has moved over, where it is wanted.
    checksum: Option<crc32fast::Hasher>,
}

/// Bytes asked of the file at a time.
const STEP: usize = 64 << 10;

impl<R: Read> Window<R> {
    /// At the beginning of `reader`.
    pub fn of(reader: R) -> Self {
        Self { reader, buffer: Vec::new(), start: 0, offset: 0, at_end: false, checksum: None }
    }

    /// The same, keeping the CRC-32 of what it moves over.
    pub fn with_checksum(self) -> Self {
        Self { checksum: Some(crc32fast::Hasher::new()), ..self }
    }

    /// The CRC-32 of all that the window has moved over.
    pub fn checksum(&self) -> Option<u32> {
        self.checksum.clone().map(crc32fast::Hasher::finalize)
    }

    /// What is in the window: at least `wanted` bytes, unless the file ends.
    /// What is not there is not made room for, however much is wanted.
    pub fn fill(&mut self, wanted: usize) -> io::Result<&[u8]> {
        while self.buffer.len() - self.start < wanted && !self.at_end {
            self.buffer.drain(..self.start);
            self.start = 0;
            let more = (wanted - self.buffer.len()).clamp(1, STEP).max(STEP) as u64;
            self.at_end = self.reader.by_ref().take(more).read_to_end(&mut self.buffer)? == 0;
        }
        Ok(&self.buffer[self.start..])
    }

    /// Moves the window on by at most what is in it.
    pub fn consume(&mut self, count: usize) {
        let count = count.min(self.buffer.len() - self.start);
        if let Some(checksum) = &mut self.checksum {
            checksum.update(&self.buffer[self.start..self.start + count]);
        }
        self.start += count;
        self.offset += count as u64;
    }

    /// Moves the window on over what is not needed; `false` where the file
    /// ends before that.
    pub fn skip(&mut self, mut count: u64) -> io::Result<bool> {
        while count > 0 {
            let there = self.fill(1)?.len() as u64;
            if there == 0 {
                return Ok(false);
            }
            let step = there.min(count);
            self.consume(step as usize);
            count -= step;
        }
        Ok(true)
    }

    /// Moves the window to the next `mark`; `false` where there is none.
    pub fn skip_to(&mut self, mark: &[u8]) -> io::Result<bool> {
        loop {
            let there = self.fill(mark.len())?;
            if let Some(at) = memchr::memmem::find(there, mark) {
                self.consume(at);
                return Ok(true);
            }
            let len = there.len();
            if len < mark.len() {
                self.consume(len);
                return Ok(false);
            }
            self.consume(len + 1 - mark.len());
        }
    }
}

/// The number at `at`, little-endian; 0 where the bytes end before.
pub(super) fn u16_at(bytes: &[u8], at: usize) -> u16 {
    bytes.get(at..).and_then(<[u8]>::first_chunk).map_or(0, |chunk| u16::from_le_bytes(*chunk))
}

/// As [`u16_at`].
pub(super) fn u32_at(bytes: &[u8], at: usize) -> u32 {
    bytes.get(at..).and_then(<[u8]>::first_chunk).map_or(0, |chunk| u32::from_le_bytes(*chunk))
}

/// As [`u16_at`].
pub(super) fn u64_at(bytes: &[u8], at: usize) -> u64 {
    bytes.get(at..).and_then(<[u8]>::first_chunk).map_or(0, |chunk| u64::from_le_bytes(*chunk))
}
