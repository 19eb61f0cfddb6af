//! As binlog and python-can write it: containers of 128 KiB, compressed.

use std::io::{self, Seek, SeekFrom, Write};

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::header::{HEADER_BYTES, Header};
use super::{MARK, OBJECT_BASE_BYTES, OBJECT_HEADER_BYTES, kind};
use crate::frame::FrameKind;
use crate::traffic::losses::{Loss, Losses};
use crate::traffic::numbering::Numbering;
use crate::traffic::socketcan::{EXTENDED, fd_flags, id_word};
use crate::traffic::{Buses, Content, Direction, Record, RecordedFrame, Writer};

/// Bytes in a container before compression.
const CONTAINER_BYTES: usize = 128 << 10;
const ONE_NANOSECOND: u32 = 2;
const SENT: u8 = 1;
const REMOTE: u8 = 0x80;
const FD_FORMAT: u8 = 1;
const MILLISECOND_NS: i64 = 1_000_000;

/// Writes `.blf`.
pub(in crate::traffic) struct BlfWriter<W> {
    out: W,
    header: Header,
    has_begun: bool,
    objects: Vec<u8>,
    body: Vec<u8>,
    numbering: Numbering,
    losses: Losses,
}

impl<W: Write + Seek> BlfWriter<W> {
    /// Writes to `out`: first a header, which is put right at the end.
    pub fn new(mut out: W) -> io::Result<Self> {
        let bytes = HEADER_BYTES as u64;
        let header = Header { len: bytes, file_bytes: bytes, inflated_bytes: bytes, ..Header::default() };
        out.write_all(&header.bytes())?;
        let (numbering, losses) = (Numbering::default(), Losses::default());
        Ok(Self { out, header, has_begun: false, objects: Vec::new(), body: Vec::new(), numbering, losses })
    }

    /// Nanoseconds since the measurement began, which has milliseconds.
    fn since_start(&mut self, nanos: i64) -> u64 {
        if !self.has_begun {
            self.has_begun = true;
            self.header.start_ns = nanos - nanos.rem_euclid(MILLISECOND_NS);
        }
        self.header.end_ns = nanos;
        u64::try_from(nanos.saturating_sub(self.header.start_ns)).unwrap_or_else(|_| {
            self.losses.note(Loss::EarlierStamps);
            0
        })
    }

    /// Says what the bus of a number is called.
    fn name(&mut self, number: u32, name: &str, time: u64) -> io::Result<()> {
        let mut text = format!(";{}", name.replace([';', '\0'], "_")).into_bytes();
        text.resize(text.len().next_multiple_of(4), 0);
        self.body.clear();
        // About a channel: version 1 of this, the channel, CAN.
        for word in [1, 1 | number << 8 | 1 << 16, text.len() as u32, 0] {
            self.body.extend_from_slice(&word.to_le_bytes());
        }
        self.body.append(&mut text);
        self.object(kind::APP_TEXT, time)
    }

    /// Appends an object with the body that has been made.
    fn object(&mut self, object_kind: u32, time: u64) -> io::Result<()> {
        let size = (OBJECT_HEADER_BYTES + self.body.len()) as u32;
        put_base(&mut self.objects, OBJECT_HEADER_BYTES as u16, size, object_kind);
        self.objects.extend_from_slice(&ONE_NANOSECOND.to_le_bytes());
        self.objects.extend_from_slice(&[0; 4]);
        self.objects.extend_from_slice(&time.to_le_bytes());
        self.objects.extend_from_slice(&self.body);
        self.header.objects += 1;
        if self.objects.len() >= CONTAINER_BYTES { self.container() } else { Ok(()) }
    }

