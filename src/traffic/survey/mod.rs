//! What is in a log: how much of what, how regularly, and what is odd.

mod bus;
mod json;
mod message;
mod sample;
mod stamps;
mod table;

use std::collections::BTreeMap;

pub use bus::Bus;
pub use message::{Message, Periods};
use stamps::Stamps;

use super::{Content, Record};
use crate::bus::BitRates;
use crate::frame::CanId;
use crate::time::Instant;

/// Gathered record by record; of a fixed size for each message and bus.
#[derive(Default)]
pub struct Survey {
    rates: Option<BitRates>,
    records: u64,
    first: Option<Instant>,
    last: Option<Instant>,
    stamps: Stamps,
    /// By index.
    buses: Vec<Bus>,
    /// By bus, then by id, standard ids first.
    messages: BTreeMap<(u16, u32), Message>,
}

impl Survey {
    /// Of nothing yet. Loads are known where bit rates are.
    pub fn new(rates: Option<BitRates>) -> Self {
        Self { rates, ..Self::default() }
    }

    /// Takes a record into account.
    pub fn add(&mut self, record: &Record) {
        self.records += 1;
        self.first = Some(self.first.map_or(record.at, |first| first.min(record.at)));
        self.last = Some(self.last.map_or(record.at, |last| last.max(record.at)));
        self.stamps.add(record.at);
        let index = usize::from(record.bus);
        if index >= self.buses.len() {
            self.buses.resize_with(index + 1, Bus::default);
        }
        self.buses[index].add(record, self.rates);
        if let Content::Frame(recorded) = &record.content {
            let with_periods = self.messages.len() < message::MOST_WITH_PERIODS;
            let entry = self.messages.entry((record.bus, key(recorded.frame.id)));
            entry.or_insert_with(|| Message::new(recorded.frame.id, with_periods)).add(record, recorded);
        }
    }

    /// The buses, by their index.
    pub fn buses(&self) -> &[Bus] {
        &self.buses
    }

    /// The messages, each with the index of its bus: by bus, then by id, standard
    /// ids first.
    pub fn messages(&self) -> impl Iterator<Item = (u16, &Message)> {
        self.messages.iter().map(|(&(bus, _), message)| (bus, message))
    }

    /// From the earliest record to the latest, s.
    pub fn span_s(&self) -> f64 {
        match (self.first, self.last) {
            (Some(first), Some(last)) => (last - first).as_secs_f64(),
            _ => 0.0,
        }
    }

    /// Sum of something over all buses.
    fn sum(&self, of: impl Fn(&Bus) -> u64) -> u64 {
        self.buses.iter().map(of).sum()
    }
}

/// A number for each id, which orders standard ones before extended ones.
const fn key(id: CanId) -> u32 {
    id.raw() | (id.is_extended() as u32) << 31
}
