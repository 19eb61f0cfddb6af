//! What is unusual in a DBC file and worth a second look, though every frame
//! is read and written as it says.

use std::collections::BTreeSet;

use super::MessageLayout;
use super::findings::Findings;
use super::reader::NOBODY;
use super::statements::{Message, Signal as Statement, Statements};
use crate::schema::encoding::{Encoding, Value};
use crate::schema::signal::{Raw, Signal};

/// Lengths that CAN FD frames have beyond 8 bytes.
const FD_LENGTHS: [usize; 7] = [12, 16, 20, 24, 32, 48, 64];

/// Looks at the list of nodes.
pub(super) fn nodes(file: &Statements<'_>, findings: &mut Findings<'_>) {
    let mut met = BTreeSet::new();
    for node in file.nodes.iter().filter(|node| !met.insert(node.is)) {
        let title = format!("the node {} is given twice", node.is);
        findings.warn(&node.span, title, format!("found {} again", node.is), "take one of them out");
    }
}

/// Looks at a message without its signals.
pub(super) fn message(layout: &MessageLayout, given: &Message<'_>, file: &Statements<'_>, findings: &mut Findings<'_>) {
    let sender = &given.sender;
    let is_node = sender.is.is_empty() || sender.is == NOBODY || file.nodes.iter().any(|node| node.is == sender.is);
    if !is_node {
        let title = format!("nobody knows the sender of {}", layout.name);
        let label = format!("found {}, which BU_ does not list", sender.is);
        findings.warn(&sender.span, title, label, "add it to BU_, or write Vector__XXX for nobody");
    }
    let len = layout.len;
    if layout.is_fd && len > 8 && len <= 64 && !FD_LENGTHS.contains(&len) {
        let next = FD_LENGTHS.into_iter().find(|&fits| fits > len).unwrap_or(64);
        let title = format!("no frame is as long as {}", layout.name);
        let label = format!("found {len} bytes, expected one of {FD_LENGTHS:?}");
        findings.warn(&given.len.span, title, label, &format!("CAN FD sends it in a frame of {next} bytes"));
    }
}

/// Looks at a signal.
pub(super) fn signal(layout: &MessageLayout, signal: &Signal, given: &Statement<'_>, findings: &mut Findings<'_>) {
    let shown = format!("{}.{}", layout.name, signal.name);
    if signal.is_wide() {
        return;
    }
    let is_scaled = signal.is_float() || signal.factor != 1.0 || signal.offset != 0.0;
    if is_scaled && signal.unit.trim().is_empty() && signal.value_names.is_empty() {
        let hint = "write it between the quotes, such as \"rad/s\"; \"1\" is for a ratio";
        findings.warn(&given.unit.span, format!("{shown} has no unit"), "found a scaled number without a unit", hint);
    }
    let (least, most) = ends(signal);
    // A step, and what printing in decimal costs.
    let slack = signal.factor.abs() + 1e-9 * (most - least);
    let has_range = signal.minimum < signal.maximum;
    if !signal.is_float() && has_range && (signal.minimum < least - slack || signal.maximum > most + slack) {
        let label = format!("found {} to {}, but its bits hold {least} to {most}", signal.minimum, signal.maximum);
        let hint = "correct the range, or give the signal more bits";
        findings.warn(&given.range, format!("the range of {shown} is wider than its bits"), label, hint);
    }
    let starts_well = |value| signal.quantise(Value::Raw(Raw::Real(value)), Encoding::default()).is_ok();
    if let Some(start) = signal.start_value.filter(|value| !starts_well(*value)) {
        let label = format!("found raw {start}, which its bits do not hold");
        let hint = "GenSigStartValue is a raw value, before factor and offset";
        findings.warn(&given.layout, format!("{shown} cannot start with its start value"), label, hint);
    }
}

/// Least and greatest physical value of the bits.
fn ends(signal: &Signal) -> (f64, f64) {
    let end = |beyond: f64| {
        let mut data = vec![0; signal.end_byte()];
        signal.encode(&mut data, beyond);
        signal.decode(&data)
    };
    (end(f64::NEG_INFINITY), end(f64::INFINITY))
}
