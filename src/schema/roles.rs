//! The messages that the stack and a drive need, each with the signals that
//! one wheel's part of it is made of.

use super::conversation::WordId;
use super::decode_error::DecodeError;
use super::envelope::Envelope;
use super::message::{Command, FaultCode, Feedback, Heartbeat};
use super::pattern::Field;
use super::quantities::{FaultField, Position, Speed, StateField, Torque, unknown};
use super::signal::Signal;
use crate::frame::Frame;

#[derive(Clone, Debug)]
pub(super) struct SyncRole {
    pub envelope: Envelope,
    pub counter: Option<Signal>,
}

#[derive(Clone, Debug)]
pub(super) struct CommandRole {
    pub envelope: Envelope,
    pub torque: Torque,
    /// What every command says; one that does not asks for no torque.
    pub constants: Vec<Field>,
    /// The words that it has room for.
    pub words: Vec<(WordId, Vec<Field>)>,
    /// The mode of operation that it asks for.
    pub mode: Option<Signal>,
    pub counter: Option<Signal>,
}

#[derive(Clone, Debug)]
pub(super) struct FeedbackRole {
    pub envelope: Envelope,
    pub part: u8,
    /// What every such message says.
    pub constants: Vec<Field>,
    pub position: Option<Position>,
    pub speed: Option<Speed>,
    pub torque_applied: Option<Torque>,
    pub state: Option<StateField>,
    pub fault: Option<FaultField>,
    pub mode: Option<Signal>,
    pub counter: Option<Signal>,
}

#[derive(Clone, Debug)]
pub(super) struct HeartbeatRole {
    pub envelope: Envelope,
    pub state: Option<StateField>,
    pub fault: Option<FaultField>,
}

#[derive(Clone, Debug)]
pub(super) struct FaultRole {
    pub envelope: Envelope,
    pub fault: FaultField,
}

/// A word with a message of its own.
#[derive(Clone, Debug)]
pub(super) struct WordRole {
    pub word: WordId,
    pub envelope: Envelope,
    pub content: WordContent,
}

#[derive(Clone, Debug)]
pub(super) enum WordContent {
    Fields(Vec<Field>),
    /// The payload itself, whatever the DBC makes of it.
    Bytes(Vec<u8>),
}

impl SyncRole {
    #[inline]
    pub fn encode(&self, counter: u8) -> Frame {
        self.envelope.seal(|data| encode_counter(self.counter.as_ref(), data, counter))
    }

    #[inline]
    pub fn decode(&self, frame: &Frame) -> Result<u8, DecodeError> {
        let data = self.envelope.open(frame)?;
        Ok(self.counter.as_ref().map_or(0, |signal| decode_counter(signal, data)))
    }
}

impl CommandRole {
    #[inline]
    pub fn write(&self, data: &mut [u8; 64], command: &Command) {
        self.torque.encode(data, command.torque_nm);
        self.constants.iter().for_each(|field| field.write(data));
        if let Some((_, fields)) = self.words.iter().find(|(word, _)| Some(*word) == command.word) {
            fields.iter().for_each(|field| field.write(data));
        }
        encode_counter(self.counter.as_ref(), data, command.counter);
    }

    #[inline]
    pub fn read(&self, data: &[u8; 64]) -> Result<Command, DecodeError> {
        let is_in_mode = self.constants.iter().all(|field| field.fits(data));
        let said = self.words.iter().find(|(_, fields)| fields.iter().all(|field| field.fits(data)));
        if let (None, Some((_, fields))) = (said, self.words.first()) {
            return Err(unknown("request", &fields[0].signal, data));
        }
        Ok(Command {
            torque_nm: if is_in_mode { self.torque.decode(data)? } else { 0.0 },
            word: said.map(|&(word, _)| word),
            counter: self.counter.as_ref().map_or(0, |signal| decode_counter(signal, data)),
        })
    }
}

