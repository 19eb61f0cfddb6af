//! How long a frame occupies the wire, to the bit.
//!
//! A transmitter inserts a bit of opposite level after five equal ones
//! (ISO 11898-1:2015, 10.5), so the length depends on every bit of the frame,
//! the CRC among them. Tables take a byte at a time.

use crate::frame::{CanId, Frame, FrameKind};

/// CRC delimiter, acknowledge slot and its delimiter, end of frame (7), and
/// the inter-frame space (3) that must pass before the next frame.
const TRAILER: u32 = 1 + 1 + 1 + 7 + 3;

/// Remainders of CRC-15, polynomial 0x4599.
const CRC15: [u16; 256] = crc15_table();
/// By run and byte: how many bits to insert, and the run after them.
const STUFFING: [[Step; 256]; 8] = stuffing_table();

/// Bit times from start of frame to the end of the inter-frame space.
///
/// Of CAN FD frames that switch rates, [`data_phase_bits`] tells how many of
/// them are sent at the data rate. A remote request carries no data, whatever
/// its length says.
pub fn frame_bits(frame: &Frame) -> u32 {
    match frame.kind {
        FrameKind::Classic => classic_bits(frame, frame.payload()),
        FrameKind::Remote => classic_bits(frame, &[]),
        FrameKind::Fd | FrameKind::FdBitRateSwitch => fd_bits(frame),
    }
}

/// Those of [`frame_bits`] that are sent at the data rate: from after the BRS
/// bit to the CRC delimiter; 0 for a frame without rate switch. The rate
/// really changes at the sample points of these two bits; taking the first as
/// slow and the last as fast gives the same time when both rates sample at
/// the same fraction of a bit.
pub fn data_phase_bits(frame: &Frame) -> u32 {
    if frame.kind != FrameKind::FdBitRateSwitch {
        return 0;
    }
    // After BRS come ESI and the length code.
    let whole = Header::fd(frame);
    let slow = Header { bits: whole.bits >> 5, width: whole.width - 5 };
    let mut stuffer = Stuffer::new();
    stuffer.header(&slow);
    frame_bits(frame) - slow.width - stuffer.inserted - (TRAILER - 1)
}

fn classic_bits(frame: &Frame, data: &[u8]) -> u32 {
    let header = Header::classic(frame);
    let mut crc = header.crc15();
    let mut stuffer = Stuffer::new();
    stuffer.header(&header);
    for &byte in data {
        crc = crc15(crc, byte);
        stuffer.byte(byte);
    }
    // One bit more makes the CRC two bytes; opposite to the CRC's last it ends
    // every run and has nothing inserted after it.
    stuffer.bytes(&(crc << 1 | !crc & 1).to_be_bytes());
    header.width + 8 * data.len() as u32 + 15 + stuffer.inserted + TRAILER
}

fn fd_bits(frame: &Frame) -> u32 {
    let header = Header::fd(frame);
    let mut stuffer = Stuffer::new();
    stuffer.header(&header);
    stuffer.bytes(frame.payload());
    // After five equal bits at the very end none is inserted, because the
    // fixed stuff bit of the CRC field comes there anyway.
    let last_bit = frame.payload().last().map_or(header.bits & 1 != 0, |byte| byte & 1 != 0);
    let inserted = stuffer.inserted - u32::from(stuffer.run.level() != last_bit);
    // Stuff count (4), CRC-17 or CRC-21; one fixed stuff bit before them and
    // one after every fourth bit of them.
    let crc_field = 4 + if frame.len() <= 16 { 17 } else { 21 };
    header.width + 8 * frame.len() as u32 + inserted + crc_field + 1 + crc_field / 4 + TRAILER
}

/// The part of a frame before its data, first bit highest.
struct Header {
    bits: u64,
    width: u32,
}

impl Header {
    /// Start of frame, identifier, RTR, IDE, reserved bits, length code.
    fn classic(frame: &Frame) -> Self {
        let remote = u64::from(frame.kind == FrameKind::Remote);
        let length = frame.len().min(8) as u64;
        match frame.id {
            CanId::Standard(id) => Self { bits: (u64::from(id) & 0x7FF) << 7 | remote << 6 | length, width: 19 },
            CanId::Extended(id) => Self { bits: extended_id(id) << 7 | remote << 6 | length, width: 39 },
        }
    }

    /// Start of frame, identifier, RRS, IDE, FDF, reserved, BRS, ESI (error
    /// active), length code.
    fn fd(frame: &Frame) -> Self {
        let switch = u64::from(frame.kind == FrameKind::FdBitRateSwitch);
        let format_and_length = 1 << 7 | switch << 5 | fd_length_code(frame.len());
        match frame.id {
            CanId::Standard(id) => Self { bits: (u64::from(id) & 0x7FF) << 10 | format_and_length, width: 22 },
            CanId::Extended(id) => Self { bits: extended_id(id) << 9 | format_and_length, width: 41 },
        }
    }

