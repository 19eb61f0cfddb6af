//! The outside of a message: its id, length and checksum.

use super::checksum::Crc8;
use super::decode_error::DecodeError;
use crate::frame::{CanId, Frame, FrameKind};

/// What a frame must be to be opened, and what seals one.
#[derive(Clone, Debug)]
pub(super) struct Envelope {
    pub id: CanId,
    pub len: usize,
    /// The least length that others may send it with; what is missing is 0.
    pub shortest: usize,
    pub checksum: Option<Checksum>,
}

/// A CRC and what it covers.
#[derive(Clone, Debug)]
pub(super) struct CrcRule {
    pub crc: Crc8,
    /// Bytes of the id, low byte first, before the payload.
    pub id_bytes: usize,
    /// Whether the payload is taken from its end to its beginning.
    pub is_reversed: bool,
}

/// A CRC in one byte of a message.
#[derive(Clone, Debug)]
pub(super) struct Checksum {
    pub rule: CrcRule,
    /// The CRC's remainder after the id, which never changes.
    seed: u8,
    /// Which byte holds it.
    byte: usize,
}

impl Envelope {
    /// A frame filled by `fill`, with its checksum.
    #[inline]
    pub fn seal(&self, fill: impl FnOnce(&mut [u8; 64])) -> Frame {
        let mut frame = Frame::zeroed(self.id, self.len);
        fill(frame.storage_mut());
        if let Some(checksum) = &self.checksum {
            let crc = checksum.of(&frame);
            frame.payload_mut()[checksum.byte] = crc;
        }
        frame
    }

    /// The bytes of a frame whose kind, length and checksum are right.
    #[inline]
    pub fn open<'f>(&self, frame: &'f Frame) -> Result<&'f [u8; 64], DecodeError> {
        if frame.kind == FrameKind::Remote {
            return Err(DecodeError::RemoteRequest);
        }
        if frame.len() != self.len && !(self.shortest..self.len).contains(&frame.len()) {
            return Err(DecodeError::WrongLength { found: frame.len(), expected: self.len });
        }
        if let Some(checksum) = &self.checksum {
            let (found, expected) = (frame.payload()[checksum.byte], checksum.of(frame));
            if found != expected {
                return Err(DecodeError::WrongCrc { found, expected });
            }
        }
        Ok(frame.storage())
    }

    /// A remote request for this message.
    pub fn request(&self) -> Frame {
        let mut frame = Frame::zeroed(self.id, self.len);
        frame.kind = FrameKind::Remote;
        frame
    }
}

impl Checksum {
    /// A checksum in `byte` of the message with this id.
    pub fn new(rule: CrcRule, id: CanId, byte: usize) -> Self {
        let seed = rule.crc.update(rule.crc.start(), &id.raw().to_le_bytes()[..rule.id_bytes]);
        Self { rule, seed, byte }
    }

    #[inline]
    fn of(&self, frame: &Frame) -> u8 {
        let crc = &self.rule.crc;
        let (before, rest) = frame.payload().split_at(self.byte);
        if self.rule.is_reversed {
            return crc.finish(crc.update_reversed(crc.update_reversed(self.seed, &rest[1..]), before));
        }
        crc.finish(crc.update(crc.update(self.seed, before), &rest[1..]))
    }
}
