//! The messages of a DBC as a table for people.

use std::fmt::Write;

use super::bits::ByteOrder;
use super::dbc::{Dbc, MessageLayout};
use super::signal::{RawKind, Signal};

impl Dbc {
    /// A Markdown table of all messages, one a row, each signal on a line of
    /// its own.
    pub fn markdown_table(&self) -> String {
        let mut table = "| id | message | bytes | sender | every | signals |\n|---|---|---|---|---|---|\n".to_owned();
        for message in &self.messages {
            table += &row(message);
        }
        table
    }
}

fn row(message: &MessageLayout) -> String {
    let MessageLayout { id, name, len, sender, .. } = message;
    let every = message.cycle.map_or_else(String::new, |cycle| format!("{} ms", cycle.as_nanos() as f64 / 1e6));
    let signals: Vec<String> = message.signals.iter().map(|one| signal(one) + &condition(message, one)).collect();
    format!("| `0x{id}` | {name} | {len} | {sender} | {every} | {} |\n", signals.join("<br>"))
}

/// Such as "`Torque`: bit 0, 16 bit signed, 0.005 N m".
fn signal(signal: &Signal) -> String {
    let kind = match signal.kind {
        RawKind::Unsigned => "unsigned",
        RawKind::Signed => "signed",
        RawKind::Float32 | RawKind::Float64 => "float",
    };
    let mut text = format!("`{}`: bit {}, {} bit {kind}", signal.name, signal.start_bit, signal.bit_count());
    if signal.byte_order == ByteOrder::Motorola {
        text += ", big-endian";
    }
    if signal.factor != 1.0 {
        write!(text, ", {} {}", signal.factor, signal.unit).expect("a String takes any text");
    } else if !signal.unit.is_empty() {
        write!(text, ", {}", signal.unit).expect("a String takes any text");
    }
    if signal.offset != 0.0 {
        write!(text, ", offset {}", signal.offset).expect("a String takes any text");
    }
    if !signal.value_names.is_empty() {
        let names: Vec<String> = signal.value_names.iter().map(|(raw, name)| format!("{raw} {name}")).collect();
        write!(text, " ({})", names.join(", ")).expect("a String takes any text");
    }
    text.trim_end().replace('|', "\\|")
}

/// Such as "; when `Mode` is 1 to 3 or 7".
fn condition(message: &MessageLayout, signal: &Signal) -> String {
    let Some(selector) = &signal.selector else { return String::new() };
    let values = selector.values.iter().map(|range| match (range.start(), range.end()) {
        (first, last) if first == last => first.to_string(),
        (first, last) => format!("{first} to {last}"),
    });
    format!("; when `{}` is {}", message.signals[selector.switch].name, values.collect::<Vec<_>>().join(" or "))
}
