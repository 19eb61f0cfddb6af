//! A drive profile: which message and signal of a DBC carries what. Both ends
//! of the bus read the same one.

use std::path::Path;
use std::sync::Arc;

use super::conversation::{Conversation, Watchdog, WordId};
use super::dbc::Dbc;
use super::envelope::Envelope;
use super::message::{Command, Message};
use super::profile_reader;
use super::quantities::{PositionScale, TorqueScale};
use super::role_table::{Of, Role, RoleTable};
use super::roles::{CommandRole, FaultRole, FeedbackRole, HeartbeatRole, SyncRole, WordRole};
use super::units::{Motor, Nameplate};
use crate::config::{Document, Problem, Problems, Reader, Source};
use crate::frame::{CanId, Frame};
use crate::time::Duration;
use crate::wheels::{Wheel, Wheels};

/// Name, TOML and DBC of the profiles that the program brings along.
macro_rules! builtin {
    ($($name:literal),*) => {
        [$(($name, include_str!(concat!("../../dbc/", $name, ".toml")), include_str!(concat!("../../dbc/", $name, ".dbc")))),*]
    };
}

const BUILTIN: &[(&str, &str, &str)] =
    &builtin!["wheel_drive", "cia402", "odrive-0.6", "odrive-0.5", "vesc", "damiao-dm4310", "comma-body"];

/// A kind of drive, and how to speak with one on each wheel.
#[derive(Clone, Debug)]
pub struct Profile {
    /// Its name.
    pub name: String,
    /// The profile's text, as read.
    pub toml_text: String,
    /// The messages of its bus.
    pub dbc: Dbc,
    /// Node number of each wheel's drive.
    pub node_ids: Wheels<u8>,
    /// What the profile knows of the motors.
    pub plate: Nameplate,
    /// What makes drives answer.
    pub asks: Asks,
    /// When a command goes into force.
    pub acts: Acts,
    /// Whether what a command's frame cannot say of a torque is said with the
    /// next.
    pub carries_remainder: bool,
    /// How often a drive sends feedback that nobody asks for.
    pub feedback_period: Option<Duration>,
    /// How often a drive gives a sign of life, if it does.
    pub heartbeat_period: Option<Duration>,
    /// What makes a drive stop that hears nothing any more.
    pub watchdog: Option<Watchdog>,
    /// The drive's states, and what can be said to it.
    pub conversation: Conversation,
    /// Whether drives tell their state at all.
    pub tells_state: bool,
    /// What the torque is that drives report as applied.
    pub applied: Applied,
    /// Whether the counter of feedback is that of the SYNC it answers; else
    /// it is the drive's own.
    pub counter_echoes_sync: bool,
    pub(super) addressing: Addressing,
    pub(super) sync: Option<SyncRole>,
    pub(super) command: Shared<CommandRole>,
    pub(super) feedback: Vec<Shared<FeedbackRole>>,
    pub(super) heartbeat: Option<Shared<HeartbeatRole>>,
    pub(super) fault: Option<Shared<FaultRole>>,
    pub(super) words: Wheels<Vec<WordRole>>,
    pub(super) roles: RoleTable,
}

/// Where an arbitration id holds the node's number.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Addressing {
    pub mask: u32,
    /// The number that means all nodes.
    pub broadcast: Option<u8>,
}

/// What makes drives answer with their feedback.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asks {
    /// SYNC.
    BySync,
    /// A remote request for each part of it.
    ByPoll,
    /// Each command.
    ByCommand,
    /// Nothing: they send it by their own clock.
    Nothing,
}

/// What a drive reports as the torque that it applied.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Applied {
    /// The torque at the end of the period.
    #[default]
    TheLast,
    /// The mean over the period.
    TheMean,
    /// The torque at the end of the period, so coarse that the one asked for is
    /// believed within a step of it.
    Coarse,
}

/// When a command goes into force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acts {
    /// At the next SYNC.
    AtSync,
    /// When it arrives.
    OnArrival,
}

/// Both wheels' parts of a message, which is one for both or one for each.
#[derive(Clone, Debug)]
pub(super) struct Shared<T> {
    pub wheels: Wheels<T>,
    pub is_shared: bool,
}

impl Profile {
    /// The profile of this name that the program brings along.
    pub fn builtin(name: &str) -> Option<Self> {
        let (name, toml, dbc) = BUILTIN.iter().find(|(known, ..)| *known == name)?;
        let profile = Document::parse(format!("{name}.toml"), *toml)
            .map_err(Problems::from)
            .and_then(|document| Self::parse(&document, &Source::new(format!("{name}.dbc"), *dbc)));
        Some(profile.unwrap_or_else(|problems| panic!("the profile that came with the program is broken:\n{problems}")))
    }

