//! Coming to lie within bounds in time, and staying there for some time.

use super::bounds::Bounds;
use super::verdict::{Finding, Words};

/// What came of it so far.
#[derive(Clone, Debug)]
pub(super) struct Within {
    /// Until when the stay must have begun, s.
    deadline_s: f64,
    /// How long it must last, s.
    for_s: f64,
    /// When the stay that goes on began, s, and the value then.
    since: Option<(f64, f64)>,
    /// Beginning of the stay that was long enough.
    met: Option<(f64, f64)>,
    /// The longest stay that was not: beginning and length, s.
    longest_s: Option<(f64, f64)>,
    /// The sample nearest to the bounds, and its margin.
    nearest: Option<(f64, f64, f64)>,
}

/// Times that differ by less are the same, s.
const SAME_S: f64 = 1e-9;

impl Within {
    pub fn new(deadline_s: f64, for_s: f64) -> Self {
        Self { deadline_s, for_s, since: None, met: None, longest_s: None, nearest: None }
    }

    /// Takes a sample of the span and how far inside its bounds it is; says
    /// whether it is the one to look at.
    pub fn take(&mut self, at_s: f64, value: f64, margin: f64) -> bool {
        if self.met.is_some() {
            return false;
        }
        if margin < 0.0 {
            return self.leave(at_s, value, margin);
        }
        let begins = self.since.is_none() && at_s <= self.deadline_s + SAME_S;
        if begins {
            self.since = Some((at_s, value));
        }
        if let Some((since_s, _)) = self.since {
            let lasted_s = at_s - since_s;
            if lasted_s >= self.for_s - SAME_S {
                self.met = self.since;
            } else if self.longest_s.is_none_or(|(_, longest_s)| lasted_s >= longest_s) {
                self.longest_s = Some((since_s, lasted_s));
            }
        }
        begins
    }

    fn leave(&mut self, at_s: f64, value: f64, margin: f64) -> bool {
        let broke_a_stay = self.since.take().is_some();
        let is_late = at_s > self.deadline_s + SAME_S;
        let is_nearest = !is_late && self.nearest.is_none_or(|(.., nearest)| margin > nearest);
        if is_nearest {
            self.nearest = Some((at_s, value, margin));
        }
        broke_a_stay || is_nearest && self.longest_s.is_none()
    }

    /// What came of it by `last_s`, when the run ended.
    pub fn finding(&self, bounds: &Bounds, last_s: f64, words: &Words) -> Finding {
        if let Some((at_s, value)) = self.met {
            let text = format!("{} at {at_s:.3} s", words.value(value));
            return Finding { passed: true, text, worst: Some((at_s, value)) };
        }
        let nearest = self.nearest.map(|(at_s, value, _)| (at_s, value));
        let could_still = last_s < if self.since.is_some() { self.deadline_s + self.for_s } else { self.deadline_s };
        let mut finding = match (self.longest_s, nearest) {
            (Some((since_s, longest_s)), nearest) => {
                let text = format!("within bounds for {longest_s:.3} s at most, from {since_s:.3} s on");
                Finding { passed: false, text, worst: nearest }
            }
            (None, Some((at_s, value))) => {
                let excess = words.excess(bounds, value);
                let text = format!("nearest {} at {at_s:.3} s{excess}", words.value(value));
                Finding { passed: false, text, worst: nearest }
            }
            (None, None) => return Finding::ended_before(),
        };
        if could_still {
            finding.text = format!("the run ended before; {}", finding.text);
        }
        finding
    }
}
