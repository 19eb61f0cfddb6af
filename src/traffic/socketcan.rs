//! The id word of SocketCAN (`linux/can.h`), which several formats keep.

use super::record::fd_len_of;
use super::{Content, ErrorFrame, RecordedFrame};
use crate::frame::{CanId, Frame, FrameKind};

/// Set for 29 bits of id.
pub(super) const EXTENDED: u32 = 0x8000_0000;
/// Set for remote requests.
pub(super) const REMOTE: u32 = 0x4000_0000;
/// Flags of CAN FD frames.
pub(super) const BIT_RATE_SWITCH: u8 = 0x01;
pub(super) const ERROR_PASSIVE: u8 = 0x02;
pub(super) const FD_FORMAT: u8 = 0x04;

const ID_29: u32 = 0x1FFF_FFFF;
const ID_11: u32 = 0x7FF;

/// The id with its flags, of a frame or an error.
pub(super) fn id_word(content: &Content) -> u32 {
    match content {
        Content::Frame(RecordedFrame { frame, .. }) => {
            let extended = if frame.id.is_extended() { EXTENDED } else { 0 };
            let remote = if frame.kind == FrameKind::Remote { REMOTE } else { 0 };
            frame.id.raw() | extended | remote
        }
        Content::Error(error) => error.class & ID_29 | ErrorFrame::FLAG,
        Content::Lost(_) => 0,
    }
}

/// The id without its flags; `None` where it has more bits than it says.
pub(super) fn can_id(raw: u32, is_extended: bool) -> Option<CanId> {
    match is_extended {
        true => (raw <= ID_29).then_some(CanId::Extended(raw)),
        false => (raw <= ID_11).then_some(CanId::Standard(raw as u16)),
    }
}

/// The id in an [`id_word`] of a frame.
pub(super) fn id_in(word: u32) -> CanId {
    match word & EXTENDED != 0 {
        true => CanId::Extended(word & ID_29),
        false => CanId::Standard((word & ID_11) as u16),
    }
}

/// The error in an [`id_word`], if it is one.
pub(super) fn error_in(word: u32, data: &[u8]) -> Option<ErrorFrame> {
    (word & ErrorFrame::FLAG != 0).then(|| ErrorFrame { class: word & ID_29, data: eight(data) })
}

/// A classic data frame; `None` for more than 8 bytes.
pub(super) fn classic(id: CanId, data: &[u8]) -> Option<RecordedFrame> {
    (data.len() <= 8).then(|| Frame::classic(id, data).into())
}

/// A classic data frame or remote request with the length code `dlc`, 0 to 15.
pub(super) fn with_dlc(id: CanId, remote: bool, dlc: u8, data: &[u8]) -> RecordedFrame {
    let mut frame = Frame::zeroed(id, usize::from(dlc.min(8)));
    if remote {
        frame.kind = FrameKind::Remote;
    } else {
        let len = data.len().min(frame.len());
        frame.payload_mut()[..len].copy_from_slice(&data[..len]);
    }
    RecordedFrame { frame, error_passive: false, dlc_above_8: (9..=15).contains(&dlc).then_some(dlc) }
}

/// A CAN FD frame; `None` for a length that there is not.
pub(super) fn fd(id: CanId, bit_rate_switch: bool, error_passive: bool, data: &[u8]) -> Option<RecordedFrame> {
    if data.len() > Frame::CAPACITY || fd_len_of(super::record::dlc_of(data.len())) != data.len() {
        return None;
    }
    let mut frame = Frame::zeroed(id, data.len());
    frame.kind = if bit_rate_switch { FrameKind::FdBitRateSwitch } else { FrameKind::Fd };
    frame.payload_mut().copy_from_slice(data);
    Some(RecordedFrame { frame, error_passive, dlc_above_8: None })
}

/// The flags of a CAN FD frame, without [`FD_FORMAT`].
pub(super) fn fd_flags(recorded: &RecordedFrame) -> u8 {
    let switch = if recorded.frame.kind == FrameKind::FdBitRateSwitch { BIT_RATE_SWITCH } else { 0 };
    switch | if recorded.error_passive { ERROR_PASSIVE } else { 0 }
}

fn eight(data: &[u8]) -> [u8; 8] {
    let mut eight = [0; 8];
    let len = data.len().min(8);
    eight[..len].copy_from_slice(&data[..len]);
    eight
}
