//! A drive profile: which message and signal of a DBC carries what. Both ends
//! of the bus read the same one.

use std::path::Path;
use std::sync::Arc;

use super::dbc::Dbc;
use super::decode_error::DecodeError;
use super::message::Message;
use super::profile_reader;
use super::roles::{CommandRole, FaultRole, FeedbackRole, HeartbeatRole, SyncRole, TorqueScale};
use crate::config::{Document, Problem, Problems, Reader, Source};
use crate::frame::{CanId, Frame};
use crate::time::Duration;
use crate::wheels::{Wheel, Wheels};

/// Profiles that the program brings along: name, TOML, DBC.
const BUILTIN: [(&str, &str, &str); 1] =
    [("wheel_drive", include_str!("../../dbc/wheel_drive.toml"), include_str!("../../dbc/wheel_drive.dbc"))];

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
    /// How often a drive gives a sign of life.
    pub heartbeat_period: Duration,
    /// After so many periods without a valid command a drive stops by itself.
    pub command_timeout_periods: u32,
    pub(super) sync: SyncRole,
    pub(super) command: Wheels<CommandRole>,
    pub(super) feedback: Wheels<FeedbackRole>,
    pub(super) heartbeat: Wheels<HeartbeatRole>,
    pub(super) fault: Wheels<FaultRole>,
    pub(super) roles: RoleTable,
}

/// What a message is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Sync,
    Command(Wheel),
    Feedback(Wheel),
    Heartbeat(Wheel),
    Fault(Wheel),
}

/// Roles by arbitration id.
#[derive(Clone, Debug)]
pub(super) struct RoleTable {
    /// One for each of the 2048 standard ids.
    standard: Vec<Option<Role>>,
    extended: Vec<(u32, Role)>,
}

impl Profile {
    /// The profile of this name that the program brings along.
    pub fn builtin(name: &str) -> Option<Self> {
        let (name, toml, dbc) = BUILTIN.into_iter().find(|(known, ..)| *known == name)?;
        let profile = Document::parse(format!("{name}.toml"), toml)
            .map_err(Problems::from)
            .and_then(|document| Self::parse(&document, &Source::new(format!("{name}.dbc"), dbc)));
        Some(profile.unwrap_or_else(|problems| panic!("the profile that came with the program is broken:\n{problems}")))
    }

    /// Names of the profiles that the program brings along.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        BUILTIN.into_iter().map(|(name, ..)| name)
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

    /// The frame that carries `message`. A torque out of range becomes the
    /// nearest that the frame can carry, NaN becomes 0. Allocates nothing.
    #[inline]
    pub fn encode(&self, message: &Message) -> Frame {
        match message {
            Message::Sync { counter } => self.sync.encode(*counter),
            Message::Command(wheel, command) => self.command[*wheel].encode(command),
            Message::Feedback(wheel, feedback) => self.feedback[*wheel].encode(feedback),
            Message::Heartbeat(wheel, heartbeat) => self.heartbeat[*wheel].encode(heartbeat),
            Message::Fault(wheel, fault) => self.fault[*wheel].encode(*fault),
        }
    }

    /// What a frame says, if all of it is right. Allocates nothing.
    #[inline]
    pub fn decode(&self, frame: &Frame) -> Result<Message, DecodeError> {
        match self.roles.get(frame.id).ok_or(DecodeError::UnknownId)? {
            Role::Sync => self.sync.decode(frame).map(|counter| Message::Sync { counter }),
            Role::Command(wheel) => self.command[wheel].decode(frame).map(|command| Message::Command(wheel, command)),
            Role::Feedback(wheel) => self.feedback[wheel].decode(frame).map(|report| Message::Feedback(wheel, report)),
            Role::Heartbeat(wheel) => self.heartbeat[wheel].decode(frame).map(|life| Message::Heartbeat(wheel, life)),
            Role::Fault(wheel) => self.fault[wheel].decode(frame).map(|fault| Message::Fault(wheel, fault)),
        }
    }

    /// The torques that a command to this wheel's drive can ask for.
    pub fn command_torque(&self, wheel: Wheel) -> TorqueScale {
        self.command[wheel].torque.scale
    }

    /// The torques that this wheel's drive can report as applied.
    pub fn applied_torque(&self, wheel: Wheel) -> TorqueScale {
        self.feedback[wheel].torque_applied.scale
    }

    /// The counter that follows `counter` in commands to this wheel.
    pub fn next_command_counter(&self, wheel: Wheel, counter: u8) -> u8 {
        self.command[wheel].counter.next_counter(counter)
    }

    /// The counter of this wheel's feedback that answers a SYNC with
    /// `sync_counter`.
    pub fn feedback_counter(&self, wheel: Wheel, sync_counter: u8) -> u8 {
        self.feedback[wheel].counter.low_bits(sync_counter)
    }

    /// The arbitration id of SYNC.
    pub fn sync_id(&self) -> CanId {
        self.sync.envelope.id
    }

    /// The arbitration id of this wheel's feedback.
    pub fn feedback_id(&self, wheel: Wheel) -> CanId {
        self.feedback[wheel].envelope.id
    }

    /// The ids of all that drives send.
    pub fn drive_ids(&self) -> impl Iterator<Item = CanId> {
        Wheel::BOTH.into_iter().flat_map(|wheel| {
            [&self.feedback[wheel].envelope, &self.heartbeat[wheel].envelope, &self.fault[wheel].envelope]
                .map(|envelope| envelope.id)
        })
    }

    /// The counter that follows `counter` in SYNC.
    pub fn next_sync_counter(&self, counter: u8) -> u8 {
        self.sync.counter.next_counter(counter)
    }
}

impl RoleTable {
    pub fn new() -> Self {
        Self { standard: vec![None; 1 << 11], extended: Vec::new() }
    }

    /// Gives `id` a role; false when it has one already.
    pub fn insert(&mut self, id: CanId, role: Role) -> bool {
        if self.get(id).is_some() {
            return false;
        }
        match id {
            CanId::Standard(id) => self.standard[usize::from(id)] = Some(role),
            CanId::Extended(id) => self.extended.push((id, role)),
        }
        true
    }

    #[inline]
    fn get(&self, id: CanId) -> Option<Role> {
        match id {
            CanId::Standard(id) => self.standard.get(usize::from(id)).copied().flatten(),
            CanId::Extended(id) => self.extended.iter().find(|(known, _)| *known == id).map(|(_, role)| *role),
        }
    }
}
