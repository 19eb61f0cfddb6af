//! The bytes of one packet: a frame as SocketCAN has it, its id big-endian
//! (<https://www.tcpdump.org/linktypes/LINKTYPE_CAN_SOCKETCAN.html>).

use super::{LINK_COOKED, LINK_COOKED_2, LINK_SOCKETCAN};
use crate::traffic::socketcan::{self, BIT_RATE_SWITCH, ERROR_PASSIVE, FD_FORMAT, REMOTE, error_in, id_in};
use crate::traffic::{Content, Direction, RecordedFrame};

/// Bytes of `struct canfd_frame`.
pub(super) const FD_BYTES: usize = 72;
/// Id, length, flags, and two more, before the data.
const HEAD_BYTES: usize = 8;
/// Instead of a length, in CAN XL frames.
const XL_FLAG: u8 = 0x80;
/// Protocols in cooked captures.
const PROTOCOL_CAN: u16 = 0x000C;
const PROTOCOL_CAN_FD: u16 = 0x000D;
/// Sent by us, in cooked captures.
const OUTGOING: u8 = 4;

/// Reads a packet; `None` for one that is no CAN.
pub(super) fn parse(link: u32, bytes: &[u8]) -> Result<Option<(Direction, Content)>, &'static str> {
    let short = "a packet is cut short";
    match link {
        LINK_SOCKETCAN => socketcan(bytes, false).map(|content| Some((Direction::Received, content))),
        LINK_COOKED => {
            let (&[_, kind, .., high, low], rest) = bytes.split_first_chunk::<16>().ok_or(short)?;
            cooked(u16::from_be_bytes([high, low]), kind, rest)
        }
        LINK_COOKED_2 => {
            let (head, rest) = bytes.split_first_chunk::<20>().ok_or(short)?;
            cooked(u16::from_be_bytes([head[0], head[1]]), head[10], rest)
        }
        _ => Ok(None),
    }
}

fn cooked(protocol: u16, kind: u8, rest: &[u8]) -> Result<Option<(Direction, Content)>, &'static str> {
    if !matches!(protocol, PROTOCOL_CAN | PROTOCOL_CAN_FD) {
        return Ok(None);
    }
    let direction = if kind == OUTGOING { Direction::Sent } else { Direction::Received };
    socketcan(rest, protocol == PROTOCOL_CAN_FD).map(|content| Some((direction, content)))
}

fn socketcan(bytes: &[u8], is_fd: bool) -> Result<Content, &'static str> {
    let (&[a, b, c, d, len, flags, _, dlc], rest) =
        bytes.split_first_chunk::<HEAD_BYTES>().ok_or("a packet is too short for a CAN frame")?;
    if len & XL_FLAG != 0 {
        return Err("a CAN XL frame, which canloop does not read");
    }
    let word = u32::from_be_bytes([a, b, c, d]);
    let is_fd = is_fd || flags & FD_FORMAT != 0 || bytes.len() == FD_BYTES;
    if let Some(error) = error_in(word, rest) {
        return Ok(Content::Error(error));
    }
    if word & REMOTE != 0 && !is_fd {
        return Ok(Content::Frame(socketcan::with_dlc(id_in(word), true, code(len, dlc)?, &[])));
    }
    let data = rest.get(..usize::from(len)).ok_or("a packet has less data than it says")?;
    let recorded = match is_fd {
        true => socketcan::fd(id_in(word), flags & BIT_RATE_SWITCH != 0, flags & ERROR_PASSIVE != 0, data),
        false => Some(socketcan::with_dlc(id_in(word), false, code(len, dlc)?, data)),
    };
    recorded.map(Content::Frame).ok_or("a length that no CAN FD frame has")
}

/// The length code of a classic frame.
fn code(len: u8, dlc: u8) -> Result<u8, &'static str> {
    match (len, dlc) {
        (8, 9..=15) => Ok(dlc),
        (0..=8, _) => Ok(len),
        _ => Err("a length above 8 in a classic frame"),
    }
}

/// Appends a frame or an error, as the kernel would give it.
pub(super) fn put(out: &mut Vec<u8>, content: &Content) {
    let end = out.len();
    out.extend_from_slice(&socketcan::id_word(content).to_be_bytes());
    match content {
        Content::Frame(recorded @ RecordedFrame { frame, .. }) if recorded.is_fd() => {
            let flags = socketcan::fd_flags(recorded) | FD_FORMAT;
            out.extend_from_slice(&[frame.len() as u8, flags, 0, 0]);
            out.extend_from_slice(frame.storage());
        }
        Content::Frame(RecordedFrame { frame, dlc_above_8, .. }) => {
            out.extend_from_slice(&[frame.len() as u8, 0, 0, dlc_above_8.unwrap_or(0)]);
            out.extend_from_slice(&frame.storage()[..8]);
        }
        Content::Error(error) => {
            out.extend_from_slice(&[8, 0, 0, 0]);
            out.extend_from_slice(&error.data);
        }
        Content::Lost(_) => out.truncate(end),
    }
}