    fn crc15(&self) -> u16 {
        // Leading zeros leave the remainder 0.
        let bytes = self.bits.to_be_bytes();
        bytes[8 - self.byte_count()..].iter().fold(0, |crc, &byte| crc15(crc, byte))
    }

    fn byte_count(&self) -> usize {
        self.width.div_ceil(8) as usize
    }
}

/// Start of frame, 11 bits of the id, SRR and IDE recessive, 18 bits.
fn extended_id(id: u32) -> u64 {
    let id = u64::from(id);
    (id >> 18 & 0x7FF) << 20 | 0b11 << 18 | id & 0x3_FFFF
}

fn fd_length_code(len: usize) -> u64 {
    match len {
        0..=8 => len as u64,
        9..=24 => (len as u64).div_ceil(4) + 6,
        _ => (len as u64).div_ceil(16) + 11,
    }
}

fn crc15(crc: u16, byte: u8) -> u16 {
    (crc << 8 ^ CRC15[usize::from(crc >> 7 ^ u16::from(byte))]) & 0x7FFF
}

/// Sends bits and counts those that it has to insert.
struct Stuffer {
    run: Run,
    inserted: u32,
}

impl Stuffer {
    const fn new() -> Self {
        Self { run: Run::new(true, 1), inserted: 0 }
    }

    /// Sends a header from an idle, that is recessive, bus. Alternating bits
    /// fill it up to whole bytes and have nothing inserted.
    fn header(&mut self, header: &Header) {
        let filling = 8 * header.byte_count() as u32 - header.width;
        let bits = (0x55 & ((1 << filling) - 1)) << header.width | header.bits;
        self.bytes(&bits.to_be_bytes()[8 - header.byte_count()..]);
    }

    fn bytes(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.byte(byte));
    }

    #[inline]
    fn byte(&mut self, byte: u8) {
        let step = STUFFING[usize::from(self.run.0)][usize::from(byte)];
        self.inserted += step.inserted();
        self.run = step.run();
    }
}

/// The run of 1 to 4 equal bits sent last: its level in bit 2, its length
/// less 1 in bits 1 and 0. A fifth bit is answered with the opposite one, so
/// there are no longer runs.
#[derive(Clone, Copy)]
struct Run(u8);

/// How many bits are inserted, in bits 4 and 3, and the run after them below:
/// in one byte, so that the table stays small beside all else that a loop needs.
#[derive(Clone, Copy)]
struct Step(u8);

impl Run {
    const fn new(recessive: bool, length: u8) -> Self {
        Self((recessive as u8) << 2 | (length - 1))
    }

    const fn level(self) -> bool {
        self.0 & 4 != 0
    }

    const fn length(self) -> u8 {
        (self.0 & 3) + 1
    }

    const fn send(self, recessive: bool) -> Step {
        if recessive != self.level() {
            Step::new(0, Self::new(recessive, 1))
        } else if self.length() == 4 {
            Step::new(1, Self::new(!recessive, 1))
        } else {
            Step::new(0, Self::new(recessive, self.length() + 1))
        }
    }
}

impl Step {
    const fn new(inserted: u8, run: Run) -> Self {
        Self(inserted << 3 | run.0)
    }

    const fn inserted(self) -> u32 {
        self.0 as u32 >> 3
    }

    const fn run(self) -> Run {
        Run(self.0 & 7)
    }
}

const fn stuffing_table() -> [[Step; 256]; 8] {
    let mut table = [[Step(0); 256]; 8];
    let mut run = 0;
    while run < 8 {
        let mut byte = 0;
        while byte < 256 {
            let mut sum = Step::new(0, Run(run as u8));
            let mut bit = 8;
            while bit > 0 {
                bit -= 1;
                let step = sum.run().send(byte >> bit & 1 != 0);
                sum = Step::new((sum.inserted() + step.inserted()) as u8, step.run());
            }
            table[run][byte] = sum;
            byte += 1;
        }
        run += 1;
    }
    table
}

const fn crc15_table() -> [u16; 256] {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = (byte as u16) << 7;
        let mut bit = 0;
        while bit < 8 {
            crc = crc << 1 ^ if crc & 0x4000 != 0 { 0x4599 } else { 0 };
            bit += 1;
        }
        table[byte] = crc & 0x7FFF;
        byte += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_check_value_of_the_catalogue_comes_out() {
        // CRC-15/CAN in the catalogue of parametrised CRC algorithms.
        assert_eq!(b"123456789".iter().fold(0, |crc, &byte| crc15(crc, byte)), 0x059E);
    }

    #[test]
    fn fd_lengths_have_the_codes_of_the_standard() {
        let lengths = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];
        assert!(lengths.into_iter().enumerate().all(|(code, len)| fd_length_code(len) == code as u64));
    }
}
