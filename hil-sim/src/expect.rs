//! What must hold of a run, and whether it did.

use canloop::config::{Bound, Section, nearest};
use canloop::event::{Event, Tick, Truth};
use serde::Serialize;

/// A bound on a signal over a span of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Expectation {
    signal: Signal,
    from_s: f64,
    until_s: f64,
    min: Option<f64>,
    max: Option<f64>,
}

/// How an expectation fared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The signal.
    pub signal: &'static str,
    /// Beginning of the span, s.
    pub from_s: f64,
    /// End of the span, s.
    pub until_s: f64,
    /// Lower bound, if there is one.
    pub min: Option<f64>,
    /// Upper bound, if there is one.
    pub max: Option<f64>,
    /// Whether it held; false where the run ended early, true where it was
    /// never to reach the span.
    pub passed: bool,
    /// The value nearest to a bound or furthest beyond it.
    pub worst: Option<f64>,
    /// When that was, s.
    pub worst_at_s: Option<f64>,
}

/// Watches one expectation while the run goes on.
#[derive(Clone, Debug)]
pub struct Watch {
    expectation: Expectation,
    period_s: f64,
    worst: Option<Worst>,
    last_s: f64,
}

#[derive(Clone, Copy, Debug)]
struct Worst {
    /// How far inside the bounds; negative when outside.
    margin: f64,
    value: f64,
    at_s: f64,
}

/// Where in which event a signal stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Signal {
    Tick(usize),
    Truth(usize),
}

impl Expectation {
    /// Reads an `[[expect]]` table of a scenario that runs for `duration_s`.
    /// One that reaches beyond the end is a mistake, unless the run was
    /// `shortened` by somebody else than who wrote it.
    pub fn read(section: &Section<'_>, duration_s: f64, shortened: bool) -> Self {
        let expectation = Self {
            signal: read_signal(section),
            from_s: section.number_or("from_s", 0.0, Bound::NotNegative),
            until_s: section.number_or("until_s", duration_s, Bound::NotNegative),
            min: section.number_or_none("min", Bound::Finite),
            max: section.number_or_none("max", Bound::Finite),
        };
        let Self { min, max, .. } = expectation;
        if !section.has("min") && !section.has("max") {
            section.complain("signal", "found no bound on it, expected `max` or `min`");
        }
        if min > max && max.is_some() {
            section.complain("min", "found a `min` above `max`, expected it below");
        }
        if shortened {
            return Self { until_s: expectation.until_s.min(duration_s), ..expectation };
        }
        expectation.check_span(section, duration_s);
        expectation
    }

    fn check_span(&self, section: &Section<'_>, duration_s: f64) {
        let Self { from_s, until_s, .. } = *self;
        if until_s > duration_s {
            section.complain("until_s", &format!("found {until_s}, expected no more than `duration_s`, {duration_s}"));
        } else if from_s >= until_s {
            let label = format!("found {from_s}, expected a time before {until_s}");
            let problem = section.problem("from_s", "this span has no beginning within the run", &label);
            section.report(problem);
        }
    }

    /// Whether the run is to end before the span begins.
    fn is_out_of_reach(&self) -> bool {
        self.from_s >= self.until_s
    }

    /// Starts watching a run with period `period_s`.
    pub fn watch(&self, period_s: f64) -> Watch {
        Watch { expectation: self.clone(), period_s, worst: None, last_s: f64::NEG_INFINITY }
    }
}

impl Watch {
    /// Takes an event.
    pub fn event(&mut self, event: &Event) {
        match (self.expectation.signal, event) {
            (Signal::Truth(index), Event::Truth(truth)) => self.sample(truth.tick, truth.values()[index]),
            (Signal::Tick(index), Event::Tick(tick)) => self.sample(tick.tick, tick.values()[index]),
            _ => {}
        }
    }

    /// The verdict, once the run is over.
    pub fn verdict(&self) -> Verdict {
        let Expectation { signal, from_s, until_s, min, max } = self.expectation;
        // The last tick of a run has no period of its own, so allow for one.
        let seen_to_the_end = self.last_s >= until_s - 1.5 * self.period_s;
        Verdict {
            signal: signal.name(),
            from_s,
            until_s,
            min,
            max,
            passed: self.expectation.is_out_of_reach()
                || seen_to_the_end && self.worst.is_some_and(|worst| worst.margin >= 0.0),
            worst: self.worst.map(|worst| worst.value),
            worst_at_s: self.worst.map(|worst| worst.at_s),
        }
    }

    fn sample(&mut self, tick: u64, value: f64) {
        let at_s = tick as f64 * self.period_s;
        self.last_s = at_s;
        let Expectation { from_s, until_s, min, max, .. } = self.expectation;
        // Half a period of grace, so that a bound at a tick's time holds for that tick.
        if at_s < from_s - 0.5 * self.period_s || at_s > until_s + 0.5 * self.period_s {
            return;
        }
        let above = min.map_or(f64::INFINITY, |min| value - min);
        let below = max.map_or(f64::INFINITY, |max| max - value);
        let margin = if value.is_finite() { above.min(below) } else { f64::NEG_INFINITY };
        if self.worst.is_none_or(|worst| margin < worst.margin) {
            self.worst = Some(Worst { margin, value, at_s });
        }
    }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{}", self.signal)?;
        if let Some(min) = self.min {
            write!(out, " >= {min}")?;
        }
        if let Some(max) = self.max {
            write!(out, " <= {max}")?;
        }
        write!(out, " from {} s to {} s: ", self.from_s, self.until_s)?;
        match (self.passed, self.worst, self.worst_at_s) {
            (true, Some(worst), Some(at)) => write!(out, "held, worst {worst:.6} at {at:.3} s"),
            (false, Some(worst), Some(at)) => write!(out, "FAILED, worst {worst:.6} at {at:.3} s"),
            (true, ..) => write!(out, "not reached, the run was made shorter"),
            _ => write!(out, "FAILED, the run ended before"),
        }
    }
}

impl Signal {
    const fn name(self) -> &'static str {
        match self {
            Self::Tick(index) => Tick::NAMES[index],
            Self::Truth(index) => Truth::NAMES[index],
        }
    }
}

fn read_signal(section: &Section<'_>) -> Signal {
    let name = section.text("signal");
    let position = |names: &[&str]| names.iter().position(|known| *known == name);
    if let Some(index) = position(&Truth::NAMES) {
        return Signal::Truth(index);
    }
    if let Some(index) = position(&Tick::NAMES) {
        return Signal::Tick(index);
    }
    if section.has("signal") {
        let all = || Truth::NAMES.iter().chain(&Tick::NAMES).copied();
        let list = all().collect::<Vec<_>>().join(", ");
        let problem = section.problem("signal", "there is no such signal", &format!("found {name:?}"));
        section.report(match nearest(&name, all()) {
            Some(near) => problem.help(format!("did you mean `{near}`? There are {list}")),
            None => problem.help(format!("there are {list}")),
        });
    }
    Signal::Truth(0)
}
