//! Simulated time held back to the wall clock's pace, for people who look on.
//! Only the wall clock sees it: what is simulated stays the same.

use std::time::{Duration, Instant};

use canloop::config::Problem;

use super::interrupt;
use crate::scenario::Scenario;

/// How fast simulated time may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RealTimeFactor {
    /// So many seconds of it a second.
    AtMost(f64),
    /// As fast as this machine can.
    Unlimited,
}

/// Holds a run back.
pub struct Pace {
    /// None where it goes as fast as it can.
    period: Option<Duration>,
    started: Instant,
}

/// How often to look whether somebody wants to stop.
const LOOK_UP: Duration = Duration::from_millis(20);

impl RealTimeFactor {
    /// Reads a number above 0, or `max`.
    ///
    /// # Errors
    /// Anything else.
    pub fn parse(text: &str) -> Result<Self, String> {
        match text.parse::<f64>() {
            _ if text == "max" => Ok(Self::Unlimited),
            Ok(factor) if (1e-3..=1e6).contains(&factor) => Ok(Self::AtMost(factor)),
            _ => Err(format!("expected a number from 0.001 to 1000000, or max, found {text:?}")),
        }
    }

    /// The one given; without one real time if somebody looks on, else no limit.
    pub fn or_default(given: Option<Self>, is_watched: bool) -> Self {
        given.unwrap_or(if is_watched { Self::AtMost(1.0) } else { Self::Unlimited })
    }

    /// Refuses one where the clock sets the pace anyway.
    ///
    /// # Errors
    /// One was given.
    pub fn refuse(given: Option<Self>) -> Result<(), Problem> {
        given.map_or(Ok(()), |_| {
            Err(Problem::bare("--real-time-factor will not do with --time wall")
                .help("by the clock time goes as fast as it does; leave one of the two out"))
        })
    }
}

impl Pace {
    /// The pace of a run of `scenario` that starts now.
    pub fn new(factor: RealTimeFactor, scenario: &Scenario) -> Self {
        let period = match factor {
            RealTimeFactor::AtMost(factor) => Some(Duration::from_secs_f64(scenario.period_s() / factor)),
            RealTimeFactor::Unlimited => None,
        };
        Self { period, started: now() }
    }

    /// Waits until period `tick` may begin, or somebody wants to stop.
    #[allow(clippy::disallowed_methods, reason = "people are waited for; nothing simulated waits")]
    pub fn keep(&self, tick: u64) {
        let Some(period) = self.period else { return };
        let due = period.mul_f64(tick as f64);
        while interrupt::check().is_continue()
            && let Some(early) = due.checked_sub(self.started.elapsed()).filter(|early| !early.is_zero())
        {
            std::thread::sleep(early.min(LOOK_UP));
        }
    }
}

#[allow(clippy::disallowed_methods, reason = "people look on by the wall clock; nothing simulated sees it")]
fn now() -> Instant {
    Instant::now()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_is_a_number_above_0_or_max() {
        assert_eq!(RealTimeFactor::parse("2.5"), Ok(RealTimeFactor::AtMost(2.5)));
        assert_eq!(RealTimeFactor::parse("max"), Ok(RealTimeFactor::Unlimited));
        for text in ["0", "-1", "nan", "inf", "1e9", "", "fast"] {
            let refusal = RealTimeFactor::parse(text).expect_err(text);
            assert!(refusal.contains("expected a number") && refusal.contains(&format!("{text:?}")), "{refusal}");
        }
    }

    #[test]
    fn a_run_that_somebody_looks_at_goes_at_real_time_unless_told_otherwise() {
        assert_eq!(RealTimeFactor::or_default(None, false), RealTimeFactor::Unlimited);
        assert_eq!(RealTimeFactor::or_default(None, true), RealTimeFactor::AtMost(1.0));
        let fast = RealTimeFactor::Unlimited;
        assert_eq!(RealTimeFactor::or_default(Some(fast), true), fast);
    }
}
