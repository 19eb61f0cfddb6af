//! From a profile's TOML to the roles of its DBC's messages.

use std::path::Path;
use std::sync::Arc;

use super::checksum::Crc8;
use super::dbc::{Dbc, MessageLayout};
use super::linker::{Linker, Words};
use super::message::{DriveState, FaultCode, Request};
use super::profile::{Profile, Role, RoleTable};
use super::roles::{CommandRole, FaultRole, FeedbackRole, HeartbeatRole, SyncRole};
use crate::config::{Document, Problem, Reader, Section, Source};
use crate::frame::CanId;
use crate::time::Duration;
use crate::wheels::{Wheel, Wheels};

const REQUESTS: [(&str, Request); 3] =
    [("disable", Request::Disable), ("enable", Request::Enable), ("clear_fault", Request::ClearFault)];

const STATES: [(&str, DriveState); 4] = [
    ("boot", DriveState::Boot),
    ("ready", DriveState::Ready),
    ("enabled", DriveState::Enabled),
    ("fault", DriveState::Fault),
];

const FAULTS: [(&str, FaultCode); 7] = [
    ("none", FaultCode::None),
    ("command_timeout", FaultCode::CommandTimeout),
    ("command_corrupt", FaultCode::CommandCorrupt),
    ("over_current", FaultCode::OverCurrent),
    ("over_temperature", FaultCode::OverTemperature),
    ("under_voltage", FaultCode::UnderVoltage),
    ("encoder", FaultCode::Encoder),
];

/// The DBC that a profile names, read from beside it.
pub(super) fn dbc_source(toml: &Document, folder: &Path) -> Result<Arc<Source>, Problem> {
    let reader = Reader::new(toml);
    let root = reader.root();
    let Some(name) = root.text_or_none("dbc") else {
        return Err(root.problem("dbc", "no DBC file is named", "expected dbc = \"FILE.dbc\", seen from here"));
    };
    Dbc::read_source(&folder.join(name)).map_err(|problem| root.problem("dbc", &problem.title, "named here"))
}

/// Reads all of a profile. `None` only when a problem was reported.
pub(super) fn profile(root: &Section<'_>, toml: &Document, dbc: Dbc) -> Option<Profile> {
    let name = root.text("name");
    root.text("dbc");
    let profile = ProfileReader::new(root, &dbc);
    // All of them before the first `?`, so that no problem hides another.
    let (sync, command, feedback) = (profile.sync(), profile.command(), profile.feedback());
    let (heartbeat, fault) = (profile.heartbeat(), profile.fault());
    let command_timeout_periods = profile.command.integer("timeout_periods", 1, 1000) as u32;
    let node_ids = profile.linker.node_ids();
    let ((heartbeat_period, heartbeat), fault) = (heartbeat?, fault?);
    let (sync, command, feedback) = (sync?, command?, feedback?);
    let mut roles = RoleTable::new();
    let mut assign = |section: &Section<'_>, id: CanId, role: Role| {
        if !roles.insert(id, role) {
            section.complain("message", &format!("found id {id}, which another message of the profile has already"));
        }
    };
    assign(&profile.sync, sync.envelope.id, Role::Sync);
    for wheel in Wheel::BOTH {
        assign(&profile.command, command[wheel].envelope.id, Role::Command(wheel));
        assign(&profile.feedback, feedback[wheel].envelope.id, Role::Feedback(wheel));
        assign(&profile.heartbeat, heartbeat[wheel].envelope.id, Role::Heartbeat(wheel));
        assign(&profile.fault, fault[wheel].envelope.id, Role::Fault(wheel));
    }
    Some(Profile {
        name,
        toml_text: toml.text().to_owned(),
        node_ids,
        heartbeat_period,
        command_timeout_periods,
        sync,
        command,
        feedback,
        heartbeat,
        fault,
        roles,
        dbc,
    })
}

/// The sections of a profile, opened.
struct ProfileReader<'r> {
    linker: Linker<'r>,
    sync: Section<'r>,
    command: Section<'r>,
    feedback: Section<'r>,
    heartbeat: Section<'r>,
    fault: Section<'r>,
    requests: Words<'r, Request>,
    states: Words<'r, DriveState>,
    faults: Words<'r, FaultCode>,
}

