//! Looks up the messages, signals and value names that a profile asks a DBC
//! for. One that leads nowhere is reported at the key that asks, with the
//! names that are most like it, and once, however many roles ask.

use std::cell::RefCell;
use std::collections::BTreeSet;

use super::addressing::Addressing;
use super::dbc::{Dbc, MessageLayout};
use super::envelope::{Checksum, CrcRule, Envelope};
use super::pattern::{Masked, Pattern};
use super::signal::{Raw, RawKind, Signal};
use crate::config::{Item, Section};
use crate::frame::Frame;
use crate::time::Duration;
use crate::wheels::{Wheel, Wheels};

/// Stands for the node's name in the name of a message or a signal.
pub(super) const NODE: &str = "{node}";
/// Stands for the node's number among the values of a signal.
const ID: &str = "{id}";

/// A DBC and how a profile names things in it.
pub(super) struct Linker<'r> {
    dbc: &'r Dbc,
    nodes: Wheels<Node<'r>>,
    /// The bits of an arbitration id that hold the node's number.
    pub node_id_mask: u32,
    crc: Option<CrcRule>,
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

/// A message, and the wheel whose part of it is looked at.
#[derive(Clone, Copy)]
pub(super) struct Linked<'r> {
    pub layout: &'r MessageLayout,
    pub wheel: Option<Wheel>,
}

