//! From a profile's TOML to the roles of its DBC's messages.

use std::path::Path;
use std::sync::Arc;

use super::checksum::Crc8;
use super::conversation_reader::ConversationReader;
use super::dbc::Dbc;
use super::encoding::Rounding;
use super::envelope::CrcRule;
use super::linker::{Linked, Linker, NODE};
use super::message::FaultCode;
use super::pattern::Field;
use super::profile::{Acts, Addressing, Applied, Asks, Profile, Shared};
use super::quantities::{Position, PositionScale, Speed, Torque, TorqueScale};
use super::role_table::{Role, RoleTable};
use super::roles::{CommandRole, FaultRole, FeedbackRole, HeartbeatRole, SyncRole, WordRole};
use super::units::{Motor, Nameplate, POSITION_UNITS, SIDES, SPEED_UNITS, TORQUE_UNITS};
use crate::config::{Document, Problem, Section, Source};
use crate::time::Duration;
use crate::wheels::{Wheel, Wheels};

pub(super) const FAULTS: [(&str, FaultCode); 12] = [
    ("none", FaultCode::None),
    ("command_timeout", FaultCode::CommandTimeout),
    ("command_corrupt", FaultCode::CommandCorrupt),
    ("over_current", FaultCode::OverCurrent),
    ("over_temperature", FaultCode::OverTemperature),
    ("motor_over_temperature", FaultCode::MotorOverTemperature),
    ("under_voltage", FaultCode::UnderVoltage),
    ("over_voltage", FaultCode::OverVoltage),
    ("overload", FaultCode::Overload),
    ("encoder", FaultCode::Encoder),
    ("emergency_stop", FaultCode::EmergencyStop),
    ("other", FaultCode::Other),
];

const ASKS: [(&str, Asks); 4] =
    [("sync", Asks::BySync), ("poll", Asks::ByPoll), ("command", Asks::ByCommand), ("nothing", Asks::Nothing)];

const ACTS: [(&str, Acts); 2] = [("at sync", Acts::AtSync), ("on arrival", Acts::OnArrival)];

const APPLIED: [(&str, Applied); 3] =
    [("the last", Applied::TheLast), ("the mean", Applied::TheMean), ("coarse", Applied::Coarse)];

const ROUNDINGS: [(&str, Rounding); 2] = [("nearest", Rounding::Nearest), ("truncate", Rounding::TowardsZero)];

const SYNC_KEYS: [&str; 3] = ["message", "counter", "crc"];
const COMMAND_KEYS: [&str; 11] = [
    "shortest", "remainder", "message", "acts", "torque", "torque_unit", "torque_at", "constants", "mode", "counter", "crc"];
const FEEDBACK_KEYS: [&str; 19] = [
    "message",
    "shortest",
    "constants",
    "position",
    "position_unit",
    "position_at",
    "speed",
    "speed_unit",
    "speed_at",
    "torque_applied",
    "torque_applied_unit",
    "torque_applied_at",
    "torque_applied_is",
    "state",
    "shown_as",
    "fault",
    "mode",
    "counter",
    "crc",
];
const HEARTBEAT_KEYS: [&str; 6] = ["message", "state", "shown_as", "state_elsewhere", "fault", "crc"];
const FAULT_KEYS: [&str; 3] = ["message", "fault", "crc"];

/// Feedback that comes in more messages than this is too much for a period.
const MOST_PARTS: usize = 8;

