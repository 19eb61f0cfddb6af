//! An MCAP chunk: first filled with records in their wire layout and with the
//! message indexes beside them, then sealed, that is, compressed. All buffers
//! are reused from chunk to chunk.
//!
//! This is the part of a log that must keep up with a simulation, so a message
//! costs two short copies and no allocation. The layouts are those of
//! <https://mcap.dev/spec>: Message, Chunk, Message Index; all little-endian.

use std::collections::BTreeMap;
use std::io::{self, Cursor};

use mcap::records::{ChunkIndex, MessageHeader, op};
use zstd::bulk::Compressor;
use zstd::zstd_safe::{CParameter, compress_bound};

/// Opcode and length, which begin every record.
pub(super) const PREFIX_LEN: usize = 1 + 8;
/// Prefix, channel, sequence, log time, publish time.
const MESSAGE_LEN: usize = PREFIX_LEN + 2 + 4 + 8 + 8;
/// Prefix, start, end, uncompressed size, CRC, "zstd" with its length, compressed size.
const CHUNK_LEN: usize = PREFIX_LEN + 8 + 8 + 8 + 4 + 4 + COMPRESSION.len() + 8;
const COMPRESSION: &str = "zstd";
/// A chunk is full when it holds this much before compression: small enough to
/// stay in the processor's cache, large enough to compress well.
const FULL_BYTES: usize = 512 * 1024;
/// Or when it spans this much time, so that a killed log ends shortly before.
const FULL_SPAN_NS: u64 = 1_000_000_000;

/// Chosen by measurement. Doubles with noise in their low bytes fill most of a
/// chunk, so that longer searches cost much and find little.
const ZSTD_LEVEL: i32 = -1;
/// Matches shorter than this are passed over: they save less than they cost.
const ZSTD_MIN_MATCH: u32 = 7;
/// A table of 16 KiB, which stays in the processor's first cache.
const ZSTD_HASH_LOG: u32 = 12;

/// A chunk being filled.
pub(super) struct Chunk {
    records: Vec<u8>,
    /// By channel id: (log time, offset into `records`) as on the wire.
    indexes: Vec<Vec<u8>>,
    /// Least and greatest log time of the messages, if there are any.
    span: Option<(u64, u64)>,
}

/// Turns chunks into bytes of a file.
pub(super) struct Sealer {
    compressor: Compressor<'static>,
    bytes: Vec<u8>,
}

/// A finished chunk and its message indexes, ready to be written in one piece.
pub(super) struct Sealed<'a> {
    /// The Chunk record and the Message Index records behind it.
    pub bytes: &'a [u8],
    /// What the summary says of it, with offsets relative to `bytes`.
    pub index: ChunkIndex,
}

impl Chunk {
    /// An empty chunk with room for channel ids below `channels`; there may be
    /// more later.
    pub fn new(channels: usize) -> Self {
        Self { records: Vec::new(), indexes: vec![Vec::new(); channels], span: None }
    }

    /// Whether it holds neither a message nor another record.
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// Whether it is time to write it.
    pub fn is_full(&self) -> bool {
        let span_ns = self.span.map_or(0, |(start, end)| end - start);
        self.records.len() >= FULL_BYTES || span_ns >= FULL_SPAN_NS
    }

    /// Forgets what it holds.
    pub fn clear(&mut self) {
        self.records.clear();
        self.indexes.iter_mut().for_each(Vec::clear);
        self.span = None;
    }

    /// Appends a whole record that is not a message: a schema or a channel.
    pub fn record(&mut self, record: &[u8]) {
        self.records.extend_from_slice(record);
    }

