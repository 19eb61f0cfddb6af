//! Frames in the layouts that messages have.

use super::channels::Layout;
use crate::log::{Value, read_fields};
use crate::time::Instant;
use crate::traffic::bytes::{u32_at, u64_at};
use crate::traffic::socketcan::{self, can_id, error_in};
use crate::traffic::{Content, Direction, ErrorFrame, RecordedFrame};

/// What a message says.
pub(super) struct Message<'m> {
    /// Where it says so itself.
    pub at: Option<Instant>,
    pub bus: Option<&'m str>,
    pub direction: Option<Direction>,
    pub content: Content,
}

const SHORT: &str = "a message is shorter than its schema says";
const BAD_ID: &str = "an id has more than its 11 or 29 bits";
const BAD_LENGTH: &str = "a length that no frame has";

/// Reads a message.
pub(super) fn parse(layout: Layout, bytes: &[u8]) -> Result<Message<'_>, &'static str> {
    match layout {
        Layout::Ros => ros(bytes),
        Layout::RosFd => ros_fd(bytes),
        Layout::Fd => fd(bytes),
        Layout::Lost => lost(bytes),
    }
}

/// Stamp, name of the bus, and what is behind them.
type RosHead<'m> = (Option<Instant>, Option<&'m str>, &'m [u8]);

/// The head of ROS messages and what is behind it: the encoding, which must
/// be little-endian CDR, then seconds, nanoseconds, the name of the bus.
fn ros_head(bytes: &[u8]) -> Result<RosHead<'_>, &'static str> {
    if bytes.len() < 16 {
        return Err(SHORT);
    }
    if bytes[1] != 1 {
        return Err("a message is not in little-endian CDR, which alone is read");
    }
    let (seconds, nanos) = (u32_at(bytes, 4).cast_signed(), u32_at(bytes, 8));
    let len = u32_at(bytes, 12) as usize;
    let end = len.checked_add(16).filter(|end| *end <= bytes.len()).ok_or(SHORT)?;
    let name = std::str::from_utf8(&bytes[16..end]).ok().map(|name| name.trim_end_matches('\0'));
    // Numbers are aligned, counted from behind the encoding.
    let next = (end - 4).next_multiple_of(4) + 4;
    // Outside of its 32 bits of seconds the stamp stands still; no stamp is zero.
    let is_stamped = seconds != i32::MAX && seconds != i32::MIN && nanos < 1_000_000_000;
    let at = is_stamped.then(|| Instant::from_nanos(i64::from(seconds) * 1_000_000_000 + i64::from(nanos)));
    Ok((at, name.filter(|name| !name.is_empty()), bytes.get(next..).ok_or(SHORT)?))
}

fn ros(bytes: &[u8]) -> Result<Message<'_>, &'static str> {
    let (at, bus, rest) = ros_head(bytes)?;
    let body: &[u8; 16] = rest.first_chunk().ok_or(SHORT)?;
    let [is_remote, is_extended, is_error, dlc] = [body[4], body[5], body[6], body[7]];
    let raw = u32_at(body, 0);
    let content = if is_error != 0 {
        Content::Error(error(raw, &body[8..]))
    } else if dlc > 15 {
        return Err(BAD_LENGTH);
    } else {
        let id = can_id(raw, is_extended != 0).ok_or(BAD_ID)?;
        Content::Frame(socketcan::with_dlc(id, is_remote != 0, dlc, &body[8..]))
    };
    Ok(Message { at, bus, direction: None, content })
}

fn ros_fd(bytes: &[u8]) -> Result<Message<'_>, &'static str> {
    let (at, bus, rest) = ros_head(bytes)?;
    let (&[a, b, c, d, is_extended, is_error, ..], data) = rest.split_first_chunk::<12>().ok_or(SHORT)?;
    let raw = u32::from_le_bytes([a, b, c, d]);
    let data = data.get(..u32_at(rest, 8) as usize).ok_or(SHORT)?;
    let content = if is_error != 0 {
        Content::Error(error(raw, data))
    } else {
        let id = can_id(raw, is_extended != 0).ok_or(BAD_ID)?;
        Content::Frame(socketcan::fd(id, false, false, data).ok_or(BAD_LENGTH)?)
    };
    Ok(Message { at, bus, direction: None, content })
}

fn error(class: u32, data: &[u8]) -> ErrorFrame {
    error_in(class | ErrorFrame::FLAG, data).unwrap_or(ErrorFrame::UNSPECIFIED)
}

/// The frames lost before a moment.
fn lost(bytes: &[u8]) -> Result<Message<'static>, &'static str> {
    let mut frames = 0;
    read_fields(bytes, |number, value| {
        if let (1, Value::Number(value)) = (number, value) {
            frames = value;
        }
    })?;
    let content = Content::Lost(u32::try_from(frames).unwrap_or(u32::MAX));
    Ok(Message { at: None, bus: None, direction: None, content })
}

fn fd(bytes: &[u8]) -> Result<Message<'static>, &'static str> {
    let (mut id, mut extended, mut switch, mut sent, mut passive) = (0, false, false, false, false);
    let mut data: &[u8] = &[];
    read_fields(bytes, |number, value| match (number, value) {
        (1, Value::Number(value)) => id = u32::try_from(value).unwrap_or(u32::MAX),
        (2, Value::Number(value)) => extended = value != 0,
        (3, Value::Number(value)) => switch = value != 0,
        (4, Value::Number(value)) => sent = value != 0,
        (5, Value::Bytes(value)) => data = value,
        (6, Value::Number(value)) => passive = value != 0,
        _ => {}
    })?;
    let id = can_id(id, extended).ok_or(BAD_ID)?;
    let recorded: RecordedFrame = socketcan::fd(id, switch, passive, data).ok_or(BAD_LENGTH)?;
    let direction = if sent { Direction::Sent } else { Direction::Received };
    Ok(Message { at: None, bus: None, direction: Some(direction), content: Content::Frame(recorded) })
}

/// The time in a message's own head, which every message has.
pub(super) fn log_time(header: &[u8]) -> Instant {
    Instant::from_nanos(i64::try_from(u64_at(header, 6)).unwrap_or(i64::MAX))
}
