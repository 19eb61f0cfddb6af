//! Looks up the messages, signals and value names that a profile asks a DBC
//! for. One that leads nowhere is reported at the key that asks, with the
//! names that are most like it, and once, however many roles ask.

use std::cell::RefCell;
use std::collections::BTreeSet;

use super::checksum::Crc8;
use super::dbc::{Dbc, MessageLayout};
use super::roles::{Checksum, Envelope, Torque, TorqueScale};
use super::signal::{Raw, RawKind, Signal};
use super::value_names::ValueNames;
use crate::config::Section;
use crate::frame::Frame;
use crate::time::Duration;
use crate::wheels::{Wheel, Wheels};

/// Stands for the node's name in the name of a message.
const NODE: &str = "{node}";

/// A DBC and how a profile names things in it.
pub(super) struct Linker<'r> {
    dbc: &'r Dbc,
    nodes: Wheels<Node<'r>>,
    /// The bits of an arbitration id that hold the node's number.
    node_id_mask: u32,
    crc: Option<(Crc8, usize)>,
    /// Where in the profile a problem was reported already.
    reported: RefCell<BTreeSet<usize>>,
}

/// One wheel's drive.
struct Node<'r> {
    section: Section<'r>,
    /// Unless it is missing.
    name: Option<String>,
    id: u8,
}

/// What a profile calls the values that mean something to us.
pub(super) struct Words<'r, T> {
    section: Section<'r>,
    /// Our key, the DBC's name, the meaning.
    names: Vec<(&'static str, String, T)>,
}

impl<'r> Linker<'r> {
    /// Reads `[wheels]`; `crc` is the CRC with the bytes of the id it covers.
    pub fn new(dbc: &'r Dbc, wheels: &Section<'r>, crc: Option<(Crc8, usize)>) -> Self {
        let node_id_mask = wheels.integer("node_id_mask", 1, 0x1FFF_FFFF) as u32;
        let nodes = Wheels::from_fn(|wheel| {
            let section = wheels.section(wheel.name());
            Node { name: required(&section, "node"), id: section.integer("id", 0, 0xFF) as u8, section }
        });
        Self { dbc, nodes, node_id_mask, crc, reported: RefCell::default() }
    }

    /// The numbers of the drives.
    pub fn node_ids(&self) -> Wheels<u8> {
        self.nodes.as_ref().map(|node| node.id)
    }

