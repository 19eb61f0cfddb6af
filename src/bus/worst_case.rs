//! How long a frame can be on the wire, whatever it carries.

use crate::frame::{CanId, FrameKind};

/// CRC delimiter, acknowledge slot and its delimiter, end of frame (7), and
/// the inter-frame space (3).
const TRAILER: u32 = 13;

/// Bit times that a frame with `len` bytes takes at most, to the end of the
/// inter-frame space: every stuff bit that can be is there.
///
/// As Davis, Burns, Bril and Lukkien, "Controller Area Network (CAN)
/// schedulability analysis", 2007, count them for classic frames; the same for
/// CAN FD, whose CRC field has its stuff bits in fixed places.
pub fn worst_case_frame_bits(id: CanId, len: usize, kind: FrameKind) -> u32 {
    let data = 8 * len as u32;
    match kind {
        FrameKind::Classic => stuffed(if id.is_extended() { 54 } else { 34 } + data) + TRAILER,
        FrameKind::Remote => stuffed(if id.is_extended() { 54 } else { 34 }) + TRAILER,
        FrameKind::Fd | FrameKind::FdBitRateSwitch => {
            let crc = 4 + if len <= 16 { 17 } else { 21 };
            stuffed(if id.is_extended() { 41 } else { 22 } + data) + crc + 1 + crc / 4 + TRAILER
        }
    }
}

/// So many bits with all stuff bits that they can need: one after the first
/// five, then one after every four, because a stuff bit counts itself.
const fn stuffed(bits: u32) -> u32 {
    bits + (bits - 1) / 4
}