    fn container(&mut self) -> io::Result<()> {
        if self.objects.is_empty() {
            return Ok(());
        }
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(&self.objects)?;
        let compressed = encoder.finish()?;
        let head = OBJECT_BASE_BYTES + 16;
        let mut out = Vec::with_capacity(head);
        put_base(&mut out, OBJECT_BASE_BYTES as u16, (head + compressed.len()) as u32, kind::CONTAINER);
        // The method, 2 for zlib, and the size before it.
        out.extend_from_slice(&[2, 0, 0, 0, 0, 0, 0, 0]);
        out.extend_from_slice(&(self.objects.len() as u32).to_le_bytes());
        out.extend_from_slice(&[0; 4]);
        // Vector fills up by the remainder, not to a multiple of four.
        let padding = (head + compressed.len()) % 4;
        self.out.write_all(&out)?;
        self.out.write_all(&compressed)?;
        self.out.write_all(&[0; 3][..padding])?;
        self.header.file_bytes += (head + compressed.len() + padding) as u64;
        self.header.inflated_bytes += (head + self.objects.len()) as u64;
        self.objects.clear();
        Ok(())
    }
}

impl<W: Write + Seek> Writer for BlfWriter<W> {
    fn put(&mut self, record: &Record, buses: &Buses) -> io::Result<()> {
        if matches!(record.content, Content::Lost(_)) {
            self.losses.note(Loss::LostCounts);
            return Ok(());
        }
        let time = self.since_start(record.at.as_nanos());
        let numbered = self.numbering.of(record.bus, buses);
        if numbered.is_news {
            self.name(numbered.number, buses.name(record.bus), time)?;
        }
        let number = numbered.number as u16;
        self.body.clear();
        self.body.extend_from_slice(&number.to_le_bytes());
        let object_kind = match &record.content {
            Content::Frame(recorded) if recorded.is_fd() => put_fd(&mut self.body, record, recorded),
            Content::Frame(recorded) => put_classic(&mut self.body, record, recorded),
            Content::Error(error) => {
                self.body.resize(10, 0);
                self.body.extend_from_slice(&[8, 0, 0, 0, 0, 0]);
                self.body.extend_from_slice(&id_word(&record.content).to_le_bytes());
                self.body.extend_from_slice(&[0; 4]);
                self.body.extend_from_slice(&error.data);
                kind::CAN_ERROR_EXT
            }
            Content::Lost(_) => return Ok(()),
        };
        self.object(object_kind, time)
    }

    fn finish(mut self: Box<Self>) -> io::Result<Losses> {
        self.container()?;
        self.out.seek(SeekFrom::Start(0))?;
        self.out.write_all(&self.header.bytes())?;
        self.out.flush()?;
        Ok(self.losses)
    }
}

fn put_base(out: &mut Vec<u8>, header_bytes: u16, size: u32, object_kind: u32) {
    out.extend_from_slice(MARK);
    out.extend_from_slice(&header_bytes.to_le_bytes());
    out.extend_from_slice(&1_u16.to_le_bytes());
    out.extend_from_slice(&size.to_le_bytes());
    out.extend_from_slice(&object_kind.to_le_bytes());
}

/// Flags, length code and id, behind the number of the bus.
fn put_head(body: &mut Vec<u8>, record: &Record, recorded: &RecordedFrame) {
    let sent = if record.direction == Direction::Sent { SENT } else { 0 };
    let remote = if recorded.frame.kind == FrameKind::Remote { REMOTE } else { 0 };
    let id = recorded.frame.id;
    let extended = if id.is_extended() { EXTENDED } else { 0 };
    body.extend_from_slice(&[sent | remote, recorded.dlc()]);
    body.extend_from_slice(&(id.raw() | extended).to_le_bytes());
}

fn put_classic(body: &mut Vec<u8>, record: &Record, recorded: &RecordedFrame) -> u32 {
    put_head(body, record, recorded);
    body.extend_from_slice(&recorded.frame.storage()[..8]);
    kind::CAN_MESSAGE
}

fn put_fd(body: &mut Vec<u8>, record: &Record, recorded: &RecordedFrame) -> u32 {
    put_head(body, record, recorded);
    let flags = FD_FORMAT | fd_flags(recorded) << 1;
    body.extend_from_slice(&[0, 0, 0, 0, 0, flags, recorded.frame.len() as u8, 0, 0, 0, 0, 0]);
    body.extend_from_slice(recorded.frame.storage());
    kind::CAN_FD_MESSAGE
}
