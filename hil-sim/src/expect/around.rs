//! The samples around the moment that matters most.

use std::collections::VecDeque;

/// Samples kept to either side.
const EITHER_SIDE: usize = 200;

/// Keeps the last samples, and those around the last moment that was marked.
#[derive(Clone, Debug, Default)]
pub(super) struct Around {
    last: VecDeque<(f64, f64)>,
    /// Samples since the moment, while its surroundings are incomplete.
    since: Option<usize>,
    kept: Vec<(f64, f64)>,
}

impl Around {
    /// Takes a sample: time (s) and value. One that `matters` is the moment
    /// from now on.
    pub fn take(&mut self, sample: (f64, f64), matters: bool) {
        if self.last.len() > 2 * EITHER_SIDE {
            self.last.pop_front();
        }
        self.last.push_back(sample);
        if matters {
            self.since = Some(0);
        } else if let Some(since) = &mut self.since {
            *since += 1;
            if *since == EITHER_SIDE {
                self.keep();
            }
        }
    }

    /// The samples around the moment, or the last ones where there was none.
    pub fn samples(mut self) -> Vec<(f64, f64)> {
        if self.since.is_some() || self.kept.is_empty() {
            self.keep();
        }
        self.kept
    }

    fn keep(&mut self) {
        self.kept = self.last.iter().copied().collect();
        self.since = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_samples_are_kept_before_a_moment_as_after_it() {
        let mut around = Around::default();
        (0..5000).for_each(|nth| around.take((f64::from(nth), 1.0), nth == 900 || nth == 1000));
        let kept = around.samples();
        assert_eq!((kept.first(), kept.last(), kept.len()), (Some(&(800.0, 1.0)), Some(&(1200.0, 1.0)), 401));
    }

    #[test]
    fn a_run_that_ends_soon_after_keeps_what_there_is() {
        let mut around = Around::default();
        (0..3).for_each(|nth| around.take((f64::from(nth), 1.0), nth == 1));
        assert_eq!(around.samples().len(), 3);
    }
}
