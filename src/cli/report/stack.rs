//! What the stack in a log did.

use crate::event::{Tick, Timing};
use crate::replay::{Recorded, RecordedItem};
use crate::report::{Chart, Column, Curve, Figure, Page, Role, Section, Series, Stroke, Table, stack_states, steps};
use crate::time::Instant;

/// The stack's course.
#[derive(Default)]
pub struct Stack {
    ticks: u64,
    last_s: f64,
    period_s: f64,
    track: Vec<(f64, f64)>,
    reference: Vec<(f64, f64)>,
    /// Every how many ticks a place is kept.
    every: u64,
    error_m: Curve,
    torque_right_nm: Curve,
    torque_left_nm: Curve,
    /// Changes of its state: time, s, and number.
    state: Vec<(f64, f64)>,
    lateness_us: Curve,
    notices: Vec<(u64, String, String)>,
}

/// Places on the track at most.
const MOST_PLACES: usize = 4000;
/// Notices listed at most.
const MOST_NOTICES: usize = 500;
impl Stack {
    /// That in the bytes of a log with these texts attached.
    ///
    /// # Errors
    /// Why the log cannot be read on.
    pub fn read(log: &[u8], attached: &[(String, String)]) -> Result<Self, String> {
        let mut stack = Self { every: 1, ..Self::default() };
        let configurations = attached.iter().filter(|(name, _)| name.ends_with(".toml"));
        configurations.for_each(|(_, text)| stack.take_period(text));
        for item in Recorded::new(log)? {
            match item? {
                RecordedItem::Tick(tick) => stack.take_tick(&tick),
                RecordedItem::Timing(timing) => stack.take_timing(&timing),
                RecordedItem::Notice(at_ns, kind, text) if stack.notices.len() < MOST_NOTICES => {
                    stack.notices.push((at_ns, kind, text));
                }
                _ => {}
            }
        }
        Ok(stack)
    }

    /// Whether the log knows of a stack at all.
    pub const fn has_any(&self) -> bool {
        self.ticks > 0
    }

    /// Adds what there is to say. `seconds` tells how long after the beginning of
    /// the log a moment was.
    pub fn sections(self, page: Page, seconds: impl Fn(Instant) -> f64) -> Page {
        let over_time = |title: &str| Chart::new(title).x_axis("time", "s");
        let line = |name: &str, role, points| Series::new(name, role, Stroke::Solid, points);
        let track = Chart::new("Track in the plane")
            .x_axis("x", "m")
            .y_axis("y", "m")
            .equal_aspect()
            .series(Series::reference(self.reference))
            .series(line("odometry", Role::Estimate, self.track));
        let error = over_time("Position error by odometry").y_axis("distance from the path", "m").series(line(
            "odometry",
            Role::Estimate,
            self.error_m.points(),
        ));
        let torque = over_time("Torque sent")
            .y_axis("torque", "N m")
            .series(line("right wheel", Role::Right, self.torque_right_nm.points()))
            .series(line("left wheel", Role::Left, self.torque_left_nm.points()));
        let state = steps(self.state.into_iter(), self.last_s);
        let state = stack_states(over_time("State of the stack"), state);
        let mut charts = vec![track, error, torque, state];
        let lateness = self.lateness_us.points();
        if !lateness.is_empty() {
            let chart = over_time("How late the loop woke up").y_axis("lateness", "us");
            charts.push(chart.series(line("lateness", Role::Response, lateness)));
        }
        let caption = "Of each stretch of time the least and the greatest value are drawn, so that no spike is lost.";
        let table = Table::new([Column::number("time", "s", 3), Column::text("kind"), Column::prose("what")]);
        let table = self.notices.iter().fold(table, |table, (at_ns, kind, text)| {
            let at_s = seconds(Instant::from_nanos(at_ns.cast_signed()));
            table.row([at_s.into(), kind.as_str().into(), text.as_str().into()])
        });
        page.section(Section::new("The stack").figure(Figure::new("Whole log", caption, charts)))
            .section(Section::new("What happened").table(table))
    }

    /// A log's configuration says how long a tick is.
    fn take_period(&mut self, text: &str) {
        let period = text.parse::<toml::Table>().ok().and_then(|table| table.get("period_s")?.as_float());
        self.period_s = period.unwrap_or(self.period_s);
    }

    fn take_tick(&mut self, values: &[f64; Tick::NAMES.len()]) {
        let value = |name: &str| Tick::NAMES.iter().position(|known| *known == name).map_or(f64::NAN, |at| values[at]);
        let at_s = values[0] * if self.period_s > 0.0 { self.period_s } else { 1.0 };
        let (here, there) =
            ((value("odometry_x_m"), value("odometry_y_m")), (value("reference_x_m"), value("reference_y_m")));
        if self.ticks.is_multiple_of(self.every) {
            self.track.push(here);
            self.reference.push(there);
            if self.track.len() > MOST_PLACES {
                self.every *= 2;
                halve(&mut self.track);
                halve(&mut self.reference);
            }
        }
        self.ticks += 1;
        self.last_s = at_s;
        self.error_m.take(at_s, libm::hypot(here.0 - there.0, here.1 - there.1));
        self.torque_right_nm.take(at_s, value("torque_sent_right_nm"));
        self.torque_left_nm.take(at_s, value("torque_sent_left_nm"));
        let state = value("state");
        if self.state.last().is_none_or(|(_, before)| *before != state) {
            self.state.push((at_s, state));
        }
    }

    fn take_timing(&mut self, values: &[f64; Timing::NAMES.len()]) {
        let at_s = values[0] * if self.period_s > 0.0 { self.period_s } else { 1.0 };
        self.lateness_us.take(at_s, values[1] * 1e6);
    }
}

/// Leaves every other place.
fn halve(places: &mut Vec<(f64, f64)>) {
    let mut nth = 0;
    places.retain(|_| {
        nth += 1;
        nth % 2 == 1
    });
}
