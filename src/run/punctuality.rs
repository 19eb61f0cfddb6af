//! How punctual a real-time loop was, as histograms of its [`Timing`] events.

use std::fmt;

use hdrhistogram::Histogram;
use serde::Serialize;

use crate::event::{Event, Sink, Timing};
use crate::time::Instant;

/// Gathers timings while a loop runs.
pub struct Punctuality {
    period_s: f64,
    lateness: Histogram<u64>,
    jitter: Histogram<u64>,
    round_trip: Histogram<u64>,
    compute: Histogram<u64>,
    periods: u64,
    missed: u64,
}

/// All figures of a loop, as the summary holds them under `loop`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LoopFigures {
    /// Periods measured.
    pub periods: u64,
    /// Periods whose feedback did not come in time.
    pub missed: u64,
    /// How late the loop woke up.
    pub lateness: Spread,
    /// How far periods were from the wanted one.
    pub jitter: Spread,
    /// From SYNC to the last feedback that answered it.
    pub round_trip: Spread,
    /// What the stack took to make torques of feedback.
    pub compute: Spread,
}

/// A histogram in five numbers, us.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Half of all were shorter.
    pub p50_us: f64,
    /// 99 of 100 were shorter.
    pub p99_us: f64,
    /// 999 of 1000 were shorter.
    pub p999_us: f64,
    /// The longest.
    pub max_us: f64,
}

/// Longer than this, ns, counts as this: a minute.
const LONGEST_NS: u64 = 60_000_000_000;

impl Punctuality {
    /// Nothing gathered yet of a loop with this period.
    pub fn new(period_s: f64) -> Self {
        let empty = || Histogram::new_with_bounds(1, LONGEST_NS, 3).expect("constant bounds");
        Self {
            period_s,
            lateness: empty(),
            jitter: empty(),
            round_trip: empty(),
            compute: empty(),
            periods: 0,
            missed: 0,
        }
    }

    /// The loop's period, s.
    pub const fn period_s(&self) -> f64 {
        self.period_s
    }

    /// The figures so far.
    pub fn figures(&self) -> LoopFigures {
        LoopFigures {
            periods: self.periods,
            missed: self.missed,
            lateness: spread(&self.lateness),
            jitter: spread(&self.jitter),
            round_trip: spread(&self.round_trip),
            compute: spread(&self.compute),
        }
    }

    fn take(&mut self, timing: &Timing) {
        self.periods += 1;
        record(&mut self.lateness, timing.lateness_s);
        record(&mut self.jitter, (timing.period_s - self.period_s).abs());
        if timing.round_trip_s.is_finite() {
            record(&mut self.round_trip, timing.round_trip_s);
            record(&mut self.compute, timing.compute_s);
        } else {
            self.missed += 1;
        }
    }
}

impl Sink for Punctuality {
    fn event(&mut self, _at: Instant, event: &Event) {
        if let Event::Timing(timing) = event {
            self.take(timing);
        }
    }
}

impl fmt::Display for LoopFigures {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "{:<12} {:>10} {:>10} {:>10} {:>10}", "loop, us", "p50", "p99", "p99.9", "max")?;
        for (name, spread) in [
            ("lateness", self.lateness),
            ("jitter", self.jitter),
            ("round trip", self.round_trip),
            ("compute", self.compute),
        ] {
            let Spread { p50_us, p99_us, p999_us, max_us } = spread;
            writeln!(out, "{name:<12} {p50_us:>10.1} {p99_us:>10.1} {p999_us:>10.1} {max_us:>10.1}")?;
        }
        write!(out, "{} periods, {} without complete feedback", self.periods, self.missed)
    }
}

fn record(histogram: &mut Histogram<u64>, seconds: f64) {
    histogram.saturating_record(((seconds * 1e9) as u64).max(1));
}

fn spread(histogram: &Histogram<u64>) -> Spread {
    let at = |quantile: f64| histogram.value_at_quantile(quantile) as f64 / 1e3;
    Spread { p50_us: at(0.5), p99_us: at(0.99), p999_us: at(0.999), max_us: histogram.max() as f64 / 1e3 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_those_of_the_timings() {
        let mut punctuality = Punctuality::new(0.001);
        for tick in 0..1000 {
            let late = if tick == 999 { 5e-3 } else { 20e-6 };
            let round_trip_s = if tick % 100 == 0 { f64::NAN } else { 300e-6 };
            let timing = Timing { tick, lateness_s: late, period_s: 0.00101, round_trip_s, compute_s: 4e-6 };
            punctuality.event(Instant::ZERO, &Event::Timing(timing));
        }
        let figures = punctuality.figures();
        assert_eq!((figures.periods, figures.missed), (1000, 10));
        assert!((figures.lateness.p50_us - 20.0).abs() < 0.1);
        assert!((figures.lateness.max_us - 5000.0).abs() < 5.0);
        assert!((figures.jitter.p99_us - 10.0).abs() < 0.1);
        assert!((figures.round_trip.p50_us - 300.0).abs() < 1.0);
    }
}
