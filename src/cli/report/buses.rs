//! What is on the buses of a log, and how much of them is taken.

use std::collections::BTreeMap;

use crate::bus::frame_bits;
use crate::frame::CanId;
use crate::report::{Chart, Column, Figure, Page, Role, Section, Series, Stroke, Table};
use crate::schema::Dbc;
use crate::time::Instant;
use crate::traffic::{self, Content, Direction, Record};

/// Gathered record by record.
pub struct Buses {
    bit_rate_bit_s: Option<u32>,
    first: Option<Instant>,
    last: Instant,
    /// By bus.
    counts: Vec<Counts>,
    /// By bus and id.
    messages: BTreeMap<(u16, bool, u32), Message>,
}

#[derive(Clone, Debug, Default)]
struct Counts {
    frames: u64,
    sent: u64,
    errors: u64,
    lost: u64,
    /// Bits in each stretch.
    bits: Vec<u64>,
    stretch_s: f64,
}

#[derive(Clone, Copy, Debug)]
struct Message {
    count: u64,
    bytes: usize,
    first_s: f64,
    last_s: f64,
    longest_gap_s: f64,
}

/// Stretches at first, s.
const STRETCH_S: f64 = 0.1;
/// Stretches at most: a chart is some 370 pixels wide.
const MOST_STRETCHES: usize = 400;

impl Buses {
    /// Nothing yet.
    pub fn new(bit_rate_bit_s: Option<u32>) -> Self {
        Self { bit_rate_bit_s, first: None, last: Instant::ZERO, counts: Vec::new(), messages: BTreeMap::new() }
    }

    /// How long after the first record a moment is, s.
    pub fn seconds(&self, at: Instant) -> f64 {
        (at - self.first.unwrap_or(at)).as_secs_f64()
    }

    /// From the first record to the last, s.
    pub fn span_s(&self) -> f64 {
        self.seconds(self.last)
    }

    /// Takes a record.
    pub fn take(&mut self, record: &Record) {
        self.first.get_or_insert(record.at);
        self.last = self.last.max(record.at);
        let at_s = self.seconds(record.at);
        let bus = usize::from(record.bus);
        if bus >= self.counts.len() {
            self.counts.resize_with(bus + 1, Counts::default);
        }
        let counts = &mut self.counts[bus];
        match &record.content {
            Content::Error(_) => counts.errors += 1,
            Content::Lost(frames) => counts.lost += u64::from(*frames),
            Content::Frame(recorded) => {
                counts.frames += 1;
                counts.sent += u64::from(record.direction == Direction::Sent);
                counts.take_bits(at_s, u64::from(frame_bits(&recorded.frame)));
                let (id, bytes) = (recorded.frame.id, recorded.frame.len());
                let new = Message { count: 0, bytes, first_s: at_s, last_s: at_s, longest_gap_s: 0.0 };
                let message = self.messages.entry((record.bus, id.is_extended(), id.raw())).or_insert(new);
                message.count += 1;
                message.bytes = message.bytes.max(bytes);
                message.longest_gap_s = message.longest_gap_s.max(at_s - message.last_s);
                message.last_s = at_s;
            }
        }
    }

    /// Adds what there is to say.
    pub fn sections(&self, page: Page, names: &traffic::Buses, dbcs: &[Dbc]) -> Page {
        let unit = if self.bit_rate_bit_s.is_some() { "%" } else { "kbit/s" };
        let mut chart = Chart::new("Bus load").x_axis("time", "s").y_axis("load", unit);
        let mut most = 1.0_f64;
        for (bus, counts) in self.counts.iter().enumerate() {
            let role = [Role::Response, Role::Left, Role::Right, Role::Estimate][bus % 4];
            let points = counts.load(self.bit_rate_bit_s, self.span_s());
            most = points.iter().fold(most, |most, (_, load)| most.max(*load));
            chart = chart.series(Series::new(names.name(bus as u16), role, Stroke::Solid, points));
        }
        let chart = chart.y_range(0.0, 1.1 * most);
        let section = Section::new("Buses").table(self.table(names));
        page.section(section.figure(Figure::new("Load", "Mean of each stretch of time.", vec![chart])))
            .section(Section::new("Messages").table(self.messages(names, dbcs)))
    }

    fn table(&self, names: &traffic::Buses) -> Table {
        let columns = ["frames", "sent from here", "error frames", "lost"].map(|name| Column::number(name, "", 0));
        let table = Table::new([Column::text("bus")].into_iter().chain(columns));
        self.counts.iter().enumerate().fold(table, |table, (bus, counts)| {
            let numbers = [counts.frames, counts.sent, counts.errors, counts.lost].map(|count| (count as f64).into());
            table.row([names.name(bus as u16).into()].into_iter().chain(numbers))
        })
    }

    fn messages(&self, names: &traffic::Buses, dbcs: &[Dbc]) -> Table {
        let table = Table::new([
            Column::text("bus"),
            Column::text("id"),
            Column::text("message"),
            Column::number("frames", "", 0),
            Column::number("bytes", "", 0),
            Column::number("mean period", "ms", 3),
            Column::number("longest gap", "ms", 3),
        ]);
        self.messages.iter().fold(table, |table, (&(bus, is_extended, id), message)| {
            let id = if is_extended { CanId::Extended(id) } else { CanId::Standard(id as u16) };
            let known = dbcs.iter().find_map(|dbc| dbc.message_by_id(id));
            let mean_s = (message.last_s - message.first_s) / (message.count.max(2) - 1) as f64;
            table.row([
                names.name(bus).into(),
                named(id).as_str().into(),
                known.map_or("", |message| message.name.as_str()).into(),
                (message.count as f64).into(),
                (message.bytes as f64).into(),
                (mean_s * 1e3).into(),
                (message.longest_gap_s * 1e3).into(),
            ])
        })
    }
}

fn named(id: CanId) -> String {
    if id.is_extended() { format!("{:08X}", id.raw()) } else { format!("{:03X}", id.raw()) }
}

impl Counts {
    fn take_bits(&mut self, at_s: f64, bits: u64) {
        if self.stretch_s == 0.0 {
            self.stretch_s = STRETCH_S;
        }
        while at_s >= self.stretch_s * MOST_STRETCHES as f64 {
            self.bits = self.bits.chunks(2).map(|two| two.iter().sum()).collect();
            self.stretch_s *= 2.0;
        }
        let stretch = (at_s.max(0.0) / self.stretch_s) as usize;
        if stretch >= self.bits.len() {
            self.bits.resize(stretch + 1, 0);
        }
        self.bits[stretch] += bits;
    }

    /// Over time, in steps: in percent where the bit rate is known, else in kbit/s.
    fn load(&self, bit_rate_bit_s: Option<u32>, span_s: f64) -> Vec<(f64, f64)> {
        let whole = bit_rate_bit_s.map_or(1e3, |rate| f64::from(rate) / 100.0);
        let step = |(nth, bits): (usize, &u64)| {
            let from_s = nth as f64 * self.stretch_s;
            let until_s = (from_s + self.stretch_s).min(span_s);
            // A last stretch that hardly began says nothing.
            let is_long = until_s - from_s > 0.5 * self.stretch_s;
            let load = *bits as f64 / whole / (until_s - from_s);
            is_long.then_some([(from_s, load), (until_s, load)])
        };
        self.bits.iter().enumerate().filter_map(step).flatten().collect()
    }
}
