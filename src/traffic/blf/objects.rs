//! What objects of each type hold.

use super::kind;
use crate::traffic::bytes::{u16_at, u32_at};
use crate::traffic::record::fd_len_of;
use crate::traffic::socketcan::{self, EXTENDED, can_id, error_in};
use crate::traffic::{Content, Direction, ErrorFrame, RecordedFrame};

/// What an object says.
pub(super) enum Said {
    /// Something happened on the bus of this number.
    Happened { number: u32, direction: Direction, content: Content },
    /// What the bus of this number is called.
    Name { number: u32, name: String },
    /// Nothing of ours.
    Nothing,
}

const TRANSMITTED: u8 = 0x0F;
const REMOTE: u8 = 0x80;
/// In the flags of CAN_FD_MESSAGE.
const FD_FORMAT: u8 = 1;
const FD_SWITCH: u8 = 2;
const FD_PASSIVE: u8 = 4;
/// In the flags of CAN_FD_MESSAGE_64.
const FD64_REMOTE: u32 = 0x0010;
const FD64_FORMAT: u32 = 0x1000;
const FD64_SWITCH: u32 = 0x2000;
const FD64_PASSIVE: u32 = 0x4000;
/// A text about a channel's database.
const ABOUT_CHANNEL: u32 = 1;

/// Bytes that an object's body has at least; `None` for types that are passed over.
pub(super) const fn body_bytes(object_kind: u32) -> Option<usize> {
    match object_kind {
        kind::CAN_MESSAGE | kind::CAN_MESSAGE2 | kind::APP_TEXT => Some(16),
        kind::CAN_ERROR => Some(4),
        kind::CAN_ERROR_EXT => Some(32),
        kind::CAN_FD_MESSAGE => Some(84),
        kind::CAN_FD_MESSAGE_64 => Some(40),
        kind::CAN_FD_ERROR_64 => Some(1),
        _ => None,
    }
}

/// Reads a body that has the bytes it must; or says what is wrong with it.
pub(super) fn parse(object_kind: u32, body: &[u8], head_bytes: usize) -> Result<Said, &'static str> {
    let (number, direction, content) = match object_kind {
        kind::CAN_MESSAGE | kind::CAN_MESSAGE2 => {
            let (flags, dlc) = (body[2], body[3]);
            (u16_at(body, 0).into(), sent(flags & TRANSMITTED), classic(body, flags & REMOTE != 0, dlc, &body[8..16])?)
        }
        kind::CAN_FD_MESSAGE => fd(body)?,
        kind::CAN_FD_MESSAGE_64 => fd_64(body, head_bytes)?,
        kind::CAN_ERROR_EXT => (u16_at(body, 0).into(), Direction::Received, Content::Error(error(body))),
        kind::CAN_ERROR => (u16_at(body, 0).into(), Direction::Received, Content::Error(ErrorFrame::UNSPECIFIED)),
        kind::CAN_FD_ERROR_64 => (body[0].into(), Direction::Received, Content::Error(ErrorFrame::UNSPECIFIED)),
        kind::APP_TEXT => return Ok(name(body)),
        _ => return Ok(Said::Nothing),
    };
    Ok(Said::Happened { number, direction, content })
}

fn sent(direction: u8) -> Direction {
    if direction == 0 { Direction::Received } else { Direction::Sent }
}

const BAD_ID: &str = "an id has more than its 11 or 29 bits";
const BAD_LENGTH: &str = "a length code is above 15";

fn id(body: &[u8]) -> Result<crate::frame::CanId, &'static str> {
    let word = u32_at(body, 4);
    can_id(word & !EXTENDED, word & EXTENDED != 0).ok_or(BAD_ID)
}

fn classic(body: &[u8], remote: bool, dlc: u8, data: &[u8]) -> Result<Content, &'static str> {
    if dlc > 15 {
        return Err(BAD_LENGTH);
    }
    Ok(Content::Frame(socketcan::with_dlc(id(body)?, remote, dlc, data)))
}

/// CAN_FD_MESSAGE, which also holds classic frames.
fn fd(body: &[u8]) -> Result<(u32, Direction, Content), &'static str> {
    let (flags, dlc, fd_flags) = (body[2], body[3], body[13]);
    let data = &body[20..84];
    let content = match fd_flags & FD_FORMAT != 0 {
        false => classic(body, flags & REMOTE != 0, dlc, data)?,
        true => fd_frame(body, dlc, fd_flags & FD_SWITCH != 0, fd_flags & FD_PASSIVE != 0, data)?,
    };
    Ok((u16_at(body, 0).into(), sent(flags & TRANSMITTED), content))
}

/// CAN_FD_MESSAGE_64: as much data as there is, and perhaps more behind it.
fn fd_64(body: &[u8], head_bytes: usize) -> Result<(u32, Direction, Content), &'static str> {
    let (dlc, valid, flags, more_at) = (body[1], usize::from(body[2]), u32_at(body, 12), usize::from(body[35]));
    let data_end = more_at.checked_sub(head_bytes).filter(|end| (40..=body.len()).contains(end)).unwrap_or(body.len());
    let data = &body[40..data_end.min(40 + valid)];
    let content = match flags & FD64_FORMAT != 0 {
        false => classic(body, flags & FD64_REMOTE != 0, dlc, data)?,
        true => fd_frame(body, dlc, flags & FD64_SWITCH != 0, flags & FD64_PASSIVE != 0, data)?,
    };
    Ok((body[0].into(), sent(body[34]), content))
}

/// As long as the length code says: what the log left out was zero.
fn fd_frame(body: &[u8], dlc: u8, switch: bool, passive: bool, data: &[u8]) -> Result<Content, &'static str> {
    if dlc > 15 {
        return Err(BAD_LENGTH);
    }
    let mut padded = [0; 64];
    let len = fd_len_of(dlc);
    let there = data.len().min(len);
    padded[..there].copy_from_slice(&data[..there]);
    let recorded: Option<RecordedFrame> = socketcan::fd(id(body)?, switch, passive, &padded[..len]);
    recorded.map(Content::Frame).ok_or(BAD_LENGTH)
}

/// Our own logs keep SocketCAN's words in the place of the frame that was
/// destroyed, whose id would not have that flag.
fn error(body: &[u8]) -> ErrorFrame {
    error_in(u32_at(body, 16), &body[24..32]).unwrap_or(ErrorFrame::UNSPECIFIED)
}

/// `path of the database;name of the bus`.
fn name(body: &[u8]) -> Said {
    let (about, len) = (u32_at(body, 4), u32_at(body, 8) as usize);
    let text = body.get(16..).unwrap_or_default();
    let text = String::from_utf8_lossy(&text[..len.min(text.len())]);
    let name = text.trim_end_matches('\0').split(';').nth(1).unwrap_or_default();
    let is_can = u32_at(body, 0) == ABOUT_CHANNEL && about >> 16 & 0xFF == 1;
    if !is_can || name.is_empty() {
        return Said::Nothing;
    }
    Said::Name { number: about >> 8 & 0xFF, name: name.to_owned() }
}
