//! Frames of captures.

use std::collections::VecDeque;
use std::io::Read;

use pcap_parser::{Block, EnhancedPacketBlock, InterfaceDescriptionBlock, LegacyPcapBlock, OptionCode, PcapHeader};

use super::blocks::{Blocks, Found};
use super::packet::parse;
use super::{LINK_COOKED, LINK_COOKED_2, LINK_SOCKETCAN};
use crate::time::Instant;
use crate::traffic::{Buses, Content, Direction, Finding, Place, Reader, Record};

/// Interfaces of a section beyond these are those of a damaged file.
const MOST_INTERFACES: usize = 4096;
const NANOS_IN_S: i64 = 1_000_000_000;
/// Options of packets (`epb_flags`, `epb_dropcount`).
const FLAGS: u16 = 2;
const DROP_COUNT: u16 = 4;
/// In the flags: sent by us.
const OUTBOUND: u8 = 2;

/// Reads `.pcap` and `.pcapng`.
pub(in crate::traffic) struct PcapReader<R> {
    blocks: Blocks<R>,
    state: State,
    ended: bool,
}

/// What earlier blocks have said.
#[derive(Default)]
struct State {
    buses: Buses,
    interfaces: Vec<Interface>,
    /// Records that came of one packet.
    waiting: VecDeque<Result<Record, Finding>>,
    /// Packets that are no CAN.
    others: u64,
}

#[derive(Clone, Copy)]
struct Interface {
    link: u32,
    bus: u16,
    /// Stamps a second, as an exponent of 10, or of 2 if that is set.
    resolution: u8,
    offset_s: i64,
}

type Said = Result<(), &'static str>;

impl<R: Read> PcapReader<R> {
    /// Reads `reader`.
    pub fn new(reader: R) -> Self {
        Self { blocks: Blocks::of(reader), state: State::default(), ended: false }
    }

    fn step(&mut self) -> std::io::Result<()> {
        let offset = self.blocks.file.offset;
        let (len, found) = self.blocks.next()?;
        let state = &mut self.state;
        let said = match found {
            Found::Packet(packet, header) => state.packet(&packet, header),
            Found::Block(block, big_endian) => state.block(&block, big_endian),
            Found::Wrong(title) => Err(title),
            Found::Hopeless(title) => {
                self.ended = true;
                Err(title)
            }
            Found::End => {
                self.ended = true;
                Ok(())
            }
        };
        if let Err(title) = said {
            state.waiting.push_back(Err(Finding::error(Place::Byte(offset), title)));
        }
        if self.ended && state.others > 0 {
            let title = format!("{} packets are no CAN frames: they are left out", state.others);
            state.waiting.push_back(Err(Finding::warning(Place::Byte(0), title)));
        }
        self.blocks.file.consume(len);
        Ok(())
    }
}

impl State {
    fn packet(&mut self, packet: &LegacyPcapBlock<'_>, header: &PcapHeader) -> Said {
        let unit = if header.is_nanosecond_precision() { 1 } else { 1_000 };
        let nanos = i64::from(packet.ts_sec) * NANOS_IN_S + i64::from(packet.ts_usec) * unit;
        // The upper bits tell of check sequences.
        let link = header.network.0 as u32 & 0x03FF_FFFF;
        self.add(link, nanos, None, None, packet.data)
    }

    fn block(&mut self, block: &Block<'_>, big_endian: bool) -> Said {
        match block {
            Block::SectionHeader(_) => {
                self.interfaces.clear();
                Ok(())
            }
            Block::InterfaceDescription(interface) => self.interface(interface),
            Block::EnhancedPacket(packet) => self.enhanced(packet, big_endian),
            Block::SimplePacket(_) => Err("a packet without a stamp: it is left out"),
            _ => Ok(()),
        }
    }

