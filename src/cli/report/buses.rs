//! What is on the buses of a log, and how much of them is taken.

use crate::bus::frame_bits;
use crate::report::{Chart, Column, Figure, LoadCurve, Page, Role, Section, Series, Stroke, Table};
use crate::schema::Dbc;
use crate::time::Instant;
use crate::traffic::{self, Record, Survey};

/// Gathered record by record.
pub struct Buses {
    bit_rate_bit_s: Option<u32>,
    first: Option<Instant>,
    last: Instant,
    survey: Survey,
    /// By bus.
    loads: Vec<LoadCurve>,
}

/// Stretches of the load at first, s.
const STRETCH_S: f64 = 0.1;

impl Buses {
    /// Nothing yet.
    pub fn new(bit_rate_bit_s: Option<u32>) -> Self {
        Self { bit_rate_bit_s, first: None, last: Instant::ZERO, survey: Survey::new(None), loads: Vec::new() }
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
        self.survey.add(record);
        let bus = usize::from(record.bus);
        if bus >= self.loads.len() {
            self.loads.resize(bus + 1, LoadCurve::new(STRETCH_S));
        }
        if let Some(frame) = record.frame() {
            let at_s = self.seconds(record.at);
            self.loads[bus].take(at_s, u64::from(frame_bits(frame)));
        }
    }

    /// Adds what there is to say.
    pub fn sections(&self, page: Page, names: &traffic::Buses, dbcs: &[Dbc]) -> Page {
        // Of the bit rate in percent, where it is known.
        let (unit, whole_bit_s) = self.bit_rate_bit_s.map_or(("kbit/s", 1e3), |rate| ("%", f64::from(rate) / 100.0));
        let mut chart = Chart::new("Bus load").x_axis("time", "s").y_axis("load", unit);
        let mut most = 1.0_f64;
        for (bus, load) in self.loads.iter().enumerate() {
            let role = [Role::Response, Role::Left, Role::Right, Role::Estimate][bus % 4];
            let points = load.points(self.span_s(), whole_bit_s);
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
        self.survey.buses().iter().enumerate().fold(table, |table, (nth, bus)| {
            let numbers = [bus.frames, bus.sent, bus.errors, bus.lost].map(|count| (count as f64).into());
            table.row([names.name(nth as u16).into()].into_iter().chain(numbers))
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
        self.survey.messages().fold(table, |table, (bus, message)| {
            let known = dbcs.iter().find_map(|dbc| dbc.message_by_id(message.id));
            let longest_gap_s = message.longest_gap.map_or(0.0, |(gap, _)| gap.as_secs_f64());
            table.row([
                names.name(bus).into(),
                message.id.to_string().as_str().into(),
                known.map_or("", |message| message.name.as_str()).into(),
                (message.count as f64).into(),
                (message.lengths.1 as f64).into(),
                (message.mean_period_s() * 1e3).into(),
                (longest_gap_s * 1e3).into(),
            ])
        })
    }
}
