//! A log that was never ended, or was damaged, made into one that ordinary
//! readers open: all that is whole is copied, and its index written anew.

use std::collections::BTreeMap;
use std::io::{Seek, Write};

use mcap::records::{MessageHeader, Record, op};
use mcap::{Compression, McapError, McapResult, WriteOptions, Writer};

/// What became of a log.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Repaired {
    /// Messages kept.
    pub messages: u64,
    /// When the last of them was logged, ns.
    pub last_ns: Option<u64>,
    /// Parts that were left out: where they begin, in bytes, and what is wrong
    /// with them.
    pub damaged: Vec<(u64, String)>,
    /// Where the file breaks off, in bytes, if it was never ended.
    pub cut_at: Option<u64>,
}

/// Opcode and length.
const PREFIX_LEN: usize = 9;

/// What is whole and what is not of a log, without writing anything.
///
/// # Errors
/// It is no log at all.
pub fn examine(log: &[u8]) -> McapResult<Repaired> {
    walk(log, &mut Nowhere)
}

/// Copies all that is whole of `log` to `out`.
///
/// # Errors
/// It is no log at all, or `out` takes no more.
pub fn repair(log: &[u8], out: impl Write + Seek) -> McapResult<Repaired> {
    let options = WriteOptions::new()
        .compression(Some(Compression::Zstd))
        .compression_threads(0)
        .chunk_size(Some(512 * 1024))
        .library(concat!("canloop ", env!("CARGO_PKG_VERSION"), " repair"));
    let mut copy = Copy { writer: options.create(out)?, schemas: BTreeMap::new(), channels: BTreeMap::new() };
    let repaired = walk(log, &mut copy)?;
    copy.writer.finish()?;
    Ok(repaired)
}

impl Repaired {
    /// Whether there is nothing to repair.
    pub const fn is_whole(&self) -> bool {
        self.cut_at.is_none() && self.damaged.is_empty()
    }
}

/// Whoever is given the records of a log.
trait Records {
    fn record(&mut self, record: Record<'_>) -> McapResult<()>;
}

struct Nowhere;

impl Records for Nowhere {
    fn record(&mut self, _record: Record<'_>) -> McapResult<()> {
        Ok(())
    }
}

/// Writes records to another log, in which schemas and channels have other ids.
struct Copy<W: Write + Seek> {
    writer: Writer<W>,
    schemas: BTreeMap<u16, u16>,
    channels: BTreeMap<u16, u16>,
}

impl<W: Write + Seek> Records for Copy<W> {
    fn record(&mut self, record: Record<'_>) -> McapResult<()> {
        match record {
            Record::Schema { header, data } => {
                let id = self.writer.add_schema(&header.name, &header.encoding, &data)?;
                self.schemas.insert(header.id, id);
            }
            Record::Channel(channel) => {
                let schema = self.schemas.get(&channel.schema_id).copied().unwrap_or(0);
                let (topic, encoding) = (&channel.topic, &channel.message_encoding);
                let id = self.writer.add_channel(schema, topic, encoding, &channel.metadata)?;
                self.channels.insert(channel.id, id);
            }
            Record::Message { header, data } => {
                if let Some(&channel_id) = self.channels.get(&header.channel_id) {
                    self.writer.write_to_known_channel(&MessageHeader { channel_id, ..header }, &data)?;
                }
            }
            Record::Attachment { header, data, .. } => {
                let (log_time, create_time) = (header.log_time, header.create_time);
                let (name, media_type) = (header.name, header.media_type);
                self.writer.attach(&mcap::Attachment { log_time, create_time, name, media_type, data })?;
            }
            Record::Metadata(metadata) => self.writer.write_metadata(&metadata)?,
            _ => {}
        }
        Ok(())
    }
}

/// Gives every record that is whole to `records`, those of chunks one by one.
fn walk(log: &[u8], records: &mut impl Records) -> McapResult<Repaired> {
    let mut rest = log.strip_prefix(mcap::MAGIC).ok_or(McapError::BadMagic)?;
    let mut repaired = Repaired::default();
    loop {
        let offset = (log.len() - rest.len()) as u64;
        let whole = rest.split_first_chunk::<PREFIX_LEN>().and_then(|(prefix, behind)| {
            let [opcode, len @ ..] = *prefix;
            let len = usize::try_from(u64::from_le_bytes(len)).ok()?;
            Some((opcode, behind.get(..len)?, behind.get(len..)?))
        });
        let Some((opcode, body, behind)) = whole else {
            repaired.cut_at = Some(offset);
            return Ok(repaired);
        };
        rest = behind;
        match opcode {
            // What follows is made anew.
            op::DATA_END => {
                let is_ended = rest.ends_with(mcap::MAGIC);
                repaired.cut_at = if is_ended { None } else { Some((log.len() - rest.len()) as u64) };
                return Ok(repaired);
            }
            op::HEADER | op::MESSAGE_INDEX => {}
            _ => match records_of(opcode, body) {
                Ok(found) => found.into_iter().try_for_each(|record| {
                    repaired.note(&record);
                    records.record(record)
                })?,
                Err(error) => repaired.damaged.push((offset, error.to_string())),
            },
        }
    }
}

/// The record itself, or those of a chunk, once its checksum has been found right.
fn records_of(opcode: u8, body: &[u8]) -> McapResult<Vec<Record<'_>>> {
    match mcap::parse_record(opcode, body)? {
        Record::Chunk { header, data } => {
            let records = mcap::read::ChunkReader::new(header, data_of(body, &data))?;
            records.map(|record| record.map(Record::into_owned)).collect()
        }
        record => Ok(vec![record]),
    }
}

/// The chunk's compressed records, borrowed from the file where they are.
fn data_of<'b>(body: &'b [u8], data: &[u8]) -> &'b [u8] {
    &body[body.len() - data.len()..]
}

impl Repaired {
    fn note(&mut self, record: &Record<'_>) {
        if let Record::Message { header, .. } = record {
            self.messages += 1;
            self.last_ns = self.last_ns.max(Some(header.log_time));
        }
    }
}
