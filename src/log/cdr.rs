//! Raw frames as `can_msgs/msg/Frame` of ROS 2, which many tools show as a
//! CAN trace: little-endian CDR (OMG DDSI-RTPS 10.5), every number aligned to
//! its size, counted from behind the four bytes that name the encoding.

use crate::frame::{Frame, FrameKind};
use crate::time::Instant;

/// Name of the schema.
pub(crate) const FRAME_NAME: &str = "can_msgs/msg/Frame";

/// The definition with all that it refers to, as ROS 2 concatenates them.
pub(super) const FRAME_DEFINITION: &str = "\
std_msgs/Header header
uint32 id
bool is_rtr
bool is_extended
bool is_error
uint8 dlc
uint8[8] data
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

/// Id, remote, extended, error, length code, data.
const TAIL_LEN: usize = 16;

/// Writes the frames of one bus.
pub(super) struct FrameEncoder {
    /// Encoding, stamp, bus name, padding: all before the id.
    head: Vec<u8>,
}

impl FrameEncoder {
    /// For frames of the bus `name`, which becomes their `frame_id`.
    pub fn new(name: &str) -> Self {
        // CDR_LE, then room for the stamp.
        let mut head = vec![0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        head.extend_from_slice(&(name.len() as u32 + 1).to_le_bytes());
        head.extend_from_slice(name.as_bytes());
        head.push(0);
        head.resize(head.len().next_multiple_of(4), 0);
        Self { head }
    }

    /// Appends a classic frame or remote request with the length code `dlc`.
    pub fn put(&self, out: &mut Vec<u8>, at: Instant, frame: &Frame, dlc: u8) {
        let mut tail = [0; TAIL_LEN];
        tail[..4].copy_from_slice(&frame.id.raw().to_le_bytes());
        tail[4] = u8::from(frame.kind == FrameKind::Remote);
        tail[5] = u8::from(frame.id.is_extended());
        tail[7] = dlc;
        tail[8..].copy_from_slice(&frame.storage()[..8]);
        self.put_tail(out, at, &tail);
    }

    /// Appends an error frame: its classes are its id.
    pub fn put_error(&self, out: &mut Vec<u8>, at: Instant, class: u32, data: [u8; 8]) {
        let mut tail = [0; TAIL_LEN];
        tail[..4].copy_from_slice(&class.to_le_bytes());
        tail[6] = 1;
        tail[7] = data.len() as u8;
        tail[8..].copy_from_slice(&data);
        self.put_tail(out, at, &tail);
    }

    /// Appends all that stands before the id, then the tail. The stamp is
    /// exact, before the origin too; past the year 2038 of its 32 bits it
    /// stays there.
    fn put_tail(&self, out: &mut Vec<u8>, at: Instant, tail: &[u8; TAIL_LEN]) {
        let sec = at.as_nanos().div_euclid(1_000_000_000).clamp(i32::MIN.into(), i32::MAX.into()) as i32;
        let nanosec = at.as_nanos().rem_euclid(1_000_000_000) as u32;
        let start = out.len();
        out.extend_from_slice(&self.head);
        out[start + 4..start + 8].copy_from_slice(&sec.to_le_bytes());
        out[start + 8..start + 12].copy_from_slice(&nanosec.to_le_bytes());
        out.extend_from_slice(tail);
    }
}
