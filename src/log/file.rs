//! The MCAP file around the chunks: header, attachments and metadata before
//! the first message; summary, statistics and footer behind the last.
//!
//! Nothing here seeks, so a log may also go to a pipe.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Cursor, Write};
use std::path::Path;

use binrw::{BinWrite, BinWriterExt};
use mcap::MAGIC;
use mcap::records::{
    AttachmentHeader, AttachmentIndex, Channel, ChunkIndex, DataEnd, Footer, Header, Metadata, MetadataIndex,
    SchemaHeader, Statistics, SummaryOffset, op,
};

use super::channels::Channels;
use super::chunk::{PREFIX_LEN, Sealed};

/// An MCAP file being written.
pub(super) struct LogFile {
    file: File,
    /// Bytes written; always the end of a whole record.
    len: u64,
    data_crc: crc32fast::Hasher,
    statistics: Statistics,
    chunks: Vec<ChunkIndex>,
    attachments: Vec<AttachmentIndex>,
    metadata: Vec<MetadataIndex>,
}

impl LogFile {
    /// Makes or empties the file and writes its header.
    pub fn create(path: &Path) -> io::Result<Self> {
        let mut log = Self {
            file: File::create(path)?,
            len: 0,
            data_crc: crc32fast::Hasher::new(),
            statistics: Statistics::default(),
            chunks: Vec::new(),
            attachments: Vec::new(),
            metadata: Vec::new(),
        };
        let mut start = MAGIC.to_vec();
        let library = concat!("canloop ", env!("CARGO_PKG_VERSION")).to_owned();
        put_record(&mut start, op::HEADER, &Header { profile: String::new(), library });
        log.append(&start)?;
        Ok(log)
    }

    /// Bytes written.
    pub fn len(&self) -> u64 {
        self.len
    }

    /// Writes a file into the file. Its times are zero: a clock's would make
    /// the same run give other bytes.
    pub fn attachment(&mut self, name: &str, media_type: &str, data: &[u8]) -> io::Result<()> {
        let mut record = Vec::new();
        let (name, media_type) = (name.to_owned(), media_type.to_owned());
        let header = AttachmentHeader { log_time: 0, create_time: 0, name, media_type };
        put_record(&mut record, op::ATTACHMENT, &header);
        record.extend_from_slice(&(data.len() as u64).to_le_bytes());
        record.extend_from_slice(data);
        // The checksum is of everything in the record so far.
        let crc = crc32fast::hash(&record[PREFIX_LEN..]);
        record.extend_from_slice(&crc.to_le_bytes());
        put_len(&mut record);
        self.attachments.push(AttachmentIndex {
            offset: self.len,
            length: record.len() as u64,
            log_time: 0,
            create_time: 0,
            data_size: data.len() as u64,
            name: header.name,
            media_type: header.media_type,
        });
        self.statistics.attachment_count += 1;
        self.append(&record)
    }

    /// Writes key and value pairs under `name`.
    pub fn metadata(&mut self, name: &str, pairs: &BTreeMap<String, String>) -> io::Result<()> {
        let mut record = Vec::new();
        put_record(&mut record, op::METADATA, &Metadata { name: name.to_owned(), metadata: pairs.clone() });
        let length = record.len() as u64;
        self.metadata.push(MetadataIndex { offset: self.len, length, name: name.to_owned() });
        self.statistics.metadata_count += 1;
        self.append(&record)
    }

    /// Writes a chunk with its message indexes.
    pub fn chunk(&mut self, sealed: Sealed<'_>) -> io::Result<()> {
        let mut index = sealed.index;
        let start = self.len;
        self.append(sealed.bytes)?;
        index.chunk_start_offset = start;
        index.message_index_offsets.values_mut().for_each(|offset| *offset += start);
        let all = &mut self.statistics;
        let first = all.chunk_count == 0;
        all.message_start_time =
            if first { index.message_start_time } else { all.message_start_time.min(index.message_start_time) };
        all.message_end_time = all.message_end_time.max(index.message_end_time);
        all.chunk_count += 1;
        self.chunks.push(index);
        Ok(())
    }

    /// Ends the file: says what it holds and how many events it does not.
    /// Returns the number of messages.
    pub fn end(&mut self, channels: &Channels, events_lost: u64) -> io::Result<u64> {
        let counts = channels.counts();
        let messages = counts.values().sum();
        // Only what the events decide: the same run must give the same bytes.
        let numbers = [("messages", messages), ("events_lost", events_lost)];
        let numbers = numbers.map(|(name, number)| (name.to_owned(), number.to_string()));
        let (schemas, channels) = (channels.schemas_written(), channels.channels_written());
        self.metadata("canloop.log", &BTreeMap::from(numbers))
            .and_then(|()| self.finish(&schemas, &channels, counts))
            .inspect_err(|_| self.cut_to_whole_records())?;
        Ok(messages)
    }

