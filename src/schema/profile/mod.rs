//! A drive profile: which message and signal of a DBC carries what. Both ends
//! of the bus read the same one.

mod codec;
mod frames;
mod loading;
mod overrides;
mod reader;
mod scales;
mod traffic;
pub(in crate::schema) mod words;

use crate::schema::addressing::Addressing;
use crate::schema::conversation::{Conversation, Watchdog};
use crate::schema::dbc::Dbc;
use crate::schema::role_table::RoleTable;
use crate::schema::roles::{CommandRole, FaultRole, FeedbackRole, HeartbeatRole, SyncRole, WordRole};
use crate::schema::units::Nameplate;
use crate::time::Duration;
use crate::wheels::Wheels;

pub use traffic::{Cause, Recurring};

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
    pub(in crate::schema) addressing: Addressing,
    pub(in crate::schema) sync: Option<SyncRole>,
    pub(in crate::schema) command: Shared<CommandRole>,
    pub(in crate::schema) feedback: Vec<Shared<FeedbackRole>>,
    pub(in crate::schema) heartbeat: Option<Shared<HeartbeatRole>>,
    pub(in crate::schema) fault: Option<Shared<FaultRole>>,
    pub(in crate::schema) words: Wheels<Vec<WordRole>>,
    pub(in crate::schema) roles: RoleTable,
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
pub(in crate::schema) struct Shared<T> {
    pub wheels: Wheels<T>,
    pub is_shared: bool,
}