    /// Names of the profiles that the program brings along.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        BUILTIN.iter().map(|&(name, ..)| name)
    }

    /// A profile that the program brings along, by its name, or any other by
    /// the path of its TOML file; its DBC's path counts from there.
    pub fn load(name_or_path: &str) -> Result<Self, Problems> {
        if let Some(profile) = Self::builtin(name_or_path) {
            return Ok(profile);
        }
        let path = Path::new(name_or_path);
        if path.extension().is_none_or(|extension| extension != "toml") {
            let names = Self::builtin_names().collect::<Vec<_>>().join(", ");
            return Err(Problem::bare(format!("there is no drive profile {name_or_path:?}"))
                .help(format!("expected one of {names}, or the path of a .toml file"))
                .into());
        }
        let document = Document::read(path)?;
        let dbc = profile_reader::dbc_source(&document, path.parent().unwrap_or(Path::new("")))?;
        Self::parse(&document, &dbc)
    }

    /// A profile from its TOML and the text of its DBC.
    pub fn parse(toml: &Document, dbc: &Arc<Source>) -> Result<Self, Problems> {
        let dbc = Dbc::parse(dbc)?;
        let reader = Reader::new(toml);
        let profile = profile_reader::profile(&reader.root(), toml, dbc);
        let profile = reader.finish(profile)?;
        Ok(profile.expect("what keeps a profile from being made is reported to the reader"))
    }

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

    /// Whether commands are counted.
    pub const fn command_has_counter(&self) -> bool {
        self.command.wheels.right.counter.is_some()
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

    /// The torques that a command to this wheel's drive can ask for.
    pub fn command_torque(&self, wheel: Wheel) -> TorqueScale {
        self.command.wheels[wheel].torque.scale
    }

    /// What a command of `torque_nm` really asks for, N m: what the frame can say.
    pub fn torque_as_said(&self, wheel: Wheel, torque_nm: f64) -> f64 {
        let role = &self.command.wheels[wheel];
        let mut data = [0; 64];
        role.write(&mut data, &Command { torque_nm, ..Command::default() });
        role.torque.decode(&data).unwrap_or(0.0)
    }

    /// The torques that this wheel's drive can report as applied, if it does.
    pub fn applied_torque(&self, wheel: Wheel) -> Option<TorqueScale> {
        self.first(wheel, |part| part.torque_applied.as_ref()).map(|torque| torque.scale)
    }

    /// How this wheel's drive counts its position, if it does.
    pub fn position_scale(&self, wheel: Wheel) -> Option<PositionScale> {
        self.first(wheel, |part| part.position.as_ref()).map(|position| position.scale)
    }

    /// The position that a drive reports at this encoder count, 0 if it reports none.
    #[inline]
    pub fn position_at_count(&self, wheel: Wheel, count: i64) -> f64 {
        let position = self.first(wheel, |part| part.position.as_ref());
        position.map_or(0.0, |position| count as f64 * position.units_per_count)
    }

    /// The smallest step of the speed that this wheel's drive reports, rad/s, if
    /// it reports any.
    pub fn speed_resolution_rad_s(&self, wheel: Wheel) -> Option<f64> {
        self.first(wheel, |part| part.speed.as_ref()).map(|speed| speed.resolution_rad_s())
    }

    /// The counter that follows `counter` in commands to this wheel.
    pub fn next_command_counter(&self, wheel: Wheel, counter: u8) -> u8 {
        self.command.wheels[wheel].counter.as_ref().map_or(0, |signal| signal.next_counter(counter))
    }

    /// The counter of this wheel's feedback that answers a SYNC with
    /// `sync_counter`, or comes after a feedback with one less.
    #[inline]
    pub fn feedback_counter(&self, wheel: Wheel, sync_counter: u8) -> Option<u8> {
        self.first(wheel, |part| part.counter.as_ref()).map(|signal| signal.low_bits(sync_counter))
    }

    /// The arbitration ids of feedback.
    pub fn is_feedback(&self, id: CanId) -> bool {
        matches!(self.roles.get(id), Some((Role::Feedback(_), _)))
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

    /// The counter that follows `counter` in SYNC.
    pub fn next_sync_counter(&self, counter: u8) -> u8 {
        let signal = self.sync.as_ref().and_then(|sync| sync.counter.as_ref());
        signal.map_or(0, |signal| signal.next_counter(counter))
    }

    /// Keys of the nameplate without which the numbers mean nothing.
    pub fn needs_of_plate(&self) -> Vec<&'static str> {
        let applied = self.first(Wheel::Right, |part| part.torque_applied.as_ref());
        let position = self.first(Wheel::Right, |part| part.position.as_ref());
        let speed = self.first(Wheel::Right, |part| part.speed.as_ref());
        let mut keys: Vec<_> = [
            self.command.wheels.right.torque.unit.needs(),
            applied.and_then(|torque| torque.unit.needs()),
            position.and_then(|position| position.unit.needs()),
            speed.and_then(|speed| speed.unit.needs()),
        ]
        .into_iter()
        .flatten()
        .collect();
        keys.dedup();
        keys
    }

    /// Reads and writes all quantities as this motor has them.
    pub fn fit(&mut self, motor: &Motor) {
        for wheel in Wheel::BOTH {
            self.command.wheels[wheel].torque.fit(motor);
            for part in &mut self.feedback {
                let part = &mut part.wheels[wheel];
                part.position.iter_mut().for_each(|position| position.fit(motor));
                part.speed.iter_mut().for_each(|speed| speed.fit(motor));
                part.torque_applied.iter_mut().for_each(|torque| torque.fit(motor));
            }
        }
    }

    /// Every message with what it is for and whose it is.
    pub(super) fn list_roles(&self, mut tell: impl FnMut(CanId, Role, Of)) {
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

    #[inline]
    fn first<'p, T>(&'p self, wheel: Wheel, of: impl Fn(&'p FeedbackRole) -> Option<&'p T>) -> Option<&'p T> {
        self.feedback.iter().find_map(|part| of(&part.wheels[wheel]))
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