    fn interface(&mut self, block: &InterfaceDescriptionBlock<'_>) -> Said {
        if self.interfaces.len() == MOST_INTERFACES {
            return Err("an interface too many");
        }
        let link = block.linktype.0 as u32;
        let is_can = matches!(link, LINK_SOCKETCAN | LINK_COOKED | LINK_COOKED_2);
        let too_many = |_| "a bus too many";
        let bus = match block.if_name() {
            Some(Ok(name)) if is_can => self.buses.index(name.trim_end_matches('\0')).map_err(too_many)?,
            _ if is_can => self.buses.numbered(self.interfaces.len() as u32 + 1).map_err(too_many)?,
            _ => 0,
        };
        self.interfaces.push(Interface { link, bus, resolution: block.if_tsresol, offset_s: block.if_tsoffset });
        Ok(())
    }

    fn enhanced(&mut self, packet: &EnhancedPacketBlock<'_>, big_endian: bool) -> Said {
        let interface = self.interfaces.get(packet.if_id as usize);
        let interface = *interface.ok_or("a packet of an interface that has not been described")?;
        let nanos = interface.nanos(u64::from(packet.ts_high) << 32 | u64::from(packet.ts_low));
        let option = |code| {
            let found = packet.options.iter().find(|option| option.code == OptionCode(code))?;
            found.as_bytes().ok()
        };
        let lowest = |bytes: &[u8]| if big_endian { bytes.last().copied() } else { bytes.first().copied() };
        let is_sent = option(FLAGS).and_then(lowest).is_some_and(|flags| flags & 3 == OUTBOUND);
        let dropped = option(DROP_COUNT).and_then(|bytes| bytes.first_chunk::<8>().copied());
        let dropped =
            dropped.map_or(0, |bytes| if big_endian { u64::from_be_bytes(bytes) } else { u64::from_le_bytes(bytes) });
        let data = packet.data.get(..packet.caplen as usize).ok_or("a packet has less data than it says")?;
        if dropped > 0 {
            let content = Content::Lost(u32::try_from(dropped).unwrap_or(u32::MAX));
            let at = Instant::from_nanos(nanos);
            self.waiting.push_back(Ok(Record { at, bus: interface.bus, direction: Direction::Received, content }));
        }
        self.add(interface.link, nanos, Some(interface.bus), is_sent.then_some(Direction::Sent), data)
    }

    fn add(&mut self, link: u32, nanos: i64, bus: Option<u16>, direction: Option<Direction>, data: &[u8]) -> Said {
        let Some((seen, content)) = parse(link, data)? else {
            self.others += 1;
            return Ok(());
        };
        let bus = match bus {
            Some(bus) => bus,
            None => self.buses.numbered(1).map_err(|_| "a bus too many")?,
        };
        let direction = direction.unwrap_or(seen);
        self.waiting.push_back(Ok(Record { at: Instant::from_nanos(nanos), bus, direction, content }));
        Ok(())
    }
}

impl Interface {
    fn nanos(&self, stamp: u64) -> i64 {
        let exponent = u32::from(self.resolution & 0x7F);
        let nanos = u128::from(stamp) * NANOS_IN_S as u128;
        let nanos = match self.resolution & 0x80 {
            0 => 10_u128.checked_pow(exponent).map_or(0, |unit| nanos / unit),
            _ => nanos.checked_shr(exponent).unwrap_or(0),
        };
        let offset = self.offset_s.saturating_mul(NANOS_IN_S);
        i64::try_from(nanos).unwrap_or(i64::MAX).saturating_add(offset)
    }
}

impl<R: Read> Iterator for PcapReader<R> {
    type Item = Result<Record, Finding>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(item) = self.state.waiting.pop_front() {
                return Some(item);
            }
            if self.ended {
                return None;
            }
            if let Err(error) = self.step() {
                self.ended = true;
                let place = Place::Byte(self.blocks.file.offset);
                return Some(Err(Finding::error(place, format!("cannot read on: {error}"))));
            }
        }
    }
}

impl<R: Read> Reader for PcapReader<R> {
    fn buses(&self) -> &Buses {
        &self.state.buses
    }
}
