//! `[[event]]` tables of what goes wrong on the bus.

use canloop::config::{Bound, Section, nearest};
use canloop::frame::{CanId, Frame, FrameKind};
use canloop::schema::Dbc;
use canloop::time::Duration;

use crate::wire::{BurstyLoss, Damage, Fault, Node, Nodes, Pick};

/// The word for each kind, and how the rest of its table is read.
pub(super) const KINDS: [(&str, Read); 12] = [
    ("drop", |event, dbc| Fault::Drop(pick(event, dbc))),
    ("delay", |event, dbc| Fault::Delay(pick(event, dbc), seconds(event, "by_s"))),
    ("duplicate", |event, dbc| Fault::Duplicate(pick(event, dbc), event.integer_or("times", 1, 1, 100) as u32)),
    ("reorder", |event, dbc| Fault::Reorder(pick(event, dbc))),
    ("corrupt", |event, dbc| {
        let damage = event.choice("crc", &[("caught", Damage::Caught), ("missed", Damage::Uncaught)], false);
        Fault::Corrupt(pick(event, dbc), damage, Nodes::ALL)
    }),
    ("silence", |event, _| Fault::Silence(node(event))),
    ("babble", babble),
    ("bus-off", |event, _| Fault::BusOff(node(event))),
    ("no-acknowledge", |event, dbc| Fault::NoAcknowledge(pick(event, dbc))),
    ("cable-cut", |event, _| Fault::Cut(Nodes::only(node(event)))),
    ("bit-errors", |event, _| Fault::BitErrors(event.number("rate", Bound::Within(0.0, 1.0)))),
    ("bursty-loss", |event, _| Fault::BurstyLoss(bursty_loss(event))),
];

pub(super) type Read = fn(&Section<'_>, &Dbc) -> Fault;

const NODES: [(&str, Node); 3] = [("stack", Node::Stack), ("right", Node::Right), ("left", Node::Left)];
/// Standard ids.
const MOST_ID: i64 = 0x7FF;

fn node(event: &Section<'_>) -> Node {
    event.choice("node", &NODES, true)
}

fn seconds(event: &Section<'_>, key: &str) -> Duration {
    let seconds = event.number(key, Bound::Within(1e-6, 1e3));
    if seconds.is_nan() { Duration::ZERO } else { Duration::from_secs_f64(seconds) }
}

/// Which frames: of a `message`, of a `node`, with a `probability`, so many.
fn pick(event: &Section<'_>, dbc: &Dbc) -> Pick {
    let count = event.has("count").then(|| event.integer_or("count", 1, 1, i64::from(u32::MAX)) as u32);
    Pick {
        id: event.text_or_none("message").and_then(|name| message_id(event, dbc, &name)),
        sender: event.has("node").then(|| node(event)),
        probability: event.number_or("probability", 1.0, Bound::Within(0.0, 1.0)),
        count,
    }
}

fn message_id(event: &Section<'_>, dbc: &Dbc, name: &str) -> Option<CanId> {
    let found = dbc.message(name).map(|message| message.id);
    if found.is_none() {
        let names = || dbc.messages.iter().map(|message| message.name.as_str());
        let problem = event.problem("message", "the drives have no such message", &format!("found {name:?}"));
        event.report(match nearest(name, names()) {
            Some(near) => problem.help(format!("did you mean `{near}`?")),
            None => problem.help(format!("there are {}", names().collect::<Vec<_>>().join(", "))),
        });
    }
    found
}

/// Somebody sends a frame with this id, every so often or without pause.
fn babble(event: &Section<'_>, _: &Dbc) -> Fault {
    let kinds = [("classic", FrameKind::Classic), ("fd", FrameKind::Fd), ("fd-brs", FrameKind::FdBitRateSwitch)];
    let kind = event.choice("frame", &kinds, false);
    let bytes = event.integer_or("bytes", 8, 0, if kind == FrameKind::Classic { 8 } else { 64 });
    if !is_length_of_a_frame(bytes as usize) {
        event.complain("bytes", &format!("found {bytes}, expected up to 8, 12, 16, 20, 24, 32, 48 or 64"));
    }
    let id = event.integer("id", 0, MOST_ID) as u16;
    let period = event.has("period_s").then(|| seconds(event, "period_s"));
    let mut frame = Frame::zeroed(CanId::Standard(id), bytes as usize);
    frame.kind = kind;
    Fault::Babble(frame, period)
}

/// ISO 11898-1:2015, table 5.
const fn is_length_of_a_frame(bytes: usize) -> bool {
    matches!(bytes, 0..=8 | 12 | 16 | 20 | 24 | 32 | 48 | 64)
}

fn bursty_loss(event: &Section<'_>) -> BurstyLoss {
    let probability = |key: &str, default: f64| event.number_or(key, default, Bound::Within(0.0, 1.0));
    BurstyLoss {
        turns_bad: event.number("turns_bad", Bound::Within(0.0, 1.0)),
        turns_good: event.number("turns_good", Bound::Within(0.0, 1.0)),
        lost_when_good: probability("lost_when_good", 0.0),
        lost_when_bad: probability("lost_when_bad", 1.0),
    }
}