/// The DBC that a profile names, read from beside it.
pub(super) fn dbc_source(toml: &Document, folder: &Path) -> Result<Arc<Source>, Problem> {
    let reader = crate::config::Reader::new(toml);
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
    let reader = ProfileReader::new(root, &dbc);
    // All of them before the first `?`, so that no problem hides another.
    let (sync, command, feedback) = (reader.sync(root), reader.command(), reader.feedback());
    let (heartbeat, fault, words) = (reader.heartbeat(root), reader.fault(root), reader.words());
    let conversation = reader.conversation.conversation();
    let watchdog = reader.conversation.watchdog(root);
    let node_ids = reader.linker.node_ids();
    let broadcast = root.section("wheels");
    let broadcast = broadcast.has("broadcast_id").then(|| broadcast.integer("broadcast_id", 0, 0xFF) as u8);
    let addressing = Addressing { mask: reader.linker.node_id_mask, broadcast };
    let plate = Nameplate::read(&root.section("motor"), &Nameplate::default());
    let applied = reader.feedback.iter().find(|section| section.has("torque_applied"));
    let applied = applied.map_or(Applied::default(), |section| section.choice("torque_applied_is", &APPLIED, false));
    let carries_remainder = reader.command.choice("remainder", &[("carried", true), ("dropped", false)], false);
    let (asks, acts) = (reader.asks, reader.command.choice("acts", &ACTS, true));
    let (sync, command, (feedback_period, feedback)) = (sync?, command?, feedback?);
    let ((heartbeat_period, heartbeat), fault, words) = (heartbeat?, fault?, words?);
    if sync.is_none() && (asks == Asks::BySync || acts == Acts::AtSync) {
        root.complain("asks_with", "found drives that wait for a SYNC, expected a table [sync] that names it");
        return None;
    }
    let tells_state = feedback.iter().any(|part| part.wheels.right.state.is_some())
        || heartbeat.as_ref().is_some_and(|heartbeat| heartbeat.wheels.right.state.is_some());
    let counter_echoes_sync = sync.as_ref().is_some_and(|sync| sync.counter.is_some());
    let mut profile = Profile {
        name,
        toml_text: toml.text().to_owned(),
        node_ids,
        addressing,
        plate,
        asks,
        acts,
        carries_remainder,
        feedback_period,
        heartbeat_period,
        watchdog,
        conversation,
        tells_state,
        applied,
        counter_echoes_sync,
        sync,
        command,
        feedback,
        heartbeat,
        fault,
        words,
        roles: RoleTable::new(),
        dbc: dbc.clone(),
    };
    profile.fit(&Motor { counts_per_turn: 1, gear_ratio: 1.0, plate });
    reader.assign_roles(root, &mut profile);
    Some(profile)
}

/// The sections of a profile, opened.
struct ProfileReader<'r> {
    linker: Linker<'r>,
    conversation: ConversationReader<'r>,
    asks: Asks,
    rounding: Rounding,
    sync: Section<'r>,
    command: Section<'r>,
    feedback: Vec<Section<'r>>,
    heartbeat: Section<'r>,
    fault: Section<'r>,
}

impl<'r> ProfileReader<'r> {
    fn new(root: &Section<'r>, dbc: &'r Dbc) -> Self {
        let feedback = root.sections("feedback");
        if feedback.is_empty() || feedback.len() > MOST_PARTS {
            root.complain(
                "feedback",
                &format!("found {} tables [[feedback]], expected 1 to {MOST_PARTS}", feedback.len()),
            );
        }
        feedback.iter().for_each(|section| section.allow(&FEEDBACK_KEYS));
        Self {
            linker: Linker::new(dbc, &root.section("wheels"), crc(root)),
            conversation: ConversationReader::new(root),
            asks: root.choice("asks_with", &ASKS, true),
            rounding: root.choice("rounding", &ROUNDINGS, false),
            sync: open(root, "sync", &SYNC_KEYS),
            command: open(root, "command", &COMMAND_KEYS),
            feedback,
            heartbeat: open(root, "heartbeat", &HEARTBEAT_KEYS),
            fault: open(root, "fault", &FAULT_KEYS),
        }
    }

    fn sync(&self, root: &Section<'_>) -> Option<Option<SyncRole>> {
        if !root.has("sync") {
            return Some(None);
        }
        let (section, linker) = (&self.sync, &self.linker);
        let message = linker.message(section, None)?;
        let counter = self.counter(section, message);
        Some(Some(SyncRole { envelope: linker.envelope(section, message)?, counter: counter? }))
    }

    fn command(&self) -> Option<Shared<CommandRole>> {
        let (section, linker) = (&self.command, &self.linker);
        self.both(section, |message| {
            let torque = self.torque(section, "torque", message);
            let counter = self.counter(section, message);
            let envelope = linker.envelope(section, message);
            let constants = self.constants(section, message);
            let mode = self.mode(section, message);
            let words = self.conversation.in_command(linker, message)?;
            Some(CommandRole {
                envelope: envelope?,
                torque: torque?,
                constants: constants?,
                words,
                mode: mode?,
                counter: counter?,
            })
        })
    }