impl FeedbackRole {
    #[inline]
    pub fn write(&self, data: &mut [u8; 64], feedback: &Feedback) {
        self.constants.iter().for_each(|field| field.write(data));
        if let Some(position) = &self.position {
            position.encode(data, feedback.position.unwrap_or_default());
        }
        if let Some(speed) = &self.speed {
            speed.encode(data, feedback.speed_rad_s.unwrap_or_default());
        }
        if let Some(torque) = &self.torque_applied {
            torque.encode(data, feedback.torque_applied_nm.unwrap_or_default());
        }
        if let Some(state) = &self.state {
            state.encode(data, feedback.state);
        }
        write_fault(self.fault.as_ref(), self.state.is_some(), data, feedback.fault.unwrap_or_default());
        if let Some(mode) = &self.mode {
            mode.encode(data, feedback.mode.unwrap_or_default());
        }
        encode_counter(self.counter.as_ref(), data, feedback.counter.unwrap_or_default());
    }

    #[inline]
    pub fn read(&self, data: &[u8; 64]) -> Result<Feedback, DecodeError> {
        let fault = self.fault.as_ref().map(|fault| fault.decode(data));
        Ok(Feedback {
            part: self.part,
            position: self.position.as_ref().map(|position| position.decode(data)).transpose()?,
            speed_rad_s: self.speed.as_ref().map(|speed| speed.decode(data)).transpose()?,
            torque_applied_nm: self.torque_applied.as_ref().map(|torque| torque.decode(data)).transpose()?,
            state: self.state.as_ref().map_or(Ok(None), |state| state.decode(data, fault))?,
            fault,
            mode: self.mode.as_ref().map(|signal| signal.decode(data)),
            counter: self.counter.as_ref().map(|signal| decode_counter(signal, data)),
        })
    }
}

impl HeartbeatRole {
    #[inline]
    pub fn write(&self, data: &mut [u8; 64], heartbeat: &Heartbeat) {
        if let Some(state) = &self.state {
            state.encode(data, heartbeat.state);
        }
        write_fault(self.fault.as_ref(), self.state.is_some(), data, heartbeat.fault);
    }

    #[inline]
    pub fn read(&self, data: &[u8; 64]) -> Result<Heartbeat, DecodeError> {
        let fault = self.fault.as_ref().map(|fault| fault.decode(data));
        Ok(Heartbeat {
            state: self.state.as_ref().map_or(Ok(None), |state| state.decode(data, fault))?,
            fault: fault.unwrap_or_default(),
        })
    }
}

impl WordRole {
    /// The frame that says it.
    pub fn encode(&self) -> Frame {
        self.envelope.seal(|data| match &self.content {
            WordContent::Fields(fields) => fields.iter().for_each(|field| field.write(data)),
            WordContent::Bytes(bytes) => data[..bytes.len()].copy_from_slice(bytes),
        })
    }

    /// Whether a frame with its id says it.
    pub fn is_said_by(&self, frame: &Frame) -> bool {
        self.envelope.open(frame).is_ok_and(|data| match &self.content {
            WordContent::Fields(fields) => fields.iter().all(|field| field.fits(data)),
            WordContent::Bytes(bytes) => data.starts_with(bytes),
        })
    }
}

/// State and fault may share their bits: then a fault says it all.
fn write_fault(field: Option<&FaultField>, has_state: bool, data: &mut [u8; 64], fault: FaultCode) {
    if let Some(field) = field.filter(|field| !(field.shares_state && has_state && fault == FaultCode::None)) {
        field.encode(data, fault);
    }
}

/// Counters wrap at their signal's width, so the low bits are all there is.
#[inline]
fn encode_counter(signal: Option<&Signal>, data: &mut [u8], counter: u8) {
    if let Some(signal) = signal {
        signal.encode_bits(data, counter.into());
    }
}

#[inline]
fn decode_counter(signal: &Signal, data: &[u8; 64]) -> u8 {
    signal.decode_bits(data) as u8
}
