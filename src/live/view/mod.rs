//! What the page shows of a run: events folded into a state of bounded size,
//! and what of it is news to a viewer who has seen some of it already.
//!
//! Nothing in here reads a clock, waits, or knows of a network.

mod bus;
mod happenings;
mod news;
mod now;
mod strip;
mod track;

use bus::BusView;
use happenings::Happenings;
pub use news::Seen;
use news::{News, RunFacts, Viewing};
use now::Now;
use strip::{Row, Strip, WhenFull};
use track::Track;

use super::Run;
use crate::event::{Event, Sink, Tick, Truth};
use crate::safety::{Reason, State};
use crate::time::Instant;

/// Time that the finest row of a chart spans, s.
const STRETCH_S: f64 = 0.1;
/// Time over which the bus load is told, s.
const LOAD_S: f64 = 1.0;

/// A run as far as it has come.
#[derive(Clone, Debug)]
pub struct View {
    facts: RunFacts,
    start: Instant,
    planned: Vec<String>,
    bit_rate_bit_s: Option<f64>,
    now: Now,
    bus: BusView,
    /// The last minute.
    recent: Strip,
    /// The whole run.
    whole: Strip,
    track: Track,
    happenings: Happenings,
    /// Whether the run is a simulation, which knows the truth.
    knows_truth: bool,
    /// Whether the stack is in this program, and tells what it does.
    knows_stack: bool,
    viewing: Viewing,
    ended: Option<String>,
}

impl View {
    /// Nothing has happened yet in the program's `number`th run.
    pub fn new(run: &Run<'_>, number: u64) -> Self {
        Self {
            facts: RunFacts::new(run, number),
            start: run.start,
            planned: run.contents.planned.clone(),
            bit_rate_bit_s: run.bit_rate_bit_s.map(f64::from),
            now: Now::default(),
            bus: BusView::new(&run.stack.profile),
            recent: Strip::new(WhenFull::Forget, STRETCH_S),
            whole: Strip::new(WhenFull::Halve, STRETCH_S),
            track: Track::new(),
            happenings: Happenings::default(),
            knows_truth: false,
            knows_stack: false,
            viewing: Viewing::default(),
            ended: None,
        }
    }

    /// So many events found no room on their way here.
    pub const fn lose_events(&mut self, events: u64) {
        self.viewing.events_lost += events;
    }

    /// Slow viewers went without so many updates.
    pub const fn miss_updates(&mut self, updates: u64) {
        self.viewing.updates_missed += updates;
    }

    /// The run is over; `verdict` says how it ended.
    pub fn end(&mut self, verdict: &str) {
        self.ended = Some(verdict.to_owned());
    }

    /// What is new to a viewer who has seen so much, as JSON.
    pub fn news(&self, seen: &mut Seen) -> String {
        let facts = seen.begin(self.facts.number).then_some(&self.facts);
        let news = News {
            run: facts,
            now: &self.now,
            drives: self.bus.drives(),
            frames: self.bus.frames(),
            load_percent: self.load_percent(),
            recent: self.recent.news(&mut seen.recent),
            whole: self.whole.news(&mut seen.whole),
            track: self.track.news(&mut seen.track),
            happened: self.happenings.news(&mut seen.happenings),
            viewing: self.viewing,
            ended: self.ended.as_deref(),
        };
        serde_json::to_string(&news).expect("news are plain data")
    }

    fn load_percent(&self) -> Option<f64> {
        Some(100.0 * self.recent.bits_per_s(LOAD_S)? / self.bit_rate_bit_s?)
    }

    fn rows(&mut self, at_s: f64, mut change: impl FnMut(&mut Row)) {
        change(self.recent.row_mut(at_s));
        change(self.whole.row_mut(at_s));
    }

    fn take_truth(&mut self, at_s: f64, truth: &Truth) {
        self.knows_truth = true;
        self.now.take_truth(truth, self.knows_stack);
        self.track.take(&truth.pose);
        let torque = (!self.knows_stack).then_some(truth.torque_nm);
        self.rows(at_s, |row| {
            row.position_error_m.take(truth.position_error_m);
            if let Some(torque_nm) = torque {
                row.torque_right_nm.take(torque_nm.right);
                row.torque_left_nm.take(torque_nm.left);
            }
        });
    }

    fn take_tick(&mut self, at_s: f64, tick: &Tick) {
        self.knows_stack = true;
        self.now.take_tick(tick, self.knows_truth);
        if !self.knows_truth {
            self.track.take(&tick.odometry);
        }
        let error_m = (!self.knows_truth).then(|| tick.odometry.distance_m(&tick.reference));
        self.rows(at_s, |row| {
            row.position_error_m.take(error_m.unwrap_or(f64::NAN));
            row.torque_right_nm.take(tick.torque_sent_nm.right);
            row.torque_left_nm.take(tick.torque_sent_nm.left);
        });
    }
}

impl Sink for View {
    fn event(&mut self, at: Instant, event: &Event) {
        let at_s = (at - self.start).as_secs_f64().max(0.0);
        self.now.pass(at_s);
        match event {
            Event::Frame(crossed) => {
                let bits = u64::from(self.bus.take(crossed));
                self.rows(at_s, |row| row.bits += bits);
            }
            Event::Sync(sync) => self.now.take_sync(sync),
            Event::Tick(tick) => self.take_tick(at_s, tick),
            Event::Truth(truth) => self.take_truth(at_s, truth),
            Event::Timing(timing) => self.now.take_timing(timing),
            Event::Notice(notice) => {
                self.now.take_notice(notice);
                self.happenings.take(at_s, notice.kind, notice.text);
            }
            Event::Exchange(_) => {}
            Event::Mark(mark) => self.happenings.take(at_s, "event", mark.text(&self.planned)),
        }
    }
}

/// The state that a number in the log stands for.
fn state_of(code: u8) -> Option<State> {
    match code {
        0 => Some(State::Boot),
        1 => Some(State::Stopped),
        2 => Some(State::Enabling),
        3 => Some(State::Running),
        4 => Some(State::Stopping),
        trip => Reason::ALL.get(usize::from(trip).checked_sub(10)?).map(|&reason| State::Tripped(reason)),
    }
}