    /// The message that `section` names, for one wheel or for all.
    pub fn message(&self, section: &Section<'_>, wheel: Option<Wheel>) -> Option<&'r MessageLayout> {
        let template = required(section, "message")?;
        let name = match wheel {
            Some(wheel) => template.replace(NODE, self.nodes[wheel].name.as_ref()?),
            None => template.clone(),
        };
        let Some(message) = self.dbc.message(&name) else {
            let names = self.dbc.messages.iter().map(|message| message.name.as_str());
            let title = format!("{} has no message `{name}`", self.dbc.source.name);
            self.report(section, "message", &title, &format!("found `{template}`, {}", nearest(&name, names)));
            return None;
        };
        if message.len > Frame::CAPACITY {
            let title = format!("`{name}` of {} is longer than a frame", self.dbc.source.name);
            self.report(section, "message", &title, &format!("found {} bytes, expected at most 64", message.len));
            return None;
        }
        if let Some(wheel) = wheel {
            self.check_node_id(&self.nodes[wheel], message);
        }
        Some(message)
    }

    /// A signal of `message`, by the name that `key` gives.
    pub fn signal(&self, section: &Section<'_>, key: &str, message: &MessageLayout) -> Option<Signal> {
        let name = required(section, key)?;
        if let Some(signal) = message.signal(&name) {
            let always_there = signal.selector.is_none() && !signal.is_wide();
            self.unless(!always_there, section, key, signal, "a number that every frame of the message carries")?;
            return Some(signal.clone());
        }
        let names = message.signals.iter().map(|signal| signal.name.as_str());
        let title = format!("{} of {} has no signal `{name}`", message.name, self.dbc.source.name);
        self.report(section, key, &title, &format!("found `{name}`, {}", nearest(&name, names)));
        None
    }

    /// A signal that counts frames.
    pub fn counter(&self, section: &Section<'_>, key: &str, message: &MessageLayout) -> Option<Signal> {
        let signal = self.signal(section, key, message)?;
        let sound = signal.is_integer() && signal.kind == RawKind::Unsigned && signal.bit_count() <= 8;
        self.unless(!sound, section, key, &signal, "an unsigned whole number of at most 8 bits")?;
        Some(signal)
    }

    /// A signal that counts encoder steps.
    pub fn position(&self, section: &Section<'_>, key: &str, message: &MessageLayout) -> Option<Signal> {
        let signal = self.signal(section, key, message)?;
        let sound = signal.is_integer() && signal.bit_count() == 32;
        self.unless(!sound, section, key, &signal, "a whole number of 32 bits, factor 1, offset 0")?;
        Some(signal)
    }

    /// A signal that carries a torque.
    pub fn torque(&self, section: &Section<'_>, key: &str, message: &MessageLayout) -> Option<Torque> {
        let signal = self.signal(section, key, message)?;
        let scale = torque_scale(&signal);
        let sound =
            scale.minimum_nm <= 0.0 && scale.maximum_nm >= 0.0 && (scale.maximum_nm - scale.minimum_nm).is_finite();
        self.unless(!sound, section, key, &signal, "a finite range that includes 0 N m")?;
        Some(Torque { signal, scale })
    }

    /// The outside of a message.
    pub fn envelope(&self, section: &Section<'_>, message: &MessageLayout) -> Option<Envelope> {
        let checksum = if section.has("crc") { Some(self.checksum(section, message)?) } else { None };
        Some(Envelope { id: message.id, len: message.len, checksum })
    }

    /// The raw values of `signal` that the profile's words stand for.
    pub fn values<T: Copy + PartialEq>(
        &self,
        words: &Words<'_, T>,
        message: &MessageLayout,
        signal: &Signal,
    ) -> Option<ValueNames<T>> {
        let mut entries = Vec::new();
        for (key, name, meaning) in &words.names {
            let Some((raw, _)) = signal.value_names.iter().find(|(_, known)| known == name) else {
                let names = signal.value_names.iter().map(|(_, name)| name.as_str());
                let place = format!("{}.{} of {}", message.name, signal.name, self.dbc.source.name);
                let title = format!("{place} has no value named `{name}`");
                self.report(&words.section, key, &title, &format!("found `{name}`, {}", nearest(name, names)));
                return None;
            };
            let mut data = [0; 64];
            signal.encode_raw(&mut data, Raw::Signed(*raw));
            let fits = signal.decode_name(&data) == Some(name);
            self.unless(!fits, &words.section, key, signal, &format!("one whose bits hold `{name}`, {raw}"))?;
            entries.push((*raw, *meaning));
        }
        Some(ValueNames::new(entries))
    }

    /// How often both wheels' messages are sent.
    pub fn cycle(&self, section: &Section<'_>, cycles: Wheels<Option<Duration>>) -> Option<Duration> {
        if cycles.right.is_none() || cycles.right != cycles.left {
            let title = format!("{} gives these messages no period", self.dbc.source.name);
            let shown = |cycle: Option<Duration>| cycle.map_or("none".to_owned(), |cycle| cycle.to_string());
            let found =
                format!("found {} for the right wheel, {} for the left", shown(cycles.right), shown(cycles.left));
            self.report(section, "message", &title, &format!("{found}, expected the same GenMsgCycleTime"));
        }
        cycles.right
    }

    fn checksum(&self, section: &Section<'_>, message: &MessageLayout) -> Option<Checksum> {
        let signal = self.signal(section, "crc", message)?;
        let Some((crc, id_bytes)) = &self.crc else {
            section.complain("crc", "found a CRC, expected a table [crc] that defines it");
            return None;
        };
        let mut data = [0; 64];
        signal.encode_bits(&mut data, u64::MAX);
        let byte = data.iter().position(|byte| *byte == 0xFF);
        self.unless(
            signal.bit_count() != 8 || byte.is_none(),
            section,
            "crc",
            &signal,
            "8 bits that are a whole byte",
        )?;
        let seed = crc.update(crc.start(), &message.id.raw().to_le_bytes()[..*id_bytes]);
        Some(Checksum { crc: crc.clone(), seed, byte: byte? })
    }

    fn check_node_id(&self, node: &Node<'_>, message: &MessageLayout) {
        let carried = (message.id.raw() & self.node_id_mask) >> self.node_id_mask.trailing_zeros();
        if node.section.has("id") && carried != u32::from(node.id) {
            let title = format!("`{}` of {} is another node's", message.name, self.dbc.source.name);
            let label = format!("found node {}, but id {} carries node {carried}", node.id, message.id);
            self.report(&node.section, "id", &title, &label);
        }
    }

    /// Reports that `signal` will not do if `wrong`.
    fn unless(&self, wrong: bool, section: &Section<'_>, key: &str, signal: &Signal, expected: &str) -> Option<()> {
        if wrong {
            let title = format!("the signal `{}` of {} will not do", signal.name, self.dbc.source.name);
            self.report(section, key, &title, &format!("found {}, expected {expected}", signal.layout()));
            return None;
        }
        Some(())
    }

    fn report(&self, section: &Section<'_>, key: &str, title: &str, label: &str) {
        let problem = section.problem(key, title, label);
        let at = problem.place.as_ref().map_or(0, |(_, span)| span.start);
        if self.reported.borrow_mut().insert(at) {
            section.report(problem);
        }
    }
}

impl<'r, T: Copy> Words<'r, T> {
    /// Reads the DBC's name for each of our words.
    pub fn new(section: Section<'r>, words: &[(&'static str, T)]) -> Self {
        let names = words.iter().filter_map(|&(key, meaning)| Some((key, required(&section, key)?, meaning)));
        Self { names: names.collect(), section }
    }
}

