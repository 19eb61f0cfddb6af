//! Events as messages: which channels there are, and what goes into each.

use std::collections::BTreeMap;

use prost_types::field_descriptor_proto::Type;

use super::bus::{BusLog, FrameSchemas};
use super::descriptor::{flat_message, foxglove_log};
use super::exchange::{EXCHANGE_FIELDS, put_exchange};
use super::medium::{Catalogue, Medium};
use super::protobuf::{Level, put_doubles, put_log};
use super::{EXCHANGE_TOPIC, LOOP_TOPIC, LogContents, LogError, NOTICES_TOPIC, STACK_TOPIC};
use crate::event::{Event, Notice, Tick, Timing, Truth};
use crate::time::Instant;

/// Turns the events of a run into messages.
pub(crate) struct Messages {
    buses: Vec<BusLog>,
    stack: u16,
    truth: u16,
    timing: u16,
    notices: u16,
    exchange: u16,
    /// Names of what a [`Mark`](crate::event::Mark) counts.
    planned: Vec<String>,
    /// The latest event's time.
    now: Instant,
    /// Events that there are no messages for.
    lost: u64,
}

impl Messages {
    /// Adds the channels of a run to `catalogue`.
    pub fn new(contents: &LogContents<'_>, catalogue: &mut impl Catalogue) -> Result<Self, LogError> {
        let frames = FrameSchemas::new(catalogue)?;
        let buses: Result<Vec<_>, _> = contents.buses.iter().map(|bus| BusLog::new(bus, &frames, catalogue)).collect();
        let buses = buses?;
        let stack = doubles_channel(catalogue, STACK_TOPIC, "Stack", &Tick::NAMES)?;
        let truth = doubles_channel(catalogue, "/canloop/truth", "Truth", &Truth::NAMES)?;
        let timing = doubles_channel(catalogue, LOOP_TOPIC, "Loop", &Timing::NAMES)?;
        let exchange = flat_message("canloop", "Exchange", &EXCHANGE_FIELDS);
        let exchange = catalogue.schema("canloop.Exchange", "protobuf", &exchange)?;
        let exchange = catalogue.channel(exchange, EXCHANGE_TOPIC.to_owned(), "protobuf", BTreeMap::new())?;
        let log = catalogue.schema("foxglove.Log", "protobuf", &foxglove_log())?;
        let notices = catalogue.channel(log, NOTICES_TOPIC.to_owned(), "protobuf", BTreeMap::new())?;
        Ok(Self {
            buses,
            stack,
            truth,
            timing,
            notices,
            exchange,
            planned: contents.planned.clone(),
            now: Instant::ZERO,
            lost: 0,
        })
    }

    /// Gives an event to `medium`.
    pub fn put(&mut self, medium: &mut impl Medium, at: Instant, event: &Event) {
        self.now = at;
        match event {
            Event::Frame(on_bus) => match self.buses.get(usize::from(on_bus.bus)) {
                Some(bus) => bus.put(medium, at, &on_bus.into()),
                None => self.lost += 1,
            },
            Event::Sync(_) => {}
            Event::Tick(tick) => medium.message(self.stack, at, |out| put_doubles(out, &tick.values())),
            Event::Truth(truth) => medium.message(self.truth, at, |out| put_doubles(out, &truth.values())),
            Event::Timing(timing) => medium.message(self.timing, at, |out| put_doubles(out, &timing.values())),
            Event::Exchange(exchange) => medium.message(self.exchange, at, |out| put_exchange(out, exchange)),
            Event::Notice(Notice { kind, text }) => self.notice(medium, at, Level::Info, kind, text),
            Event::Mark(mark) => self.notice(medium, at, Level::Info, "event", &mark.text(&self.planned)),
        }
    }

    /// Says that events are missing, at the time of the next, if that is known.
    pub fn put_lost(&mut self, medium: &mut impl Medium, at: Option<Instant>, lost: u64) {
        self.lost += lost;
        let text = format!("{lost} events are not in this log: it was written slower than they came");
        self.notice(medium, at.unwrap_or(self.now), Level::Error, "log", &text);
    }

    /// Events of which there is no message, so far.
    pub const fn lost(&self) -> u64 {
        self.lost
    }

    fn notice(&self, medium: &mut impl Medium, at: Instant, level: Level, name: &str, text: &str) {
        medium.message(self.notices, at, |out| put_log(out, at, level, name, text));
    }
}

/// Adds a channel whose messages are doubles with these names.
fn doubles_channel(catalogue: &mut impl Catalogue, topic: &str, name: &str, fields: &[&str]) -> Result<u16, LogError> {
    let fields: Vec<_> = fields.iter().map(|&field| (field, Type::Double)).collect();
    let schema = catalogue.schema(&format!("canloop.{name}"), "protobuf", &flat_message("canloop", name, &fields))?;
    catalogue.channel(schema, topic.to_owned(), "protobuf", BTreeMap::new())
}
