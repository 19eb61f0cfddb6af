//! From messages to frames and back, as a profile lays them out.

use super::{Asks, Profile};
use crate::frame::{Frame, FrameKind};
use crate::schema::conversation::WordId;
use crate::schema::decode_error::DecodeError;
use crate::schema::envelope::Envelope;
use crate::schema::message::{Feedback, Message};
use crate::schema::role_table::{Of, Role};
use crate::wheels::{Wheel, Wheels};

/// Why a role that is asked for is there.
const NAMED: &str = "nobody sends what the profile does not name";

impl Profile {
    /// The frame that carries `message`; one that both wheels share carries
    /// nothing for the other. A torque out of range becomes the nearest that the
    /// frame can carry, NaN becomes 0. Allocates nothing.
    #[inline]
    pub fn encode(&self, message: &Message) -> Frame {
        match message {
            Message::Sync { counter } => self.sync.as_ref().expect(NAMED).encode(*counter),
            Message::Command(wheel, command) => {
                let role = &self.command.wheels[*wheel];
                role.envelope.seal(|data| role.write(data, command))
            }
            Message::Feedback(wheel, feedback) => {
                let role = &self.feedback[usize::from(feedback.part)].wheels[*wheel];
                role.envelope.seal(|data| role.write(data, feedback))
            }
            _ => self.encode_rare(message),
        }
    }

    fn encode_rare(&self, message: &Message) -> Frame {
        match message {
            Message::Poll(wheel, part) => self.feedback[usize::from(*part)].wheels[*wheel].envelope.request(),
            Message::Word(wheel, word) => {
                let role = self.words[*wheel].iter().find(|role| role.word == *word);
                role.expect("a word that is not in the command has a message").encode()
            }
            _ => self.envelope(message).seal(|data| self.write(message, data)),
        }
    }

    /// The frame that carries both messages, which share it.
    pub fn encode_shared(&self, both: &Wheels<Message>) -> Frame {
        self.envelope(&both.right).seal(|data| {
            self.write(&both.right, data);
            self.write(&both.left, data);
        })
    }

    /// What a frame says, if all of it is right: to or of the right wheel, where
    /// both share it. Allocates nothing.
    #[inline]
    pub fn decode(&self, frame: &Frame) -> Result<Message, DecodeError> {
        let (role, of) = self.roles.get(frame.id).ok_or(DecodeError::UnknownId)?;
        match of {
            Of::One(wheel) => self.read(role, wheel, frame),
            Of::Both if role == Role::Sync => self.read(role, Wheel::Right, frame),
            Of::Both => self.read_shared(role, frame),
        }
    }

    #[inline(never)]
    fn read_shared(&self, role: Role, frame: &Frame) -> Result<Message, DecodeError> {
        let right = self.read(role, Wheel::Right, frame);
        right.or_else(|error| self.read(role, Wheel::Left, frame).map_err(|_| error))
    }

    /// What a frame that both wheels share says to or of the left wheel, beside
    /// what [`Self::decode`] gives.
    #[inline]
    pub fn decode_other(&self, frame: &Frame) -> Option<Message> {
        if self.roles.has_shared() { self.read_other(frame) } else { None }
    }

    #[inline(never)]
    fn read_other(&self, frame: &Frame) -> Option<Message> {
        match self.roles.get(frame.id)? {
            (Role::Sync, _) | (_, Of::One(_)) => None,
            (role, Of::Both) => {
                self.read(role, Wheel::Right, frame).ok()?;
                self.read(role, Wheel::Left, frame).ok()
            }
        }
    }

    /// Whether a frame is valid and meant for the drives.
    pub fn is_for_drives(&self, frame: &Frame) -> bool {
        if let Some(each) = self.broadcast(frame) {
            return each.any(|frame| self.is_for_drives(frame));
        }
        let decoded = self.decode(frame);
        matches!(decoded, Ok(Message::Sync { .. } | Message::Command(..) | Message::Poll(..) | Message::Word(..)))
    }