/// A name that must be given; `None` when that was reported to be missing.
fn required(section: &Section<'_>, key: &str) -> Option<String> {
    if section.has(key) {
        section.text_or_none(key)
    } else {
        section.text(key);
        None
    }
}

/// What the bits of `signal` can express, kept to the range that the DBC
/// gives where it gives one.
fn torque_scale(signal: &Signal) -> TorqueScale {
    let end_nm = |beyond: f64| {
        let mut data = [0; 64];
        signal.encode(&mut data, beyond);
        signal.decode(&data)
    };
    let (mut minimum_nm, mut maximum_nm) = (end_nm(f64::NEG_INFINITY), end_nm(f64::INFINITY));
    if signal.minimum < signal.maximum {
        minimum_nm = minimum_nm.max(signal.minimum);
        maximum_nm = maximum_nm.min(signal.maximum);
    }
    let resolution_nm = if signal.is_float() { 0.0 } else { signal.factor.abs() };
    TorqueScale { resolution_nm, minimum_nm, maximum_nm }
}

/// The names most like `wanted`, for a message.
fn nearest<'n>(wanted: &str, names: impl Iterator<Item = &'n str>) -> String {
    let mut ranked: Vec<(f64, &str)> = names.map(|name| (strsim::jaro_winkler(wanted, name), name)).collect();
    ranked.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let best: Vec<String> = ranked.iter().take(3).map(|(_, name)| format!("`{name}`")).collect();
    if best.is_empty() { "but it has none".to_owned() } else { format!("the nearest there: {}", best.join(", ")) }
}