impl<'r> Linker<'r> {
    /// Reads `[wheels]`.
    pub fn new(dbc: &'r Dbc, wheels: &Section<'r>, crc: Option<CrcRule>) -> Self {
        let node_id_mask = wheels.integer("node_id_mask", 0, 0x1FFF_FFFF) as u32;
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
    pub fn message(&self, section: &Section<'_>, wheel: Option<Wheel>) -> Option<Linked<'r>> {
        let template = required(section, "message")?;
        let name = self.named(&template, wheel)?;
        let Some(layout) = self.dbc.message(&name) else {
            let names = self.dbc.messages.iter().map(|message| message.name.as_str());
            let title = format!("{} has no message `{name}`", self.dbc.source.name);
            self.report(section, "message", &title, &format!("found `{template}`, {}", nearest(&name, names)));
            return None;
        };
        if layout.len > Frame::CAPACITY {
            let title = format!("`{name}` of {} is longer than a frame", self.dbc.source.name);
            self.report(section, "message", &title, &format!("found {} bytes, expected at most 64", layout.len));
            return None;
        }
        if let Some(wheel) = wheel.filter(|_| template.contains(NODE)) {
            self.check_node_id(&self.nodes[wheel], layout);
        }
        Some(Linked { layout, wheel })
    }

    /// A signal of `message`, by the name that `key` gives.
    pub fn signal(&self, section: &Section<'_>, key: &str, message: Linked<'_>) -> Option<Signal> {
        self.signal_named(section, key, &required(section, key)?, message)
    }

    /// A signal of `message`, by its name; what is wrong with that is reported
    /// at `key`.
    pub fn signal_named(&self, section: &Section<'_>, key: &str, name: &str, message: Linked<'_>) -> Option<Signal> {
        let Linked { layout, wheel } = message;
        let name = self.named(name, wheel)?;
        if let Some(signal) = layout.signal(&name) {
            let always_there = signal.selector.is_none() && !signal.is_wide();
            self.unless(!always_there, section, key, signal, "a number that every frame of the message carries")?;
            return Some(signal.clone());
        }
        let names = layout.signals.iter().map(|signal| signal.name.as_str());
        let title = format!("{} of {} has no signal `{name}`", layout.name, self.dbc.source.name);
        self.report(section, key, &title, &format!("found `{name}`, {}", nearest(&name, names)));
        None
    }

    /// A signal that counts frames.
    pub fn counter(&self, section: &Section<'_>, key: &str, message: Linked<'_>) -> Option<Signal> {
        let signal = self.signal(section, key, message)?;
        let sound = signal.is_integer() && signal.kind == RawKind::Unsigned && signal.bit_count() <= 8;
        self.unless(!sound, section, key, &signal, "an unsigned whole number of at most 8 bits")?;
        Some(signal)
    }

    /// The outside of a message.
    pub fn envelope(&self, section: &Section<'_>, message: Linked<'_>) -> Option<Envelope> {
        let Linked { layout, .. } = message;
        let checksum = if section.has("crc") { Some(self.checksum(section, message)?) } else { None };
        let shortest = section.integer_or("shortest", layout.len as i64, 0, layout.len as i64) as usize;
        Some(Envelope { id: layout.id, len: layout.len, shortest, checksum })
    }

    /// The values of `signal` under `key`: names, numbers, and numbers of which
    /// only some bits count.
    pub fn pattern(&self, section: &Section<'_>, key: &str, message: Linked<'_>, signal: &Signal) -> Option<Pattern> {
        let items = section.items(key);
        if items.is_empty() {
            self.report(section, key, "a value is missing", &format!("found none, expected one of `{}`", signal.name));
            return None;
        }
        let choices = items.into_iter().map(|item| self.masked(section, key, message, signal, item));
        let mut choices = choices.collect::<Option<Vec<Masked>>>()?.into_iter();
        Some(Pattern { first: choices.next()?, others: choices.collect() })
    }

    fn masked(
        &self,
        section: &Section<'_>,
        key: &str,
        message: Linked<'_>,
        signal: &Signal,
        item: Item<'_>,
    ) -> Option<Masked> {
        let all = u64::MAX >> (64 - signal.bit_count());
        let physical = |number: f64| {
            let mut data = [0; 64];
            signal.encode(&mut data, number);
            (signal.decode_bits(&data), signal.decode(&data))
        };
        match item {
            Item::Text(name) if name == ID => {
                let id = self.nodes[message.wheel.unwrap_or(Wheel::Right)].id;
                Some(Masked { mask: all, value: physical(f64::from(id)).0 })
            }
            Item::Text(name) => Some(Masked { mask: all, value: self.value(section, key, message, signal, &name)? }),
            Item::Integer(number) => {
                let (value, back) = physical(number as f64);
                let off = (back - number as f64).abs() > 0.5 * signal.factor.abs();
                self.unless(off, section, key, signal, &format!("one that can hold {number}"))?;
                Some(Masked { mask: all, value })
            }
            Item::Number(number) => Some(Masked { mask: all, value: physical(number).0 }),
            Item::Table(table) => {
                let bits = |key| table.integer(key, 0, i64::MAX) as u64;
                let masked = Masked { mask: bits("mask"), value: bits("value") };
                if masked.value & !masked.mask != 0 || masked.mask & !all != 0 {
                    table.complain(
                        "mask",
                        &format!(
                            "found {:#X}, expected one that covers the value and fits `{}`",
                            masked.mask, signal.name
                        ),
                    );
                    return None;
                }
                Some(masked)
            }
        }
    }

    /// The bits of `signal` that the DBC gives this name.
    fn value(&self, section: &Section<'_>, key: &str, message: Linked<'_>, signal: &Signal, name: &str) -> Option<u64> {
        let Some((raw, _)) = signal.value_names.iter().find(|(_, known)| known == name) else {
            let names = signal.value_names.iter().map(|(_, name)| name.as_str());
            let place = format!("{}.{} of {}", message.layout.name, signal.name, self.dbc.source.name);
            let title = format!("{place} has no value named `{name}`");
            self.report(section, key, &title, &format!("found `{name}`, {}", nearest(name, names)));
            return None;
        };
        let mut data = [0; 64];
        signal.encode_raw(&mut data, Raw::Signed(*raw));
        let fits = signal.decode_name(&data) == Some(name);
        self.unless(!fits, section, key, signal, &format!("one whose bits hold `{name}`, {raw}"))?;
        Some(signal.decode_bits(&data))
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

    fn checksum(&self, section: &Section<'_>, message: Linked<'_>) -> Option<Checksum> {
        let signal = self.signal(section, "crc", message)?;
        let Some(rule) = &self.crc else {
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
        Some(Checksum::new(rule.clone(), message.layout.id, byte?))
    }

    fn check_node_id(&self, node: &Node<'_>, message: &MessageLayout) {
        let carried = Addressing { mask: self.node_id_mask, broadcast: None }.node_in(message.id);
        if self.node_id_mask != 0 && node.section.has("id") && carried != u32::from(node.id) {
            let title = format!("`{}` of {} is another node's", message.name, self.dbc.source.name);
            let label = format!("found node {}, but id {} carries node {carried}", node.id, message.id);
            self.report(&node.section, "id", &title, &label);
        }
    }

    /// The name that a template makes for a wheel.
    fn named(&self, template: &str, wheel: Option<Wheel>) -> Option<String> {
        if !template.contains(NODE) {
            return Some(template.to_owned());
        }
        Some(template.replace(NODE, self.nodes[wheel?].name.as_ref()?))
    }

    /// Reports that `signal` will not do if `wrong`.
    pub fn unless(&self, wrong: bool, section: &Section<'_>, key: &str, signal: &Signal, expected: &str) -> Option<()> {
        if wrong {
            let title = format!("the signal `{}` of {} will not do", signal.name, self.dbc.source.name);
            self.report(section, key, &title, &format!("found {}, expected {expected}", signal.layout()));
            return None;
        }
        Some(())
    }

    pub fn report(&self, section: &Section<'_>, key: &str, title: &str, label: &str) {
        let problem = section.problem(key, title, label);
        let at = problem.place.as_ref().map_or(0, |(_, span)| span.start);
        if self.reported.borrow_mut().insert(at) {
            section.report(problem);
        }
    }
}

/// A name that must be given; `None` when that was reported to be missing.
pub(super) fn required(section: &Section<'_>, key: &str) -> Option<String> {
    if section.has(key) {
        section.text_or_none(key)
    } else {
        section.text(key);
        None
    }
}

/// The names most like `wanted`, for a message.
pub(super) fn nearest<'n>(wanted: &str, names: impl Iterator<Item = &'n str>) -> String {
    let mut ranked: Vec<(f64, &str)> = names.map(|name| (strsim::jaro_winkler(wanted, name), name)).collect();
    ranked.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let best: Vec<String> = ranked.iter().take(3).map(|(_, name)| format!("`{name}`")).collect();
    if best.is_empty() { "but it has none".to_owned() } else { format!("the nearest there: {}", best.join(", ")) }
}
