//! The messages that the stack and a drive need, each with the signals that
//! it is made of.

use super::checksum::Crc8;
use super::decode_error::DecodeError;
use super::message::{Command, DriveState, FaultCode, Feedback, Heartbeat, Request};
use super::signal::{Raw, Signal};
use super::value_names::ValueNames;
use crate::frame::{CanId, Frame, FrameKind};

/// The outside of a message: its id, length and checksum.
#[derive(Clone, Debug)]
pub(super) struct Envelope {
    pub id: CanId,
    pub len: usize,
    pub checksum: Option<Checksum>,
}

/// A CRC in one byte of a message.
#[derive(Clone, Debug)]
pub(super) struct Checksum {
    pub crc: Crc8,
    /// The CRC's remainder after the id, which never changes.
    pub seed: u8,
    /// Which byte holds it.
    pub byte: usize,
}

/// A torque and the range that it is kept in.
#[derive(Clone, Debug)]
pub(super) struct Torque {
    pub signal: Signal,
    pub scale: TorqueScale,
}

/// The torques that a signal can express.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TorqueScale {
    /// Distance between neighbours, N m.
    pub resolution_nm: f64,
    /// Least, N m.
    pub minimum_nm: f64,
    /// Greatest, N m.
    pub maximum_nm: f64,
}

#[derive(Clone, Debug)]
pub(super) struct SyncRole {
    pub envelope: Envelope,
    pub counter: Signal,
}

#[derive(Clone, Debug)]
pub(super) struct CommandRole {
    pub envelope: Envelope,
    pub torque: Torque,
    pub request: Signal,
    pub requests: ValueNames<Request>,
    pub counter: Signal,
}

#[derive(Clone, Debug)]
pub(super) struct FeedbackRole {
    pub envelope: Envelope,
    pub position: Signal,
    pub torque_applied: Torque,
    pub state: Signal,
    pub states: ValueNames<DriveState>,
    pub counter: Signal,
}

#[derive(Clone, Debug)]
pub(super) struct HeartbeatRole {
    pub envelope: Envelope,
    pub state: Signal,
    pub states: ValueNames<DriveState>,
    pub fault: Signal,
    pub faults: ValueNames<FaultCode>,
}

#[derive(Clone, Debug)]
pub(super) struct FaultRole {
    pub envelope: Envelope,
    pub fault: Signal,
    pub faults: ValueNames<FaultCode>,
}

impl Envelope {
    /// A frame filled by `fill`, with its checksum.
    #[inline]
    fn seal(&self, fill: impl FnOnce(&mut [u8; 64])) -> Frame {
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
    fn open<'f>(&self, frame: &'f Frame) -> Result<&'f [u8; 64], DecodeError> {
        if frame.kind == FrameKind::Remote {
            return Err(DecodeError::RemoteRequest);
        }
        if frame.len() != self.len {
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
}

impl Checksum {
    #[inline]
    fn of(&self, frame: &Frame) -> u8 {
        let (before, rest) = frame.payload().split_at(self.byte);
        let remainder = self.crc.update(self.seed, before);
        self.crc.finish(self.crc.update(remainder, &rest[1..]))
    }
}

impl Torque {
    #[inline]
    fn encode(&self, data: &mut [u8], torque_nm: f64) {
        let torque_nm = if torque_nm.is_nan() { 0.0 } else { torque_nm };
        self.signal.encode(data, torque_nm.clamp(self.scale.minimum_nm, self.scale.maximum_nm));
    }

    #[inline]
    fn decode(&self, data: &[u8; 64]) -> Result<f64, DecodeError> {
        let torque_nm = self.signal.decode(data);
        if torque_nm.is_finite() { Ok(torque_nm) } else { Err(DecodeError::NotFinite { role: "torque" }) }
    }
}

impl SyncRole {
    #[inline]
    pub fn encode(&self, counter: u8) -> Frame {
        self.envelope.seal(|data| encode_counter(&self.counter, data, counter))
    }

    #[inline]
    pub fn decode(&self, frame: &Frame) -> Result<u8, DecodeError> {
        Ok(decode_counter(&self.counter, self.envelope.open(frame)?))
    }
}

impl CommandRole {
    #[inline]
    pub fn encode(&self, command: &Command) -> Frame {
        self.envelope.seal(|data| {
            self.torque.encode(data, command.torque_nm);
            self.requests.encode(&self.request, data, command.request);
            encode_counter(&self.counter, data, command.counter);
        })
    }

    #[inline]
    pub fn decode(&self, frame: &Frame) -> Result<Command, DecodeError> {
        let data = self.envelope.open(frame)?;
        Ok(Command {
            torque_nm: self.torque.decode(data)?,
            request: self.requests.decode(&self.request, data).map_err(unknown("request"))?,
            counter: decode_counter(&self.counter, data),
        })
    }
}

impl FeedbackRole {
    #[inline]
    pub fn encode(&self, feedback: &Feedback) -> Frame {
        self.envelope.seal(|data| {
            self.position.encode_raw(data, Raw::Signed(feedback.position_counts.into()));
            self.torque_applied.encode(data, feedback.torque_applied_nm);
            self.states.encode(&self.state, data, feedback.state);
            encode_counter(&self.counter, data, feedback.counter);
        })
    }

    #[inline]
    pub fn decode(&self, frame: &Frame) -> Result<Feedback, DecodeError> {
        let data = self.envelope.open(frame)?;
        Ok(Feedback {
            position_counts: self.position.decode_bits(data) as i32,
            torque_applied_nm: self.torque_applied.decode(data)?,
            state: self.states.decode(&self.state, data).map_err(unknown("state"))?,
            counter: decode_counter(&self.counter, data),
        })
    }
}

impl HeartbeatRole {
    #[inline]
    pub fn encode(&self, heartbeat: &Heartbeat) -> Frame {
        self.envelope.seal(|data| {
            self.states.encode(&self.state, data, heartbeat.state);
            self.faults.encode(&self.fault, data, heartbeat.fault);
        })
    }

    #[inline]
    pub fn decode(&self, frame: &Frame) -> Result<Heartbeat, DecodeError> {
        let data = self.envelope.open(frame)?;
        Ok(Heartbeat {
            state: self.states.decode(&self.state, data).map_err(unknown("state"))?,
            fault: self.faults.decode(&self.fault, data).map_err(unknown("fault"))?,
        })
    }
}

impl FaultRole {
    #[inline]
    pub fn encode(&self, fault: FaultCode) -> Frame {
        self.envelope.seal(|data| self.faults.encode(&self.fault, data, fault))
    }

    #[inline]
    pub fn decode(&self, frame: &Frame) -> Result<FaultCode, DecodeError> {
        self.faults.decode(&self.fault, self.envelope.open(frame)?).map_err(unknown("fault"))
    }
}

/// Counters wrap at their signal's width, so the low bits are all there is.
#[inline]
fn encode_counter(signal: &Signal, data: &mut [u8], counter: u8) {
    signal.encode_bits(data, counter.into());
}

#[inline]
fn decode_counter(signal: &Signal, data: &[u8; 64]) -> u8 {
    signal.decode_bits(data) as u8
}

fn unknown(role: &'static str) -> impl Fn(i64) -> DecodeError {
    move |found| DecodeError::UnknownValue { role, found }
}
