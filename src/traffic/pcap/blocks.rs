//! The blocks of a file, one at a time, whichever of the two formats it has.

use std::io::{self, Read};

use pcap_parser::{
    Block, LegacyPcapBlock, PcapHeader, parse_block_be, parse_block_le, parse_pcap_frame, parse_pcap_frame_be,
    parse_pcap_header,
};

use crate::traffic::bytes::Window;

/// A block or packet longer than this holds no CAN frame, if it is one at all.
const LONGEST: usize = 1 << 20;
const PCAP_HEADER_BYTES: usize = 24;
const PCAP_PACKET_BYTES: usize = 16;
const PCAPNG_MARK: [u8; 4] = [0x0A, 0x0D, 0x0D, 0x0A];
/// In a section's header, in the order of bytes of the one who wrote it.
const BIG_ENDIAN: [u8; 4] = [0x1A, 0x2B, 0x3C, 0x4D];

/// Where we are in a file.
pub(super) struct Blocks<R> {
    pub file: Window<R>,
    kind: Kind,
}

enum Kind {
    Unknown,
    Pcap(PcapHeader),
    Pcapng { big_endian: bool },
}

/// What there is.
pub(super) enum Found<'b> {
    /// A packet of a `.pcap` file.
    Packet(LegacyPcapBlock<'b>, &'b PcapHeader),
    /// A block of a `.pcapng` file.
    Block(Block<'b>, bool),
    /// Something else, after which it may go on.
    Wrong(&'static str),
    /// Something else, after which nobody knows where it would go on.
    Hopeless(&'static str),
    End,
}

impl<R: Read> Blocks<R> {
    /// Those of `reader`.
    pub fn of(reader: R) -> Self {
        Self { file: Window::of(reader), kind: Kind::Unknown }
    }

    /// What is next and how long it is, to be taken off the window then.
    pub fn next(&mut self) -> io::Result<(usize, Found<'_>)> {
        if let Kind::Unknown = self.kind
            && let Some(problem) = self.begin()?
        {
            return Ok((0, Found::Hopeless(problem)));
        }
        match &mut self.kind {
            Kind::Pcap(header) => packet(&mut self.file, header),
            Kind::Pcapng { big_endian } => block(&mut self.file, big_endian),
            Kind::Unknown => Ok((0, Found::End)),
        }
    }

    fn begin(&mut self) -> io::Result<Option<&'static str>> {
        let there = self.file.fill(PCAP_HEADER_BYTES)?;
        if there.starts_with(&PCAPNG_MARK) {
            self.kind = Kind::Pcapng { big_endian: false };
            return Ok(None);
        }
        match parse_pcap_header(there) {
            Ok((_, header)) => {
                self.kind = Kind::Pcap(header);
                self.file.consume(PCAP_HEADER_BYTES);
                Ok(None)
            }
            Err(_) if there.len() < PCAP_HEADER_BYTES => Ok(Some("the file ends in its header")),
            Err(_) => Ok(Some("expected the header of a pcap or pcapng file")),
        }
    }
}

const LONG: &str = "a length that no packet has: nothing behind it can be read";
const ENDS: &str = "the file ends in the middle of this packet";

fn packet<'b, R: Read>(file: &'b mut Window<R>, header: &'b PcapHeader) -> io::Result<(usize, Found<'b>)> {
    let head = file.fill(PCAP_PACKET_BYTES)?;
    if head.is_empty() {
        return Ok((0, Found::End));
    }
    if head.len() < PCAP_PACKET_BYTES {
        return Ok((0, Found::Hopeless(ENDS)));
    }
    let len = number(&head[8..12], header.is_bigendian()) as usize;
    if len > LONGEST {
        return Ok((0, Found::Hopeless(LONG)));
    }
    let all = PCAP_PACKET_BYTES + len;
    let Some(bytes) = file.fill(all)?.get(..all) else { return Ok((0, Found::Hopeless(ENDS))) };
    let parsed = if header.is_bigendian() { parse_pcap_frame_be(bytes) } else { parse_pcap_frame(bytes) };
    Ok((all, parsed.map_or(Found::Wrong("expected a packet"), |(_, packet)| Found::Packet(packet, header))))
}

fn block<'b, R: Read>(file: &'b mut Window<R>, big_endian: &mut bool) -> io::Result<(usize, Found<'b>)> {
    let head = file.fill(12)?;
    if head.is_empty() {
        return Ok((0, Found::End));
    }
    if head.len() < 12 {
        return Ok((0, Found::Hopeless(ENDS)));
    }
    if head.starts_with(&PCAPNG_MARK) {
        *big_endian = head[8..12] == BIG_ENDIAN;
    }
    let len = number(&head[4..8], *big_endian) as usize;
    if !(12..=LONGEST).contains(&len) || !len.is_multiple_of(4) {
        return Ok((0, Found::Hopeless(LONG)));
    }
    let Some(bytes) = file.fill(len)?.get(..len) else { return Ok((0, Found::Hopeless(ENDS))) };
    if bytes[4..8] != bytes[len - 4..] {
        return Ok((len, Found::Wrong("the two lengths of a block differ: it is damaged")));
    }
    let parsed = if *big_endian { parse_block_be(bytes) } else { parse_block_le(bytes) };
    let big_endian = *big_endian;
    Ok((len, parsed.map_or(Found::Wrong("expected a block"), |(_, block)| Found::Block(block, big_endian))))
}

fn number(bytes: &[u8], big_endian: bool) -> u32 {
    let bytes = bytes.first_chunk().copied().unwrap_or_default();
    if big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
}