    /// All parts, and how often a drive sends those that nobody asks for.
    fn feedback(&self) -> Option<(Option<Duration>, Vec<Shared<FeedbackRole>>)> {
        let linked = self.feedback.iter().enumerate().map(|(part, section)| self.feedback_part(part as u8, section));
        // All of them, so that no problem hides another.
        let linked: Vec<_> = linked.collect();
        let linked = linked.into_iter().collect::<Option<Vec<_>>>()?;
        let section = self.feedback.first()?;
        let has_motion =
            linked.iter().any(|(_, part)| part.wheels.all(|part| part.position.is_some() || part.speed.is_some()));
        if !has_motion {
            section.complain("message", "found feedback without `position` and without `speed`, expected one of them");
            return None;
        }
        let cycle = linked.iter().map(|(cycle, _)| *cycle).max().flatten();
        if self.asks == Asks::Nothing && cycle.is_none() {
            section.complain("message", "found no GenMsgCycleTime, expected one, for nothing asks for this message");
            return None;
        }
        Some((cycle, linked.into_iter().map(|(_, part)| part).collect()))
    }

    fn feedback_part(&self, part: u8, section: &Section<'_>) -> Option<(Option<Duration>, Shared<FeedbackRole>)> {
        let linker = &self.linker;
        let linked = self.both(section, |message| {
            let position = if section.has("position") { self.position(section, message).map(Some) } else { Some(None) };
            let speed = if section.has("speed") { self.speed(section, message).map(Some) } else { Some(None) };
            let has_torque = section.has("torque_applied");
            let torque =
                if has_torque { self.torque(section, "torque_applied", message).map(Some) } else { Some(None) };
            let state = self.conversation.state_field(section, linker, message);
            let fault = self.conversation.fault_field(section, linker, message);
            let mode = self.mode(section, message);
            let counter = self.counter(section, message);
            let constants = self.constants(section, message);
            let role = FeedbackRole {
                envelope: linker.envelope(section, message)?,
                part,
                constants: constants?,
                position: position?,
                speed: speed?,
                torque_applied: torque?,
                state: state?,
                fault: fault?,
                mode: mode?,
                counter: counter?,
            };
            Some((message.layout.cycle, role))
        })?;
        let Shared { wheels, is_shared } = linked;
        Some((wheels.right.0, Shared { wheels: wheels.map(|(_, role)| role), is_shared }))
    }

    fn heartbeat(&self, root: &Section<'_>) -> Option<(Option<Duration>, Option<Shared<HeartbeatRole>>)> {
        if !root.has("heartbeat") {
            return Some((None, None));
        }
        let (section, linker) = (&self.heartbeat, &self.linker);
        let linked = self.both(section, |message| {
            let state = self.conversation.state_field(section, linker, message);
            let fault = self.conversation.fault_field(section, linker, message);
            let envelope = linker.envelope(section, message)?;
            Some((message.layout.cycle, HeartbeatRole { envelope, state: state?, fault: fault? }))
        })?;
        let Shared { wheels, is_shared } = linked;
        let period = linker.cycle(section, wheels.as_ref().map(|(cycle, _)| *cycle))?;
        Some((Some(period), Some(Shared { wheels: wheels.map(|(_, role)| role), is_shared })))
    }

    fn fault(&self, root: &Section<'_>) -> Option<Option<Shared<FaultRole>>> {
        if !root.has("fault") {
            return Some(None);
        }
        let (section, linker) = (&self.fault, &self.linker);
        let linked = self.both(section, |message| {
            let envelope = linker.envelope(section, message);
            linker.signal(section, "fault", message)?;
            let fault = self.conversation.fault_field(section, linker, message)??;
            Some(FaultRole { envelope: envelope?, fault })
        })?;
        Some(Some(linked))
    }

    fn words(&self) -> Option<Wheels<Vec<WordRole>>> {
        let right = self.conversation.beside(&self.linker, Wheel::Right)?;
        Some(Wheels { right, left: self.conversation.beside(&self.linker, Wheel::Left)? })
    }

    fn constants(&self, section: &Section<'_>, message: Linked<'_>) -> Option<Vec<Field>> {
        let constants = section.section("constants");
        constants.allow(&constants.keys());
        let fields = constants.keys().into_iter().map(|key| {
            let signal = self.linker.signal_named(&constants, key, key, message)?;
            Some(Field { pattern: self.linker.pattern(&constants, key, message, &signal)?, signal })
        });
        fields.collect()
    }

    fn counter(&self, section: &Section<'_>, message: Linked<'_>) -> Option<Option<super::signal::Signal>> {
        let asked = section.has("counter").then(|| self.linker.counter(section, "counter", message));
        asked.map_or(Some(None), |linked| linked.map(Some))
    }

    fn mode(&self, section: &Section<'_>, message: Linked<'_>) -> Option<Option<super::signal::Signal>> {
        if !section.has("mode") {
            return Some(None);
        }
        let signal = self.linker.signal(section, "mode", message)?;
        self.linker.unless(!signal.is_integer(), section, "mode", &signal, "a whole number, factor 1, offset 0")?;
        Some(Some(signal))
    }

