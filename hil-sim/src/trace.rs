//! What pictures are drawn from: where the robot was and should have been.

use canloop::event::{Event, Sink, Tick, Truth};
use canloop::robot::Pose;
use canloop::time::Instant;
use canloop::wheels::Wheels;

/// Samples of a run, a few thousand at most.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// In order of time.
    pub samples: Vec<Sample>,
    /// Torque sent (N m) in every period of a short window.
    pub torques: Vec<(f64, Wheels<f64>)>,
    every: u64,
    period_s: f64,
    reference: Pose,
}

/// One moment of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// s since the run began.
    pub time_s: f64,
    /// Where the path wanted the robot.
    pub reference: Pose,
    /// Where it was.
    pub pose: Pose,
    /// How far that is apart, m.
    pub position_error_m: f64,
}

/// Well after the start, with the robot in steady motion.
const TORQUE_WINDOW_S: std::ops::Range<f64> = 60.0..60.5;

impl Trace {
    /// Keeps about `samples` of a run of `ticks` periods, evenly spread.
    pub fn new(ticks: u64, period_s: f64, samples: u64) -> Self {
        Self { every: (ticks / samples).max(1), period_s, ..Self::default() }
    }

    fn take_torque(&mut self, tick: &Tick) {
        let time_s = tick.tick as f64 * self.period_s;
        if TORQUE_WINDOW_S.contains(&time_s) {
            self.torques.push((time_s, tick.torque_sent_nm));
        }
    }

    fn take(&mut self, truth: &Truth) {
        if truth.tick.is_multiple_of(self.every) {
            self.samples.push(Sample {
                time_s: truth.tick as f64 * self.period_s,
                reference: self.reference,
                pose: truth.pose,
                position_error_m: truth.position_error_m,
            });
        }
    }
}

impl Sink for Trace {
    fn event(&mut self, _at: Instant, event: &Event) {
        match event {
            Event::Sync(sync) => self.reference = sync.reference,
            Event::Truth(truth) => self.take(truth),
            Event::Tick(tick) => self.take_torque(tick),
            _ => {}
        }
    }
}
