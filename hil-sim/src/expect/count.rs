//! Counting.

use super::bounds::Bounds;
use super::verdict::Finding;

/// What was counted so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Count {
    number: u64,
    /// When it was the last time, s.
    last_at_s: Option<f64>,
    /// When there was one too many, s.
    beyond_at_s: Option<f64>,
}

impl Count {
    /// Counts one; says whether it is the first of those that are too many.
    pub fn take(&mut self, at_s: f64, bounds: &Bounds) -> bool {
        self.number += 1;
        self.last_at_s = Some(at_s);
        let is_first_beyond = self.beyond_at_s.is_none() && bounds.max.is_some_and(|max| self.number as f64 > max);
        if is_first_beyond {
            self.beyond_at_s = Some(at_s);
        }
        is_first_beyond
    }

    /// What came of it, the span having been seen to its end or not.
    pub fn finding(&self, bounds: &Bounds, seen_to_the_end: bool) -> Finding {
        let number = self.number as f64;
        let worst = Some((self.beyond_at_s.or(self.last_at_s).unwrap_or(f64::NAN), number));
        let last = self.last_at_s.map_or(String::new(), |at_s| format!(", the last at {at_s:.3} s"));
        let counted = format!("counted {}{last}", self.number);
        let is_enough = bounds.min.is_none_or(|min| number >= min);
        let (passed, text) = match self.beyond_at_s {
            Some(at_s) => (false, format!("{counted}; one too many at {at_s:.3} s")),
            None if !seen_to_the_end => (false, format!("the run ended before; {counted}")),
            None if !is_enough => (false, format!("{counted}, too few")),
            None => (true, counted),
        };
        Finding { passed, text, worst }
    }
}