    fn torque(&self, section: &Section<'_>, key: &str, message: Linked<'_>) -> Option<Torque> {
        let unit = section.choice(&format!("{key}_unit"), &TORQUE_UNITS, false);
        let side = section.choice(&format!("{key}_at"), &SIDES, true);
        let signal = self.linker.signal(section, key, message)?;
        let scale = TorqueScale::default();
        let mut torque = Torque { signal, unit, side, rounding: self.rounding, nm_per_unit: 1.0, scale };
        torque.fit(&Motor { counts_per_turn: 1, gear_ratio: 1.0, plate: Nameplate::default() });
        let TorqueScale { minimum_nm, maximum_nm, .. } = torque.scale;
        let sound = minimum_nm <= 0.0 && maximum_nm >= 0.0 && (maximum_nm - minimum_nm).is_finite();
        self.linker.unless(!sound, section, key, &torque.signal, "a finite range that includes 0")?;
        Some(torque)
    }

    fn position(&self, section: &Section<'_>, message: Linked<'_>) -> Option<Position> {
        let unit = section.choice("position_unit", &POSITION_UNITS, true);
        let side = section.choice("position_at", &SIDES, true);
        let signal = self.linker.signal(section, "position", message)?;
        let is_count = unit == super::units::PositionUnit::Counts;
        let sound =
            if is_count { signal.is_integer() } else { true } && (signal.is_float() || signal.bit_count() <= 48);
        let expected = if is_count {
            "a whole number of at most 48 bits, factor 1, offset 0"
        } else {
            "a whole number of at most 48 bits or a floating-point one"
        };
        self.linker.unless(!sound, section, "position", &signal, expected)?;
        Some(Position { signal, unit, side, units_per_count: 1.0, is_count: false, scale: PositionScale::default() })
    }

    fn speed(&self, section: &Section<'_>, message: Linked<'_>) -> Option<Speed> {
        let unit = section.choice("speed_unit", &SPEED_UNITS, true);
        let side = section.choice("speed_at", &SIDES, true);
        let signal = self.linker.signal(section, "speed", message)?;
        Some(Speed { signal, unit, side, rounding: self.rounding, rad_s_per_unit: 1.0 })
    }

    /// Links the right wheel's part of a message and then, if that went well,
    /// the left's: what is wrong with a name is wrong for both.
    fn both<T>(&self, section: &Section<'_>, link: impl Fn(Linked<'_>) -> Option<T>) -> Option<Shared<T>> {
        let right = link(self.linker.message(section, Some(Wheel::Right))?)?;
        let left = link(self.linker.message(section, Some(Wheel::Left))?)?;
        let is_shared = !section.text("message").contains(NODE);
        Some(Shared { wheels: Wheels { right, left }, is_shared })
    }

    fn assign_roles(&self, root: &Section<'_>, profile: &mut Profile) {
        let mut roles = std::mem::replace(&mut profile.roles, RoleTable::new());
        profile.list_roles(|id, role, of| {
            let is_free = roles.insert(id, role, of);
            if !is_free {
                let section = match role {
                    Role::Sync => &self.sync,
                    Role::Command => &self.command,
                    Role::Feedback(part) => &self.feedback[usize::from(part)],
                    Role::Heartbeat => &self.heartbeat,
                    Role::Fault => &self.fault,
                    Role::Word => root,
                };
                let found = format!("found id {id}, which another message of the profile has already");
                section.complain(if role == Role::Word { "words" } else { "message" }, &found);
            }
        });
        profile.roles = roles;
    }
}

/// Opens a section and notes the keys it may have: a role that cannot be
/// linked stops asking, and a key that nobody asked for is reported.
fn open<'r>(root: &Section<'r>, name: &str, keys: &[&str]) -> Section<'r> {
    let section = root.section(name);
    section.allow(keys);
    section
}

/// The CRC and what it covers.
fn crc(root: &Section<'_>) -> Option<CrcRule> {
    if !root.has("crc") {
        return None;
    }
    let section = root.section("crc");
    let byte = |key| section.integer(key, 0, 0xFF) as u8;
    Some(CrcRule {
        crc: Crc8::new(byte("polynomial"), byte("initial"), byte("final_xor")),
        id_bytes: section.integer("id_bytes", 0, 4) as usize,
        is_reversed: section.choice("order", &[("first to last", false), ("last to first", true)], false),
    })
}
