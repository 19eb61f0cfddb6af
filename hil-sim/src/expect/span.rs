//! When an expectation looks.

/// A span of simulated time, counted from the run's beginning or from a mark.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// Its beginning, s.
    pub from_s: f64,
    /// Its end, s; that of the run where it is not given.
    pub until_s: Option<f64>,
    /// The mark from which both are counted: the first of its name.
    pub after: Option<String>,
    /// How long the run is, s.
    pub duration_s: f64,
    /// The run was made shorter by somebody else than who wrote the
    /// expectation: what it does not reach is not held against it.
    pub shortened: bool,
}

impl Span {
    /// Beginning and end, s from the run's beginning, once the mark came at
    /// `origin_s`.
    pub fn around(&self, origin_s: f64) -> (f64, f64) {
        let until_s = self.until_s.map_or(self.duration_s, |until_s| origin_s + until_s);
        let cut_s = if self.shortened { until_s.min(self.duration_s) } else { until_s };
        (origin_s + self.from_s, cut_s)
    }

    /// Time by which a sample may miss the span and be counted in, s. Times of
    /// a scenario are meant for the ticks next to them, so a bound at a tick's
    /// time holds for that tick; what is counted from a mark is exact.
    pub fn grace_s(&self, period_s: f64) -> f64 {
        if self.after.is_some() { 1e-9 } else { 0.5 * period_s }
    }
}