    /// Ends the file: `schemas` and `channels` are records as the chunks have
    /// them, `counts` is messages by channel id.
    fn finish(&mut self, schemas: &[&[u8]], channels: &[&[u8]], counts: BTreeMap<u16, u64>) -> io::Result<()> {
        self.statistics.schema_count = schemas.len() as u16;
        self.statistics.channel_count = channels.len() as u32;
        self.statistics.message_count = counts.values().sum();
        self.statistics.channel_message_counts = counts;

        let mut data_end = Vec::new();
        let data_section_crc = self.data_crc.clone().finalize();
        put_record(&mut data_end, op::DATA_END, &DataEnd { data_section_crc });
        self.append(&data_end)?;
        let summary = self.summary(schemas, channels);
        self.append(&summary)?;
        self.file.flush()
    }

    /// After a failed write: takes back what it left of a record, so that the
    /// file ends with a whole one. A pipe cannot, and need not.
    pub fn cut_to_whole_records(&mut self) {
        let _ = self.file.set_len(self.len);
    }

    /// Everything from behind the data section to the end of the file.
    fn summary(&self, schemas: &[&[u8]], channels: &[&[u8]]) -> Vec<u8> {
        let mut summary = Vec::new();
        let mut groups = Vec::new();
        let mut group = |summary: &mut Vec<u8>, opcode, put: &dyn Fn(&mut Vec<u8>)| {
            let start = summary.len();
            put(summary);
            if summary.len() > start {
                let (group_start, group_length) = (self.len + start as u64, (summary.len() - start) as u64);
                groups.push(SummaryOffset { group_opcode: opcode, group_start, group_length });
            }
        };
        group(&mut summary, op::SCHEMA, &|out| schemas.iter().for_each(|record| out.extend_from_slice(record)));
        group(&mut summary, op::CHANNEL, &|out| channels.iter().for_each(|record| out.extend_from_slice(record)));
        group(&mut summary, op::STATISTICS, &|out| put_record(out, op::STATISTICS, &self.statistics));
        group(&mut summary, op::CHUNK_INDEX, &|out| put_all(out, op::CHUNK_INDEX, &self.chunks));
        group(&mut summary, op::ATTACHMENT_INDEX, &|out| put_all(out, op::ATTACHMENT_INDEX, &self.attachments));
        group(&mut summary, op::METADATA_INDEX, &|out| put_all(out, op::METADATA_INDEX, &self.metadata));

        let summary_offset_start = self.len + summary.len() as u64;
        put_all(&mut summary, op::SUMMARY_OFFSET, &groups);
        let footer = Footer { summary_start: self.len, summary_offset_start, summary_crc: 0 };
        put_record(&mut summary, op::FOOTER, &footer);
        // The checksum is of everything up to itself, which ends the footer.
        summary.truncate(summary.len() - 4);
        let crc = crc32fast::hash(&summary);
        summary.extend_from_slice(&crc.to_le_bytes());
        summary.extend_from_slice(MAGIC);
        summary
    }

    fn append(&mut self, records: &[u8]) -> io::Result<()> {
        self.file.write_all(records)?;
        self.data_crc.update(records);
        self.len += records.len() as u64;
        Ok(())
    }
}

/// A Schema record.
pub(super) fn schema_record(id: u16, name: &str, encoding: &str, data: &[u8]) -> Vec<u8> {
    let mut record = Vec::new();
    let header = SchemaHeader { id, name: name.to_owned(), encoding: encoding.to_owned() };
    put_record(&mut record, op::SCHEMA, &header);
    record.extend_from_slice(&(data.len() as u32).to_le_bytes());
    record.extend_from_slice(data);
    put_len(&mut record);
    record
}

/// A Channel record.
pub(super) fn channel_record(channel: &Channel) -> Vec<u8> {
    let mut record = Vec::new();
    put_record(&mut record, op::CHANNEL, channel);
    record
}

fn put_all<R>(out: &mut Vec<u8>, opcode: u8, records: &[R])
where
    R: for<'a> BinWrite<Args<'a> = ()>,
{
    records.iter().for_each(|record| put_record(out, opcode, record));
}

/// Appends a record: opcode, length, body.
fn put_record<R>(out: &mut Vec<u8>, opcode: u8, body: &R)
where
    R: for<'a> BinWrite<Args<'a> = ()>,
{
    let mut record = vec![0; PREFIX_LEN];
    record[0] = opcode;
    let mut cursor = Cursor::new(&mut record);
    cursor.set_position(PREFIX_LEN as u64);
    cursor.write_le(body).expect("memory takes every byte");
    put_len(&mut record);
    out.append(&mut record);
}

/// Sets the length of the record that is all of `record`.
fn put_len(record: &mut [u8]) {
    let len = (record.len() - PREFIX_LEN) as u64;
    record[1..PREFIX_LEN].copy_from_slice(&len.to_le_bytes());
}
