//! What crosses the bus with drives of a profile: which frames, whose, when.

use super::{Acts, Asks, Profile, Shared};
use crate::frame::{CanId, Frame};
use crate::schema::conversation::WordId;
use crate::schema::envelope::Envelope;
use crate::schema::message::Message;
use crate::schema::role_table::{Of, Role};
use crate::wheels::{Wheel, Wheels};

impl Profile {
    /// Whether a frame has the id of the one that begins the stack's period.
    #[inline]
    pub fn begins_period(&self, frame: &Frame) -> bool {
        match &self.sync {
            Some(sync) => frame.id == sync.envelope.id,
            None => frame.id == self.command.wheels.right.envelope.id && self.word_of(Wheel::Right, frame).is_none(),
        }
    }

    /// How many frames begin the stack's period: those to which drives answer,
    /// and those that act when they arrive.
    pub fn frames_at_beginning(&self) -> u32 {
        let of = |is_shared: bool| if is_shared { 1 } else { 2 };
        let commands = if self.acts == Acts::OnArrival { of(self.command.is_shared) } else { 0 };
        let polls = if self.asks == Asks::ByPoll { self.polls().count() as u32 } else { 0 };
        u32::from(self.sync.is_some()) + commands + polls
    }

    /// Whether a message is one of those that begin the stack's period.
    pub fn is_at_beginning(&self, message: &Message) -> bool {
        match message {
            Message::Sync { .. } | Message::Poll(..) => true,
            Message::Command(..) => self.acts == Acts::OnArrival,
            _ => false,
        }
    }

    /// Whether SYNC is sent at all.
    pub const fn has_sync(&self) -> bool {
        self.sync.is_some()
    }

    /// Whether a word comes under the id of this wheel's command.
    pub fn is_said_in_place_of_a_command(&self, wheel: Wheel, word: WordId) -> bool {
        let id = self.command.wheels[wheel].envelope.id;
        self.words[wheel].iter().any(|role| role.word == word && role.envelope.id == id)
    }

    /// Whether both wheels share the message that carries commands.
    pub const fn shares_command(&self) -> bool {
        self.command.is_shared
    }

    /// Whether both wheels share this part of the feedback.
    pub fn shares_feedback(&self, part: u8) -> bool {
        self.feedback[usize::from(part)].is_shared
    }

    /// Whether both wheels share the message that gives signs of life.
    pub fn shares_heartbeat(&self) -> bool {
        self.heartbeat.as_ref().is_some_and(|heartbeat| heartbeat.is_shared)
    }

    /// Whether a raised fault has a message of its own.
    pub const fn tells_faults(&self) -> bool {
        self.fault.is_some()
    }

    /// How many messages a drive's feedback comes in.
    pub fn parts(&self) -> u8 {
        self.feedback.len() as u8
    }

    /// The remote requests that ask for all feedback.
    pub fn polls(&self) -> impl Iterator<Item = Message> {
        let wheels = |part: u8| Wheel::BOTH.into_iter().take(if self.shares_feedback(part) { 1 } else { 2 });
        (0..self.parts()).flat_map(move |part| wheels(part).map(move |wheel| Message::Poll(wheel, part)))
    }

    /// The arbitration ids of feedback.
    pub fn is_feedback(&self, id: CanId) -> bool {
        matches!(self.roles.get(id), Some((Role::Feedback(_), _)))
    }

    /// Whether drives send frames of this id.
    pub fn is_sent_by_drives(&self, id: CanId) -> bool {
        matches!(self.roles.get(id), Some((Role::Feedback(_) | Role::Heartbeat | Role::Fault, _)))
    }

    /// The ids of all that drives send.
    pub fn drive_ids(&self) -> impl Iterator<Item = CanId> {
        let mut ids = Vec::new();
        self.list_roles(|id, role, _| {
            if matches!(role, Role::Feedback(_) | Role::Heartbeat | Role::Fault) {
                ids.push(id);
            }
        });
        ids.into_iter()
    }

    /// Every message with what it is for and whose it is.
    pub(in crate::schema) fn list_roles(&self, mut tell: impl FnMut(CanId, Role, Of)) {
        if let Some(sync) = &self.sync {
            tell(sync.envelope.id, Role::Sync, Of::Both);
        }
        self.command.list(Role::Command, |role| &role.envelope, &mut tell);
        for (part, shared) in self.feedback.iter().enumerate() {
            shared.list(Role::Feedback(part as u8), |role| &role.envelope, &mut tell);
        }
        if let Some(heartbeat) = &self.heartbeat {
            heartbeat.list(Role::Heartbeat, |role| &role.envelope, &mut tell);
        }
        if let Some(fault) = &self.fault {
            fault.list(Role::Fault, |role| &role.envelope, &mut tell);
        }
        for (right, left) in self.words.right.iter().zip(&self.words.left) {
            let is_shared = right.envelope.id == left.envelope.id;
            let shared =
                Shared { wheels: Wheels { right: right.envelope.clone(), left: left.envelope.clone() }, is_shared };
            shared.list(Role::Word, |envelope| envelope, &mut tell);
        }
    }
}

impl<T> Shared<T> {
    fn list(&self, role: Role, envelope: impl Fn(&T) -> &Envelope, tell: &mut impl FnMut(CanId, Role, Of)) {
        if self.is_shared {
            return tell(envelope(&self.wheels.right).id, role, Of::Both);
        }
        for wheel in Wheel::BOTH {
            tell(envelope(&self.wheels[wheel]).id, role, Of::One(wheel));
        }
    }
}
