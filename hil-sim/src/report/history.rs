//! Follows a run and keeps what its page shows.

use std::borrow::Cow;

use canloop::bus::BitRates;
use canloop::event::{BusFrame, Event, Sink, Tick, Truth};
use canloop::frame::CanId;
use canloop::report::{Curve, LoadCurve};
use canloop::robot::Pose;
use canloop::schema::{DriveState, Message, Profile};
use canloop::time::Instant;
use canloop::wheels::Wheels;

use crate::scenario::{Link, Scenario};

/// A run, thinned to what a picture can show.
#[derive(Clone, Debug)]
pub struct History {
    period_s: f64,
    rates: BitRates,
    profile: Profile,
    /// Where the robot was, and where the path wanted it.
    pub(super) track: Vec<(Pose, Pose)>,
    /// Periods from one place of the track to the next.
    track_every: u64,
    reference: Pose,
    pub(super) position_error_m: Curve,
    pub(super) torque_nm: Wheels<Curve>,
    load: LoadCurve,
    /// Changes of the stack's state: time, s, and number.
    pub(super) states: Vec<(f64, u8)>,
    /// Changes of the drives' states.
    pub(super) drive_states: Wheels<Vec<(f64, DriveState)>>,
    messages: Vec<Seen>,
    /// Names of the scenario's events.
    planned: Vec<String>,
    pub(super) moments: Vec<Moment>,
    pub(super) last_s: f64,
}

/// What is known of the frames with one id and length.
#[derive(Clone, Copy, Debug)]
struct Seen {
    id: CanId,
    len: usize,
    /// Bit times that the last one looked at took. Others have a few stuff
    /// bits more or less, which no picture shows.
    bits: u32,
    /// When one is to be looked at again, s.
    next_look_s: f64,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Moment {
    pub at_s: f64,
    pub kind: &'static str,
    pub text: Cow<'static, str>,
}

/// Places of a track, at most.
const MOST_PLACES: usize = 2000;
/// Periods in a stretch of which the bus load is told, at least: each sends its frames at once, so the
/// load of few of them depends on where the stretch is cut.
const LOAD_PERIODS: f64 = 20.0;
/// Time from one look at a message to the next, s.
const LOOK_S: f64 = 0.1;
/// Things that happened, at most: a page lists no more.
const MOMENTS: usize = 200;

impl History {
    /// Nothing has happened yet.
    pub fn new(scenario: &Scenario) -> Self {
        let period_s = scenario.period_s();
        Self {
            period_s,
            rates: match scenario.link {
                Link::Can(rates) => rates,
                Link::Ideal => BitRates::both(u32::MAX),
            },
            profile: scenario.stack.profile.clone(),
            track: Vec::new(),
            track_every: 1,
            reference: Pose::default(),
            position_error_m: Curve::default(),
            torque_nm: Wheels::default(),
            load: LoadCurve::new(LOAD_PERIODS * period_s),
            states: Vec::new(),
            drive_states: Wheels::default(),
            messages: Vec::new(),
            planned: scenario.events.iter().map(|event| event.name.clone()).collect(),
            moments: Vec::new(),
            last_s: 0.0,
        }
    }

    /// The bus load in percent over time, in steps.
    pub(super) fn load_percent(&self) -> Vec<(f64, f64)> {
        self.load.points(self.last_s, f64::from(self.rates.nominal_bit_s) / 100.0)
    }

    fn take_truth(&mut self, truth: &Truth) {
        let at_s = truth.tick as f64 * self.period_s;
        self.last_s = self.last_s.max(at_s);
        self.position_error_m.take(at_s, truth.position_error_m);
        if truth.tick.is_multiple_of(self.track_every) {
            self.track.push((truth.pose, self.reference));
        }
        if self.track.len() > MOST_PLACES {
            self.track = self.track.iter().step_by(2).copied().collect();
            self.track_every *= 2;
        }
    }

    fn take_tick(&mut self, tick: &Tick) {
        let at_s = tick.tick as f64 * self.period_s;
        self.torque_nm.right.take(at_s, tick.torque_sent_nm.right);
        self.torque_nm.left.take(at_s, tick.torque_sent_nm.left);
        if self.states.last().is_none_or(|(_, state)| *state != tick.state) {
            self.states.push((at_s, tick.state));
        }
    }

    /// States and lengths change little, so of each message one frame now and
    /// then is looked at: all of them would take a tenth of the run's time.
    fn take_frame(&mut self, at_s: f64, crossed: &BusFrame) {
        let (id, len) = (crossed.frame.id, crossed.frame.len());
        let is_same = |seen: &Seen| seen.id == id && seen.len == len;
        let nth = self.messages.iter().position(is_same).unwrap_or_else(|| {
            self.messages.push(Seen { id, len, bits: 0, next_look_s: f64::NEG_INFINITY });
            self.messages.len() - 1
        });
        let seen = &mut self.messages[nth];
        let looks = at_s >= seen.next_look_s;
        if looks {
            let span_s = self.rates.frame(&crossed.frame).as_secs_f64();
            let bits = (span_s * f64::from(self.rates.nominal_bit_s)).round() as u32;
            (seen.bits, seen.next_look_s) = (bits, at_s + LOOK_S);
        }
        let bits = u64::from(seen.bits);
        self.load.take(at_s, bits);
        if looks && !crossed.sent_by_stack {
            self.look_at(at_s, crossed);
        }
    }

    fn look_at(&mut self, at_s: f64, crossed: &BusFrame) {
        let (wheel, state) = match self.profile.decode(&crossed.frame) {
            Ok(Message::Feedback(wheel, feedback)) => (wheel, feedback.state),
            Ok(Message::Heartbeat(wheel, heartbeat)) => (wheel, heartbeat.state),
            _ => return,
        };
        let Some(state) = state.map(|state| self.profile.conversation.meaning(state)) else { return };
        let states = &mut self.drive_states[wheel];
        if states.last().is_none_or(|(_, last)| *last != state) {
            states.push((at_s, state));
        }
    }
}

impl Sink for History {
    fn event(&mut self, at: Instant, event: &Event) {
        match event {
            Event::Frame(crossed) => self.take_frame(at.as_secs_f64(), crossed),
            Event::Sync(sync) => self.reference = sync.reference,
            Event::Truth(truth) => self.take_truth(truth),
            Event::Tick(tick) => self.take_tick(tick),
            Event::Notice(notice) if self.moments.len() < MOMENTS => {
                self.moments.push(Moment { at_s: at.as_secs_f64(), kind: notice.kind, text: notice.text.into() });
            }
            Event::Mark(mark) if self.moments.len() < MOMENTS => {
                let text = mark.text(&self.planned);
                self.moments.push(Moment { at_s: at.as_secs_f64(), kind: "event", text: text.into() });
            }
            Event::Notice(_) | Event::Mark(_) | Event::Timing(_) | Event::Exchange(_) => {}
        }
    }
}