impl<'r> ProfileReader<'r> {
    fn new(root: &Section<'r>, dbc: &'r Dbc) -> Self {
        let values = root.section("values");
        Self {
            linker: Linker::new(dbc, &root.section("wheels"), crc(root)),
            sync: open(root, "sync", &["message", "counter", "crc"]),
            command: open(root, "command", &["message", "torque", "torque_at", "request", "counter", "crc"]),
            feedback: open(
                root,
                "feedback",
                &[
                    "message",
                    "position",
                    "position_at",
                    "torque_applied",
                    "torque_applied_at",
                    "state",
                    "counter",
                    "crc",
                ],
            ),
            heartbeat: open(root, "heartbeat", &["message", "state", "fault", "crc"]),
            fault: open(root, "fault", &["message", "fault", "crc"]),
            requests: Words::new(values.section("request"), &REQUESTS),
            states: Words::new(values.section("state"), &STATES),
            faults: Words::new(values.section("fault"), &FAULTS),
        }
    }

    fn sync(&self) -> Option<SyncRole> {
        let (section, linker) = (&self.sync, &self.linker);
        let message = linker.message(section, None)?;
        let counter = linker.counter(section, "counter", message);
        Some(SyncRole { envelope: linker.envelope(section, message)?, counter: counter? })
    }

    fn command(&self) -> Option<Wheels<CommandRole>> {
        let (section, linker) = (&self.command, &self.linker);
        section.choice("torque_at", &[("wheel", ())], true);
        self.both(section, |message| {
            let torque = linker.torque(section, "torque", message);
            let request = linker.signal(section, "request", message);
            let counter = linker.counter(section, "counter", message);
            let envelope = linker.envelope(section, message);
            let request = request?;
            let requests = linker.values(&self.requests, message, &request)?;
            Some(CommandRole { envelope: envelope?, torque: torque?, request, requests, counter: counter? })
        })
    }

    fn feedback(&self) -> Option<Wheels<FeedbackRole>> {
        let (section, linker) = (&self.feedback, &self.linker);
        section.choice("position_at", &[("motor", ())], true);
        section.choice("torque_applied_at", &[("wheel", ())], true);
        self.both(section, |message| {
            let position = linker.position(section, "position", message);
            let torque_applied = linker.torque(section, "torque_applied", message);
            let state = linker.signal(section, "state", message);
            let counter = linker.counter(section, "counter", message);
            let envelope = linker.envelope(section, message);
            let state = state?;
            let states = linker.values(&self.states, message, &state)?;
            Some(FeedbackRole {
                envelope: envelope?,
                position: position?,
                torque_applied: torque_applied?,
                state,
                states,
                counter: counter?,
            })
        })
    }

    fn heartbeat(&self) -> Option<(Duration, Wheels<HeartbeatRole>)> {
        let (section, linker) = (&self.heartbeat, &self.linker);
        let linked = self.both(section, |message| {
            let state = linker.signal(section, "state", message);
            let fault = linker.signal(section, "fault", message);
            let envelope = linker.envelope(section, message);
            let (state, fault) = (state?, fault?);
            let states = linker.values(&self.states, message, &state);
            let faults = linker.values(&self.faults, message, &fault);
            let role = HeartbeatRole { envelope: envelope?, state, states: states?, fault, faults: faults? };
            Some((message.cycle, role))
        })?;
        let period = linker.cycle(section, linked.as_ref().map(|(cycle, _)| *cycle))?;
        Some((period, linked.map(|(_, role)| role)))
    }

    fn fault(&self) -> Option<Wheels<FaultRole>> {
        let (section, linker) = (&self.fault, &self.linker);
        self.both(section, |message| {
            let fault = linker.signal(section, "fault", message);
            let envelope = linker.envelope(section, message);
            let fault = fault?;
            let faults = linker.values(&self.faults, message, &fault)?;
            Some(FaultRole { envelope: envelope?, fault, faults })
        })
    }

    /// Links the right wheel's message and then, if that went well, the
    /// left's: what is wrong with a name is wrong for both.
    fn both<T>(&self, section: &Section<'_>, link: impl Fn(&MessageLayout) -> Option<T>) -> Option<Wheels<T>> {
        let right = link(self.linker.message(section, Some(Wheel::Right))?)?;
        let left = link(self.linker.message(section, Some(Wheel::Left))?)?;
        Some(Wheels { right, left })
    }
}

/// Opens a section and notes the keys it may have: a role that cannot be
/// linked stops asking, and a key that nobody asked for is reported.
fn open<'r>(root: &Section<'r>, name: &str, keys: &[&str]) -> Section<'r> {
    let section = root.section(name);
    for key in keys {
        section.has(key);
    }
    section
}

/// The CRC and how many bytes of the id it covers.
fn crc(root: &Section<'_>) -> Option<(Crc8, usize)> {
    if !root.has("crc") {
        return None;
    }
    let section = root.section("crc");
    let byte = |key| section.integer(key, 0, 0xFF) as u8;
    let crc = Crc8::new(byte("polynomial"), byte("initial"), byte("final_xor"));
    Some((crc, section.integer("id_bytes", 0, 4) as usize))
}
