//! Both formats, little-endian, with nanoseconds.

use std::io::{self, Write};

use super::LINK_SOCKETCAN;
use super::packet::{FD_BYTES, put};
use crate::traffic::losses::{Loss, Losses};
use crate::traffic::{Buses, Content, Direction, Record, Writer};

const NANOS_IN_S: i64 = 1_000_000_000;
/// Bytes that are captured of a packet at most, which is all.
const SNAP_LENGTH: u32 = FD_BYTES as u32;

/// Writes `.pcap`, which knows neither buses nor directions.
pub(in crate::traffic) struct PcapWriter<W> {
    out: W,
    has_begun: bool,
    packet: Vec<u8>,
    only_bus: Option<u16>,
    losses: Losses,
}

impl<W: Write> PcapWriter<W> {
    /// Writes to `out`.
    pub fn new(out: W) -> Self {
        Self { out, has_begun: false, packet: Vec::new(), only_bus: None, losses: Losses::default() }
    }

    fn begin(&mut self) -> io::Result<()> {
        if std::mem::replace(&mut self.has_begun, true) {
            return Ok(());
        }
        // Magic number for nanoseconds, version 2.4, no zone.
        let words = [0xA1B2_3C4D, 2 | 4 << 16, 0, 0, SNAP_LENGTH, LINK_SOCKETCAN];
        words.iter().try_for_each(|word: &u32| self.out.write_all(&word.to_le_bytes()))
    }
}

impl<W: Write> Writer for PcapWriter<W> {
    fn put(&mut self, record: &Record, buses: &Buses) -> io::Result<()> {
        if matches!(record.content, Content::Lost(_)) {
            self.losses.note(Loss::LostCounts);
            return Ok(());
        }
        self.begin()?;
        if *self.only_bus.get_or_insert(record.bus) != record.bus {
            self.losses.note(Loss::Buses);
        } else if buses.name(record.bus) != "can0" {
            self.losses.note(Loss::BusNames);
        }
        if record.direction == Direction::Sent {
            self.losses.note(Loss::Directions);
        }
        let nanos = record.at.as_nanos();
        let seconds = u32::try_from(nanos.div_euclid(NANOS_IN_S)).unwrap_or_else(|_| {
            self.losses.note(Loss::EarlierStamps);
            0
        });
        self.packet.clear();
        put(&mut self.packet, &record.content);
        let len = self.packet.len() as u32;
        for word in [seconds, nanos.rem_euclid(NANOS_IN_S) as u32, len, len] {
            self.out.write_all(&word.to_le_bytes())?;
        }
        self.out.write_all(&self.packet)
    }

    fn finish(mut self: Box<Self>) -> io::Result<Losses> {
        self.begin()?;
        self.out.flush()?;
        Ok(self.losses)
    }
}

/// Types of blocks.
const SECTION: u32 = 0x0A0D_0D0A;
const INTERFACE: u32 = 1;
const PACKET: u32 = 6;
/// Options: name and resolution of an interface, flags of a packet.
const NAME: u16 = 2;
const RESOLUTION: u16 = 9;
const FLAGS: u16 = 2;
const INBOUND: u32 = 1;
const OUTBOUND: u32 = 2;
/// Stamps are in nanoseconds.
const NANOSECONDS: u8 = 9;

/// Writes `.pcapng`, an interface for each bus.
pub(in crate::traffic) struct PcapngWriter<W> {
    out: W,
    body: Vec<u8>,
    has_begun: bool,
    /// The number of each bus's interface.
    interfaces: Vec<Option<u32>>,
    count: u32,
    losses: Losses,
}

impl<W: Write> PcapngWriter<W> {
    /// Writes to `out`.
    pub fn new(out: W) -> Self {
        let losses = Losses::default();
        Self { out, body: Vec::new(), has_begun: false, interfaces: Vec::new(), count: 0, losses }
    }

    /// Writes a block of what is in the body.
    fn block(&mut self, kind: u32) -> io::Result<()> {
        let len = (12 + self.body.len()) as u32;
        self.out.write_all(&kind.to_le_bytes())?;
        self.out.write_all(&len.to_le_bytes())?;
        self.out.write_all(&self.body)?;
        self.body.clear();
        self.out.write_all(&len.to_le_bytes())
    }

    fn begin(&mut self) -> io::Result<()> {
        if std::mem::replace(&mut self.has_begun, true) {
            return Ok(());
        }
        // The order of bytes, version 1.0, of unknown length.
        self.body.extend_from_slice(&0x1A2B_3C4D_u32.to_le_bytes());
        self.body.extend_from_slice(&[1, 0, 0, 0]);
        self.body.extend_from_slice(&[0xFF; 8]);
        self.block(SECTION)
    }

    fn interface(&mut self, bus: u16, buses: &Buses) -> io::Result<u32> {
        let index = usize::from(bus);
        if let Some(&Some(known)) = self.interfaces.get(index) {
            return Ok(known);
        }
        self.body.extend_from_slice(&LINK_SOCKETCAN.to_le_bytes());
        self.body.extend_from_slice(&SNAP_LENGTH.to_le_bytes());
        option(&mut self.body, NAME, buses.name(bus).as_bytes());
        option(&mut self.body, RESOLUTION, &[NANOSECONDS]);
        option(&mut self.body, 0, &[]);
        self.block(INTERFACE)?;
        let number = self.count;
        self.count += 1;
        self.interfaces.resize(self.interfaces.len().max(index + 1), None);
        self.interfaces[index] = Some(number);
        Ok(number)
    }
}

impl<W: Write> Writer for PcapngWriter<W> {
    fn put(&mut self, record: &Record, buses: &Buses) -> io::Result<()> {
        if matches!(record.content, Content::Lost(_)) {
            self.losses.note(Loss::LostCounts);
            return Ok(());
        }
        self.begin()?;
        let interface = self.interface(record.bus, buses)?;
        let nanos = u64::try_from(record.at.as_nanos()).unwrap_or_else(|_| {
            self.losses.note(Loss::EarlierStamps);
            0
        });
        let body = &mut self.body;
        body.extend_from_slice(&interface.to_le_bytes());
        body.extend_from_slice(&((nanos >> 32) as u32).to_le_bytes());
        body.extend_from_slice(&(nanos as u32).to_le_bytes());
        // Captured and real length, put right when they are known.
        let lengths = body.len();
        body.extend_from_slice(&[0; 8]);
        put(body, &record.content);
        let len = ((body.len() - lengths - 8) as u32).to_le_bytes();
        body[lengths..lengths + 4].copy_from_slice(&len);
        body[lengths + 4..lengths + 8].copy_from_slice(&len);
        let direction = if record.direction == Direction::Sent { OUTBOUND } else { INBOUND };
        option(body, FLAGS, &direction.to_le_bytes());
        option(body, 0, &[]);
        self.block(PACKET)
    }

    fn finish(mut self: Box<Self>) -> io::Result<Losses> {
        self.begin()?;
        self.out.flush()?;
        Ok(self.losses)
    }
}

fn option(out: &mut Vec<u8>, code: u16, value: &[u8]) {
    out.extend_from_slice(&code.to_le_bytes());
    out.extend_from_slice(&(value.len() as u16).to_le_bytes());
    out.extend_from_slice(value);
    out.resize(out.len().next_multiple_of(4), 0);
}