    /// Appends a message whose body `write` appends to the buffer it is given.
    pub fn message(&mut self, header: MessageHeader, write: impl FnOnce(&mut Vec<u8>)) {
        let offset = self.records.len();
        let mut head = [0; MESSAGE_LEN];
        head[0] = op::MESSAGE;
        head[9..11].copy_from_slice(&header.channel_id.to_le_bytes());
        head[11..15].copy_from_slice(&header.sequence.to_le_bytes());
        head[15..23].copy_from_slice(&header.log_time.to_le_bytes());
        head[23..31].copy_from_slice(&header.publish_time.to_le_bytes());
        self.records.extend_from_slice(&head);
        write(&mut self.records);
        let len = (self.records.len() - offset - PREFIX_LEN) as u64;
        self.records[offset + 1..offset + PREFIX_LEN].copy_from_slice(&len.to_le_bytes());

        let mut entry = [0; 16];
        entry[..8].copy_from_slice(&header.log_time.to_le_bytes());
        entry[8..].copy_from_slice(&(offset as u64).to_le_bytes());
        let channel = usize::from(header.channel_id);
        if channel >= self.indexes.len() {
            self.indexes.resize_with(channel + 1, Vec::new);
        }
        self.indexes[channel].extend_from_slice(&entry);
        let (start, end) = self.span.unwrap_or((header.log_time, header.log_time));
        self.span = Some((start.min(header.log_time), end.max(header.log_time)));
    }
}

impl Sealer {
    /// Ready for the first chunk.
    pub fn new() -> io::Result<Self> {
        let mut compressor = Compressor::new(ZSTD_LEVEL)?;
        compressor.set_parameter(CParameter::MinMatch(ZSTD_MIN_MATCH))?;
        compressor.set_parameter(CParameter::HashLog(ZSTD_HASH_LOG))?;
        Ok(Self { compressor, bytes: Vec::new() })
    }

    /// Compresses a chunk and leaves it empty.
    pub fn seal(&mut self, chunk: &mut Chunk) -> io::Result<Sealed<'_>> {
        let (start, end) = chunk.span.take().unwrap_or_default();
        let uncompressed_size = chunk.records.len() as u64;
        let compressed_size = self.compress(&chunk.records)?;
        let chunk_len = self.bytes.len();
        let mut head = Vec::with_capacity(CHUNK_LEN);
        head.push(op::CHUNK);
        head.extend_from_slice(&((chunk_len - PREFIX_LEN) as u64).to_le_bytes());
        head.extend_from_slice(&start.to_le_bytes());
        head.extend_from_slice(&end.to_le_bytes());
        head.extend_from_slice(&uncompressed_size.to_le_bytes());
        head.extend_from_slice(&crc32fast::hash(&chunk.records).to_le_bytes());
        head.extend_from_slice(&(COMPRESSION.len() as u32).to_le_bytes());
        head.extend_from_slice(COMPRESSION.as_bytes());
        head.extend_from_slice(&(compressed_size as u64).to_le_bytes());
        self.bytes[..CHUNK_LEN].copy_from_slice(&head);
        chunk.records.clear();

        let message_index_offsets = self.append_indexes(&mut chunk.indexes);
        let index = ChunkIndex {
            message_start_time: start,
            message_end_time: end,
            chunk_start_offset: 0,
            chunk_length: chunk_len as u64,
            message_index_offsets,
            message_index_length: (self.bytes.len() - chunk_len) as u64,
            compression: COMPRESSION.to_owned(),
            compressed_size: compressed_size as u64,
            uncompressed_size,
        };
        Ok(Sealed { bytes: &self.bytes, index })
    }

    /// Puts `records` compressed behind room for the chunk's head. Returns
    /// their compressed length.
    fn compress(&mut self, records: &[u8]) -> io::Result<usize> {
        self.bytes.clear();
        self.bytes.resize(CHUNK_LEN, 0);
        self.bytes.reserve(compress_bound(records.len()));
        let mut behind_head = Cursor::new(&mut self.bytes);
        behind_head.set_position(CHUNK_LEN as u64);
        self.compressor.compress_to_buffer(records, &mut behind_head)
    }

    /// Moves the message indexes behind the chunk. Returns where each is.
    fn append_indexes(&mut self, indexes: &mut [Vec<u8>]) -> BTreeMap<u16, u64> {
        let mut offsets = BTreeMap::new();
        for (channel, entries) in (0..).zip(indexes).filter(|(_, entries)| !entries.is_empty()) {
            let channel: u16 = channel;
            offsets.insert(channel, self.bytes.len() as u64);
            self.bytes.push(op::MESSAGE_INDEX);
            self.bytes.extend_from_slice(&((2 + 4 + entries.len()) as u64).to_le_bytes());
            self.bytes.extend_from_slice(&channel.to_le_bytes());
            self.bytes.extend_from_slice(&(entries.len() as u32).to_le_bytes());
            self.bytes.append(entries);
        }
        offsets
    }
}
