//! The channels of one bus: every frame as it was, and decoded if the DBC
//! knows it.

use std::collections::{BTreeMap, BTreeSet};

use super::cdr::{FRAME_DEFINITION, FRAME_NAME, FrameEncoder};
use super::descriptor::{flat_message, identifier};
use super::medium::{Catalogue, Medium};
use super::protobuf::{FD_FRAME_FIELDS, LOST_FIELDS, field_type, put_fd_frame, put_signals, put_unsigned};
use super::{LogError, LoggedBus};
use crate::event::BusFrame;
use crate::frame::{CanId, Frame, FrameKind};
use crate::schema::{MessageLayout, Signal};
use crate::time::Instant;

/// Writes the frames of one bus.
pub(super) struct BusLog {
    encoder: FrameEncoder,
    /// Two channels of one topic tell who sent a frame, which its message has
    /// no field for.
    received: u16,
    sent: u16,
    fd: u16,
    lost: u16,
    /// Sorted by the key of their ids.
    messages: Vec<DecodedMessage>,
}

/// The schemas of frames, which all buses share.
pub(super) struct FrameSchemas {
    classic: u16,
    fd: u16,
    lost: u16,
}

/// A frame with what a log tells of it.
#[derive(Clone, Copy, Debug)]
pub struct LoggedFrame<'f> {
    /// The frame.
    pub frame: &'f Frame,
    /// Whether the stack, or whoever logs, sent it.
    pub sent_by_stack: bool,
    /// Whether its sender was error-passive; CAN FD only.
    pub error_passive: bool,
    /// The length code of 8 bytes of a classic frame, where it was 9 to 15.
    pub dlc_above_8: Option<u8>,
}

struct DecodedMessage {
    key: u32,
    channel: u16,
    layout: MessageLayout,
}

impl FrameSchemas {
    /// Adds them to `catalogue`.
    pub fn new(catalogue: &mut impl Catalogue) -> Result<Self, LogError> {
        let fd = flat_message("canloop", "CanFdFrame", &FD_FRAME_FIELDS);
        Ok(Self {
            classic: catalogue.schema(FRAME_NAME, "ros2msg", FRAME_DEFINITION.as_bytes())?,
            fd: catalogue.schema("canloop.CanFdFrame", "protobuf", &fd)?,
            lost: catalogue.schema("canloop.Lost", "protobuf", &flat_message("canloop", "Lost", &LOST_FIELDS))?,
        })
    }
}

impl<'f> From<&'f BusFrame> for LoggedFrame<'f> {
    fn from(on_bus: &'f BusFrame) -> Self {
        let &BusFrame { sent_by_stack, ref frame, .. } = on_bus;
        Self { frame, sent_by_stack, error_passive: false, dlc_above_8: None }
    }
}

impl BusLog {
    /// Adds the channels of `bus`. Where two of its DBC files know an id, the
    /// first is believed.
    pub fn new(bus: &LoggedBus<'_>, schemas: &FrameSchemas, catalogue: &mut impl Catalogue) -> Result<Self, LogError> {
        let topic = format!("/can/{}", bus.name);
        let direction = |word: &str| BTreeMap::from([("direction".to_owned(), word.to_owned())]);
        let mut log = Self {
            encoder: FrameEncoder::new(bus.name),
            received: catalogue.channel(schemas.classic, topic.clone(), "cdr", direction("received by the stack"))?,
            sent: catalogue.channel(schemas.classic, topic.clone(), "cdr", direction("sent by the stack"))?,
            fd: catalogue.channel(schemas.fd, format!("{topic}/fd"), "protobuf", BTreeMap::new())?,
            lost: catalogue.channel(schemas.lost, format!("{topic}/lost"), "protobuf", BTreeMap::new())?,
            messages: Vec::new(),
        };
        let package = format!("canloop.{}", identifier(bus.name, &mut BTreeSet::new()));
        let mut names = BTreeSet::from(["fd".to_owned(), "lost".to_owned()]);
        for layout in bus.dbcs.iter().flat_map(|dbc| &dbc.messages) {
            let key = key(layout.id);
            if log.messages.iter().all(|message| message.key != key) {
                let name = identifier(&layout.name, &mut names);
                let schema =
                    catalogue.schema(&format!("{package}.{name}"), "protobuf", &schema(layout, &package, &name))?;
                let channel = catalogue.channel(schema, format!("{topic}/{name}"), "protobuf", notes(layout))?;
                log.messages.push(DecodedMessage { key, channel, layout: layout.clone() });
            }
        }
        log.messages.sort_by_key(|message| message.key);
        Ok(log)
    }

