//! From a profile's TOML to the roles of its DBC's messages.

use super::words::{
    ACTS, APPLIED, ASKS, COMMAND_KEYS, FAULT_KEYS, FEEDBACK_KEYS, HEARTBEAT_KEYS, ROUNDINGS, SYNC_KEYS,
};
use super::{Acts, Applied, Asks, Profile, Shared};
use crate::config::{Document, Section};
use crate::schema::addressing::Addressing;
use crate::schema::checksum::Crc8;
use crate::schema::conversation_reader::ConversationReader;
use crate::schema::dbc::Dbc;
use crate::schema::envelope::CrcRule;
use crate::schema::linker::{Linked, Linker, NODE};
use crate::schema::role_signals::RoleSignals;
use crate::schema::role_table::{Role, RoleTable};
use crate::schema::roles::{CommandRole, FaultRole, FeedbackRole, HeartbeatRole, SyncRole, WordRole};
use crate::schema::units::{Motor, Nameplate};
use crate::time::Duration;
use crate::wheels::{Wheel, Wheels};

/// Feedback that comes in more messages than this is too much for a period.
const MOST_PARTS: usize = 8;

/// Reads all of a profile. `None` only when a problem was reported.
pub(in crate::schema) fn profile(root: &Section<'_>, toml: &Document, dbc: Dbc) -> Option<Profile> {
    let name = root.text("name");
    root.text("dbc");
    let reader = ProfileReader::new(root, &dbc);
    // All of them before the first `?`, so that no problem hides another.
    let (sync, command, feedback) = (reader.sync(root), reader.command(), reader.feedback());
    let (heartbeat, fault, words) = (reader.heartbeat(root), reader.fault(root), reader.words());
    let conversation = reader.conversation.conversation();
    let watchdog = reader.conversation.watchdog(root);
    let node_ids = reader.signals.linker.node_ids();
    let broadcast = root.section("wheels");
    let broadcast = broadcast.has("broadcast_id").then(|| broadcast.integer("broadcast_id", 0, 0xFF) as u8);
    let addressing = Addressing { mask: reader.signals.linker.node_id_mask, broadcast };
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
    signals: RoleSignals<'r>,
    conversation: ConversationReader<'r>,
    asks: Asks,
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
            signals: RoleSignals {
                linker: Linker::new(dbc, &root.section("wheels"), crc(root)),
                rounding: root.choice("rounding", &ROUNDINGS, false),
            },
            conversation: ConversationReader::new(root),
            asks: root.choice("asks_with", &ASKS, true),
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
        let (section, linker) = (&self.sync, &self.signals.linker);
        let message = linker.message(section, None)?;
        let counter = self.signals.counter(section, message);
        Some(Some(SyncRole { envelope: linker.envelope(section, message)?, counter: counter? }))
    }

    fn command(&self) -> Option<Shared<CommandRole>> {
        let (section, linker) = (&self.command, &self.signals.linker);
        self.both(section, |message| {
            let torque = self.signals.torque(section, "torque", message);
            let counter = self.signals.counter(section, message);
            let envelope = linker.envelope(section, message);
            let constants = self.signals.constants(section, message);
            let mode = self.signals.mode(section, message);
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
        let linker = &self.signals.linker;
        let linked = self.both(section, |message| {
            let position =
                if section.has("position") { self.signals.position(section, message).map(Some) } else { Some(None) };
            let speed = if section.has("speed") { self.signals.speed(section, message).map(Some) } else { Some(None) };
            let has_torque = section.has("torque_applied");
            let torque =
                if has_torque { self.signals.torque(section, "torque_applied", message).map(Some) } else { Some(None) };
            let state = self.conversation.state_field(section, linker, message);
            let fault = self.conversation.fault_field(section, linker, message);
            let mode = self.signals.mode(section, message);
            let counter = self.signals.counter(section, message);
            let constants = self.signals.constants(section, message);
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
        let (section, linker) = (&self.heartbeat, &self.signals.linker);
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
        let (section, linker) = (&self.fault, &self.signals.linker);
        let linked = self.both(section, |message| {
            let envelope = linker.envelope(section, message);
            linker.signal(section, "fault", message)?;
            let fault = self.conversation.fault_field(section, linker, message)??;
            Some(FaultRole { envelope: envelope?, fault })
        })?;
        Some(Some(linked))
    }

    fn words(&self) -> Option<Wheels<Vec<WordRole>>> {
        let right = self.conversation.beside(&self.signals.linker, Wheel::Right)?;
        Some(Wheels { right, left: self.conversation.beside(&self.signals.linker, Wheel::Left)? })
    }

    /// Links the right wheel's part of a message and then, if that went well,
    /// the left's: what is wrong with a name is wrong for both.
    fn both<T>(&self, section: &Section<'_>, link: impl Fn(Linked<'_>) -> Option<T>) -> Option<Shared<T>> {
        let right = link(self.signals.linker.message(section, Some(Wheel::Right))?)?;
        let left = link(self.signals.linker.message(section, Some(Wheel::Left))?)?;
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
