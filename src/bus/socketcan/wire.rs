//! `struct can_frame` and `struct canfd_frame` (`linux/can.h`), which raw CAN
//! sockets carry, to frames and back.

use crate::frame::{CanId, Frame, FrameKind};
use crate::traffic::RecordedFrame;

/// Bytes of a `struct can_frame`.
const CLASSIC_BYTES: usize = 16;
/// Bytes of a `struct canfd_frame`.
pub(super) const FD_BYTES: usize = 72;

const EXTENDED_FLAG: u32 = 0x8000_0000;
const REMOTE_FLAG: u32 = 0x4000_0000;
const ERROR_FLAG: u32 = 0x2000_0000;
const EXTENDED_MASK: u32 = 0x1FFF_FFFF;
const STANDARD_MASK: u32 = 0x7FF;
const BIT_RATE_SWITCH: u8 = 0x01;
const ERROR_PASSIVE: u8 = 0x02;

const LEN_AT: usize = 4;
const FLAGS_AT: usize = 5;
/// The length code of a classic frame of 8 bytes, where it is above 8.
const LENGTH_CODE_AT: usize = 7;
const DATA_AT: usize = 8;

/// What a raw CAN socket hands over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Received {
    Frame(RecordedFrame),
    /// A message of the driver in the shape of a frame: class bits and data
    /// (`linux/can/error.h`).
    Error(u32, [u8; 8]),
}

/// A frame as a raw CAN socket takes it.
pub(super) struct Outgoing {
    bytes: [u8; FD_BYTES],
    len: usize,
}

impl Outgoing {
    pub(super) fn new(frame: &Frame) -> Self {
        let is_fd = is_fd(frame);
        let mut bytes = [0; FD_BYTES];
        let remote = if frame.kind == FrameKind::Remote { REMOTE_FLAG } else { 0 };
        bytes[..LEN_AT].copy_from_slice(&(kernel_id(frame.id) | remote).to_ne_bytes());
        bytes[LEN_AT] = frame.len() as u8;
        if frame.kind == FrameKind::FdBitRateSwitch {
            bytes[FLAGS_AT] = BIT_RATE_SWITCH;
        }
        bytes[DATA_AT..DATA_AT + frame.len()].copy_from_slice(frame.payload());
        Self { bytes, len: if is_fd { FD_BYTES } else { CLASSIC_BYTES } }
    }

    pub(super) fn as_bytes(&self) -> &[u8] {
        &self.bytes[..self.len]
    }
}

/// Whether only a CAN FD bus carries it.
pub(super) fn is_fd(frame: &Frame) -> bool {
    matches!(frame.kind, FrameKind::Fd | FrameKind::FdBitRateSwitch)
}

/// An id with the flag that marks 29 bits.
pub(super) fn kernel_id(id: CanId) -> u32 {
    if id.is_extended() { id.raw() | EXTENDED_FLAG } else { id.raw() }
}

/// The bits that tell one id from all others, to filter by.
pub(super) fn kernel_id_mask(id: CanId) -> u32 {
    EXTENDED_FLAG | if id.is_extended() { EXTENDED_MASK } else { STANDARD_MASK }
}

/// Reads what a socket gave; `None` when it is of a kind that nobody asked for.
pub(super) fn read(bytes: &[u8]) -> Option<Received> {
    let is_fd = match bytes.len() {
        CLASSIC_BYTES => false,
        FD_BYTES => true,
        _ => return None,
    };
    let word = u32::from_ne_bytes(*bytes.first_chunk()?);
    let data = &bytes[DATA_AT..];
    if word & ERROR_FLAG != 0 {
        return Some(Received::Error(word & EXTENDED_MASK, *data.first_chunk()?));
    }
    let id = match word & EXTENDED_FLAG {
        0 => CanId::Standard((word & STANDARD_MASK) as u16),
        _ => CanId::Extended(word & EXTENDED_MASK),
    };
    let mut frame = Frame::zeroed(id, usize::from(bytes[LEN_AT]).min(data.len()));
    frame.kind = match is_fd {
        true if bytes[FLAGS_AT] & BIT_RATE_SWITCH != 0 => FrameKind::FdBitRateSwitch,
        true => FrameKind::Fd,
        false if word & REMOTE_FLAG != 0 => FrameKind::Remote,
        false => FrameKind::Classic,
    };
    if frame.kind != FrameKind::Remote {
        let len = frame.len();
        frame.payload_mut().copy_from_slice(&data[..len]);
    }
    let error_passive = is_fd && bytes[FLAGS_AT] & ERROR_PASSIVE != 0;
    let has_code = !is_fd && bytes[LEN_AT] == 8 && (9..=15).contains(&bytes[LENGTH_CODE_AT]);
    let dlc_above_8 = has_code.then_some(bytes[LENGTH_CODE_AT]);
    Some(Received::Frame(RecordedFrame { frame, error_passive, dlc_above_8 }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn there_and_back(frame: Frame) -> Option<Received> {
        read(Outgoing::new(&frame).as_bytes())
    }

    #[test]
    fn a_frame_of_each_kind_comes_back_as_it_was() {
        for kind in [FrameKind::Classic, FrameKind::Remote, FrameKind::Fd, FrameKind::FdBitRateSwitch] {
            for id in [CanId::Standard(0), CanId::Standard(0x7FF), CanId::Extended(0x7FF), CanId::Extended(0x1FFF_FFFF)]
            {
                let mut frame = Frame::zeroed(id, 8);
                frame.kind = kind;
                if kind != FrameKind::Remote {
                    frame.payload_mut().copy_from_slice(&[1, 2, 3, 4, 5, 6, 7, 0xFF]);
                }
                assert_eq!(there_and_back(frame), Some(Received::Frame(frame.into())));
            }
        }
        let longest = Frame::zeroed(CanId::Standard(1), 64);
        assert_eq!(there_and_back(longest), Some(Received::Frame(longest.into())));
    }

    #[test]
    fn an_error_message_is_no_frame() {
        let mut bytes = [0; CLASSIC_BYTES];
        bytes[..4].copy_from_slice(&(ERROR_FLAG | 0x40).to_ne_bytes());
        bytes[4] = 8;
        bytes[15] = 9;
        assert_eq!(read(&bytes), Some(Received::Error(0x40, [0, 0, 0, 0, 0, 0, 0, 9])));
    }

    #[test]
    fn no_length_makes_it_panic() {
        for len in 0..=FD_BYTES {
            read(&[0xFF; FD_BYTES][..len]);
        }
    }
}