    /// Logs a frame, raw and decoded, unless it carries no signal: a remote
    /// request, or one cut short before the first.
    pub fn put(&self, medium: &mut impl Medium, at: Instant, logged: &LoggedFrame<'_>) {
        let &LoggedFrame { frame, sent_by_stack, error_passive, dlc_above_8 } = logged;
        if matches!(frame.kind, FrameKind::Fd | FrameKind::FdBitRateSwitch) {
            medium.message(self.fd, at, |out| put_fd_frame(out, frame, sent_by_stack, error_passive));
        } else {
            let channel = if sent_by_stack { self.sent } else { self.received };
            let dlc = dlc_above_8.unwrap_or(frame.len() as u8);
            medium.message(channel, at, |out| self.encoder.put(out, at, frame, dlc));
        }
        let Ok(index) = self.messages.binary_search_by_key(&key(frame.id), |message| message.key) else { return };
        let message = &self.messages[index];
        let layout = &message.layout;
        let says_something = layout.signals.is_empty() || layout.carried(frame).next().is_some();
        if frame.kind != FrameKind::Remote && says_something {
            medium.message(message.channel, at, |out| put_signals(out, layout, frame));
        }
    }

    /// Logs that frames were lost, `total` of them so far.
    pub fn put_lost(&self, medium: &mut impl Medium, at: Instant, frames: u64, total: u64) {
        medium.message(self.lost, at, |out| {
            put_unsigned(out, 1, frames);
            put_unsigned(out, 2, total);
        });
    }

    /// Logs an error frame: classes and data as SocketCAN has them.
    pub fn put_error(&self, medium: &mut impl Medium, at: Instant, class: u32, data: [u8; 8]) {
        medium.message(self.received, at, |out| self.encoder.put_error(out, at, class, data));
    }
}

/// The descriptor of a decoded message: one field a signal.
fn schema(layout: &MessageLayout, package: &str, name: &str) -> Vec<u8> {
    let mut taken = BTreeSet::new();
    let names: Vec<_> = layout.signals.iter().map(|signal| identifier(&signal.name, &mut taken)).collect();
    let types = layout.signals.iter().map(field_type);
    let fields: Vec<_> = names.iter().map(String::as_str).zip(types).collect();
    flat_message(package, name, &fields)
}

/// What the DBC says of a message beyond its layout, for people.
fn notes(layout: &MessageLayout) -> BTreeMap<String, String> {
    let values = |signal: &Signal| {
        let names = signal.value_names.iter().map(|(value, name)| format!("{value}={name}"));
        names.collect::<Vec<_>>().join(" ")
    };
    let mut notes = BTreeMap::from([
        ("id".to_owned(), format!("0x{}", layout.id)),
        ("comment".to_owned(), layout.comment.clone()),
        ("sender".to_owned(), layout.sender.clone()),
    ]);
    for signal in &layout.signals {
        notes.insert(format!("{}.comment", signal.name), signal.comment.clone());
        notes.insert(format!("{}.unit", signal.name), signal.unit.clone());
        notes.insert(format!("{}.values", signal.name), values(signal));
    }
    notes.retain(|_, note| !note.is_empty());
    notes
}

/// A number that tells ids apart, of whichever width.
const fn key(id: CanId) -> u32 {
    id.raw() | (id.is_extended() as u32) << 31
}
