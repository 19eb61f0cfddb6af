//! Keeping to bounds all the while.

use super::bounds::Bounds;
use super::verdict::{Finding, Words};

/// What came of it so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Always {
    worst: Option<Worst>,
    /// When the bounds were left first, s.
    left_at_s: Option<f64>,
}

#[derive(Clone, Copy, Debug)]
struct Worst {
    /// How far inside the bounds; negative when outside.
    margin: f64,
    value: f64,
    at_s: f64,
}

impl Always {
    /// Takes a sample of the span and how far inside its bounds it is; says
    /// whether none was worse.
    pub fn take(&mut self, at_s: f64, value: f64, margin: f64) -> bool {
        if margin < 0.0 && self.left_at_s.is_none() {
            self.left_at_s = Some(at_s);
        }
        let is_worst = self.worst.is_none_or(|worst| margin < worst.margin);
        if is_worst {
            self.worst = Some(Worst { margin, value, at_s });
        }
        is_worst
    }

    /// What came of it, the span having been seen to its end or not.
    pub fn finding(&self, bounds: &Bounds, seen_to_the_end: bool, words: &Words) -> Finding {
        let Some(Worst { value, at_s, .. }) = self.worst else {
            return Finding::ended_before();
        };
        let worst = format!("{} at {at_s:.3} s", words.worst(value));
        let (passed, text) = match self.left_at_s {
            Some(left_at_s) => {
                let since = if left_at_s < at_s { format!("from {left_at_s:.3} s on, ") } else { String::new() };
                (false, format!("{since}{worst}{}", words.excess(bounds, value)))
            }
            None if seen_to_the_end => (true, worst),
            None => (false, format!("the run ended before; {worst}")),
        };
        Finding { passed, text, worst: Some((at_s, value)) }
    }
}
