//! What must hold of a robot whatever goes wrong with it.

use canloop::config::{Bound, Section};
use canloop::event::{Event, Sink, Tick, Truth};
use canloop::safety::State;
use canloop::time::Instant;
use canloop::wheels::Wheels;

use crate::bench::{End, Outcome};
use crate::scenario::Scenario;

/// Limits of what may happen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Invariants {
    /// How long after a trip there may be torque at a wheel, s.
    pub zero_within_s: f64,
    /// How long after a trip a wheel may turn, s.
    pub rest_within_s: f64,
    /// How far from its path the robot may get without a trip, m.
    pub undetected_m: f64,
    /// Of every so many runs, the log of one must have all frames.
    pub log_of_every: usize,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The robot went on, near its path.
    Survived,
    /// The stack tripped, and the robot came to rest in time.
    TrippedSafely,
    /// Something happened that must not.
    Violated(String),
}

/// Watches a run.
pub struct Judge {
    invariants: Invariants,
    period_s: f64,
    torque_limit_nm: f64,
    tripped_at_s: Option<f64>,
    /// The furthest from the path before a trip, m.
    furthest_m: f64,
    /// What was violated first.
    violation: Option<String>,
}

/// Trips have numbers from here on: [`State::code`].
const TRIPPED: u8 = 10;
/// Rounding of a mean.
const ROUNDING_NM: f64 = 1e-9;

impl Invariants {
    /// Reads an `[invariants]` section.
    pub fn read(section: &Section<'_>) -> Self {
        Self {
            zero_within_s: section.number_or("zero_within_s", 0.1, Bound::Positive),
            rest_within_s: section.number_or("rest_within_s", 5.0, Bound::Positive),
            undetected_m: section.number_or("undetected_m", 0.25, Bound::Positive),
            log_of_every: section.integer_or("log_of_every", 10, 1, 1_000_000) as usize,
        }
    }
}

impl Judge {
    /// Watches a run of `scenario`.
    pub fn new(invariants: Invariants, scenario: &Scenario) -> Self {
        Self {
            invariants,
            period_s: scenario.period_s(),
            torque_limit_nm: scenario.stack.safety.torque_limit_nm,
            tripped_at_s: None,
            furthest_m: 0.0,
            violation: None,
        }
    }

    /// The verdict on a run that ended so.
    pub fn verdict(mut self, outcome: &Outcome) -> Verdict {
        let has_tripped = matches!(outcome.state, Some(State::Tripped(_)));
        if !has_tripped && self.furthest_m > self.invariants.undetected_m {
            let Self { furthest_m, .. } = self;
            self.violate(format!("the robot was {furthest_m:.3} m from its path, and nothing noticed"));
        }
        if !matches!(outcome.end, End::Finished) {
            self.violate(format!("the run ended early: {:?}", outcome.end));
        }
        match self.violation {
            Some(violation) => Verdict::Violated(violation),
            None if has_tripped => Verdict::TrippedSafely,
            None => Verdict::Survived,
        }
    }

    /// Something happened that must not; what did so first is told.
    pub fn violate(&mut self, what: String) {
        self.violation.get_or_insert(what);
    }

    fn take_tick(&mut self, tick: &Tick) {
        let at_s = tick.tick as f64 * self.period_s;
        let sent_nm = tick.torque_sent_nm;
        if !sent_nm.all(|torque| torque.abs() <= self.torque_limit_nm + ROUNDING_NM) {
            self.violate(format!("{:.3} s: torque beyond the limit was sent, {sent_nm:?}", at_s));
        }
        if tick.state >= TRIPPED {
            self.tripped_at_s.get_or_insert(at_s);
            if sent_nm != Wheels::default() {
                self.violate(format!("{at_s:.3} s: torque was sent after a trip, {sent_nm:?}"));
            }
        }
    }

    fn take_truth(&mut self, truth: &Truth) {
        let at_s = truth.tick as f64 * self.period_s;
        let Some(tripped_at_s) = self.tripped_at_s else {
            self.furthest_m = self.furthest_m.max(truth.position_error_m);
            return;
        };
        // The torque is that of the period that has ended.
        let Invariants { zero_within_s, rest_within_s, .. } = self.invariants;
        if at_s - self.period_s > tripped_at_s + zero_within_s
            && truth.torque_nm.any(|torque| torque.abs() > ROUNDING_NM)
        {
            self.violate(format!("{at_s:.3} s: torque at a wheel long after the trip at {tripped_at_s:.3} s"));
        }
        if at_s > tripped_at_s + rest_within_s && truth.speed_rad_s != Wheels::default() {
            self.violate(format!("{at_s:.3} s: a wheel turns long after the trip at {tripped_at_s:.3} s"));
        }
    }
}

impl Sink for Judge {
    fn event(&mut self, _at: Instant, event: &Event) {
        match event {
            Event::Tick(tick) => self.take_tick(tick),
            Event::Truth(truth) => self.take_truth(truth),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canloop::safety::Reason;

    const TRIP: State = State::Tripped(Reason::DriveFault);

    fn judge() -> Judge {
        let invariants = Invariants { zero_within_s: 0.1, rest_within_s: 1.0, undetected_m: 0.25, log_of_every: 10 };
        let scenario = Scenario::load("dac-friction", &[]).expect("it is shipped");
        Judge::new(invariants, &scenario)
    }

    /// The verdict on ticks in this state with this torque, of 10 s of truth
    /// with another one and this speed, and an end in that state.
    fn verdict(state: State, sent_nm: f64, true_nm: f64, speed_rad_s: f64, error_m: f64) -> Verdict {
        let mut judge = judge();
        for tick in 0..2000 {
            let state = state.code();
            let sent = Tick { tick, state, torque_sent_nm: Wheels { right: 0.0, left: sent_nm }, ..Tick::default() };
            judge.event(Instant::ZERO, &Event::Tick(sent));
            let (torque_nm, speed_rad_s) = (Wheels::both(true_nm), Wheels { right: speed_rad_s, left: 0.0 });
            let truth = Truth { tick, torque_nm, speed_rad_s, position_error_m: error_m, ..Truth::default() };
            judge.event(Instant::ZERO, &Event::Truth(truth));
        }
        let outcome = Outcome { end: End::Finished, ticks: 2000, wire: Default::default(), state: Some(state) };
        judge.verdict(&outcome)
    }

    fn violation(verdict: Verdict) -> String {
        let Verdict::Violated(what) = verdict else { panic!("{verdict:?}") };
        what
    }

    #[test]
    fn a_run_is_survived_or_tripped_safely() {
        assert_eq!(verdict(State::Running, 90.0, 90.0, 3.0, 0.2), Verdict::Survived);
        assert_eq!(verdict(TRIP, 0.0, 0.0, 0.0, 9.0), Verdict::TrippedSafely);
    }

    #[test]
    fn each_invariant_is_found_violated() {
        assert!(violation(verdict(State::Running, -90.1, 0.0, 0.0, 0.0)).contains("beyond the limit"));
        assert!(violation(verdict(State::Running, f64::NAN, 0.0, 0.0, 0.0)).contains("beyond the limit"));
        assert!(violation(verdict(TRIP, 0.1, 0.0, 0.0, 0.0)).contains("sent after a trip"));
        assert!(violation(verdict(TRIP, 0.0, 0.1, 0.0, 0.0)).contains("torque at a wheel"));
        assert!(violation(verdict(TRIP, 0.0, 0.0, 0.1, 0.0)).contains("a wheel turns"));
        assert!(violation(verdict(State::Running, 0.0, 0.0, 0.0, 0.3)).contains("0.300 m from its path"));
    }
}