    /// What each wheel's drive makes of a frame that is meant for all nodes.
    pub fn broadcast(&self, frame: &Frame) -> Option<Wheels<Frame>> {
        let all = u32::from(self.addressing.broadcast?);
        if self.addressing.node_in(frame.id) != all || self.roles.get(frame.id).is_some() {
            return None;
        }
        let addressed = |node| {
            let mut addressed = *frame;
            addressed.id = self.addressing.readdressed(frame.id, node)?;
            Some(addressed)
        };
        Some(Wheels { right: addressed(self.node_ids.right)?, left: addressed(self.node_ids.left)? })
    }

    /// The mode of operation that a frame asks this wheel's drive to be in, if
    /// it is a command that says one.
    pub fn mode_said(&self, wheel: Wheel, frame: &Frame) -> Option<f64> {
        let role = &self.command.wheels[wheel];
        let mode = role.mode.as_ref().filter(|_| frame.id == role.envelope.id)?;
        role.envelope.open(frame).ok().map(|data| mode.decode(data))
    }

    #[inline]
    fn read(&self, role: Role, wheel: Wheel, frame: &Frame) -> Result<Message, DecodeError> {
        match role {
            Role::Sync => self.sync.as_ref().expect(NAMED).decode(frame).map(|counter| Message::Sync { counter }),
            Role::Command => match self.word_of(wheel, frame) {
                Some(word) => Ok(Message::Word(wheel, word)),
                None => {
                    let role = &self.command.wheels[wheel];
                    Ok(Message::Command(wheel, role.read(role.envelope.open(frame)?)?))
                }
            },
            Role::Feedback(part) if frame.kind == FrameKind::Remote && self.asks == Asks::ByPoll => {
                Ok(Message::Poll(wheel, part))
            }
            Role::Feedback(part) => {
                let role = &self.feedback[usize::from(part)].wheels[wheel];
                Ok(Message::Feedback(wheel, role.read(role.envelope.open(frame)?)?))
            }
            Role::Heartbeat => {
                let role = &self.heartbeat.as_ref().expect(NAMED).wheels[wheel];
                Ok(Message::Heartbeat(wheel, role.read(role.envelope.open(frame)?)?))
            }
            Role::Fault => {
                let role = &self.fault.as_ref().expect(NAMED).wheels[wheel];
                Ok(Message::Fault(wheel, role.fault.decode(role.envelope.open(frame)?)))
            }
            Role::Word => {
                let word = self.word_of(wheel, frame).ok_or(DecodeError::UnknownWord)?;
                Ok(Message::Word(wheel, word))
            }
        }
    }

    /// Puts what a message says into its place.
    #[inline]
    fn write(&self, message: &Message, data: &mut [u8; 64]) {
        match message {
            Message::Command(wheel, command) => self.command.wheels[*wheel].write(data, command),
            Message::Feedback(wheel, feedback) => {
                self.feedback[usize::from(feedback.part)].wheels[*wheel].write(data, feedback);
            }
            Message::Heartbeat(wheel, heartbeat) => {
                self.heartbeat.as_ref().expect(NAMED).wheels[*wheel].write(data, heartbeat);
            }
            Message::Fault(wheel, fault) => {
                self.fault.as_ref().expect(NAMED).wheels[*wheel].fault.encode(data, *fault);
            }
            Message::Sync { .. } | Message::Poll(..) | Message::Word(..) => {}
        }
    }

    /// The outside of a message.
    fn envelope(&self, message: &Message) -> &Envelope {
        match message {
            Message::Sync { .. } => &self.sync.as_ref().expect(NAMED).envelope,
            Message::Command(wheel, _) | Message::Word(wheel, _) => &self.command.wheels[*wheel].envelope,
            Message::Feedback(wheel, Feedback { part, .. }) | Message::Poll(wheel, part) => {
                &self.feedback[usize::from(*part)].wheels[*wheel].envelope
            }
            Message::Heartbeat(wheel, _) => &self.heartbeat.as_ref().expect(NAMED).wheels[*wheel].envelope,
            Message::Fault(wheel, _) => &self.fault.as_ref().expect(NAMED).wheels[*wheel].envelope,
        }
    }

    /// The word that a frame says to this wheel's drive, if it says one.
    #[inline]
    pub(in crate::schema) fn word_of(&self, wheel: Wheel, frame: &Frame) -> Option<WordId> {
        let words = self.words[wheel].iter();
        words.filter(|role| role.envelope.id == frame.id).find(|role| role.is_said_by(frame)).map(|role| role.word)
    }
}
