//! A CAN frame as the bus carries it, and the id that arbitrates for it.

use std::fmt;

/// The arbitration id of a frame: 11 bits (standard) or 29 bits (extended).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CanId {
    /// 11 bits, `0..=0x7FF`.
    Standard(u16),
    /// 29 bits, `0..=0x1FFF_FFFF`.
    Extended(u32),
}

/// A classic or CAN FD data frame, or a remote request.
///
/// Plain data of fixed size, so that copying one never allocates.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// Arbitration id.
    pub id: CanId,
    /// Classic, remote or FD.
    pub kind: FrameKind,
    /// Bytes of `data` in use: at most 8 for a classic frame, 64 for FD.
    len: u8,
    /// Bytes past `len` are zero, so that frames compare byte for byte.
    data: [u8; Self::CAPACITY],
}

/// What sort of frame it is on the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FrameKind {
    /// CAN 2.0 data frame, up to 8 bytes.
    #[default]
    Classic,
    /// CAN 2.0 remote request: a length but no data.
    Remote,
    /// CAN FD data frame, up to 64 bytes, without bit-rate switch.
    Fd,
    /// CAN FD data frame with bit-rate switch.
    FdBitRateSwitch,
}

impl CanId {
    /// The bare number, without any marker of its width.
    pub const fn raw(self) -> u32 {
        match self {
            Self::Standard(id) => id as u32,
            Self::Extended(id) => id,
        }
    }

    /// Whether the id has 29 bits.
    pub const fn is_extended(self) -> bool {
        matches!(self, Self::Extended(_))
    }

    /// A number that orders ids as arbitration does: the lowest wins. A
    /// standard frame beats an extended one that shares its first 11 bits,
    /// because its RTR and IDE bits are dominant (ISO 11898-1, 10.4.2).
    pub const fn arbitration_order(self) -> u32 {
        match self {
            Self::Standard(id) => (id as u32) << 19,
            Self::Extended(id) => ((id >> 18) << 19) | (1 << 18) | (id & 0x3_FFFF),
        }
    }
}

impl Frame {
    /// Bytes that the longest (CAN FD) frame holds.
    pub const CAPACITY: usize = 64;

    /// A classic data frame. Panics when `payload` is longer than 8 bytes:
    /// the sender's schema fixes the length, so that would be a bug.
    pub fn classic(id: CanId, payload: &[u8]) -> Self {
        assert!(payload.len() <= 8, "a classic frame holds 8 bytes, not {}", payload.len());
        let mut frame = Self::zeroed(id, payload.len());
        frame.payload_mut().copy_from_slice(payload);
        frame
    }

    /// A frame of `len` zero bytes: classic up to 8, CAN FD above. Panics
    /// when `len` is above [`Self::CAPACITY`].
    pub fn zeroed(id: CanId, len: usize) -> Self {
        assert!(len <= Self::CAPACITY, "a CAN FD frame holds 64 bytes, not {len}");
        let kind = if len <= 8 { FrameKind::Classic } else { FrameKind::Fd };
        Self { id, kind, len: len as u8, data: [0; Self::CAPACITY] }
    }

    /// The bytes in use.
    pub fn payload(&self) -> &[u8] {
        &self.data[..usize::from(self.len)]
    }

    /// The bytes in use, to be written.
    pub fn payload_mut(&mut self) -> &mut [u8] {
        &mut self.data[..usize::from(self.len)]
    }

    /// All the room of the frame, zero past its length. For decoders that
    /// load whole words.
    pub const fn storage(&self) -> &[u8; Self::CAPACITY] {
        &self.data
    }

    /// All the room of the frame, for encoders that store whole words. What
    /// lies past the length must stay zero.
    pub(crate) const fn storage_mut(&mut self) -> &mut [u8; Self::CAPACITY] {
        &mut self.data
    }

    /// The number of bytes in use.
    pub const fn len(&self) -> usize {
        self.len as usize
    }

    /// Whether the frame carries no byte.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }
}

impl fmt::Display for CanId {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Standard(id) => write!(out, "{id:03X}"),
            Self::Extended(id) => write!(out, "{id:08X}"),
        }
    }
}

/// `181#0011223344556677`, as candump writes it.
impl fmt::Display for Frame {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}#", self.id)?;
        match self.kind {
            FrameKind::Remote => return write!(out, "R{}", self.len),
            FrameKind::Fd => write!(out, "#0")?,
            FrameKind::FdBitRateSwitch => write!(out, "#1")?,
            FrameKind::Classic => {}
        }
        self.payload().iter().try_for_each(|byte| write!(out, "{byte:02X}"))
    }
}

impl fmt::Debug for Frame {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_standard_frame_beats_the_extended_one_that_shares_its_first_bits() {
        let standard = CanId::Standard(0x181);
        let extended = CanId::Extended(0x181 << 18);
        assert!(standard.arbitration_order() < extended.arbitration_order());
        assert!(CanId::Extended(0x180 << 18 | 0x3_FFFF).arbitration_order() < standard.arbitration_order());
    }

    #[test]
    fn a_frame_prints_as_candump_writes_it() {
        let frame = Frame::classic(CanId::Standard(0x81), &[0xDE, 0xAD]);
        assert_eq!(frame.to_string(), "081#DEAD");
        let frame = Frame::classic(CanId::Extended(0x1234), &[]);
        assert_eq!(frame.to_string(), "00001234#");
    }
}
