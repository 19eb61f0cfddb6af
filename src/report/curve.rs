//! A signal over a whole run, in no more points than a picture shows.

/// The least and the greatest sample of each stretch of time, so that no spike
/// is lost. Stretches get longer as the run does.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// At first every sample is kept.
    stretch_s: f64,
    /// The stretch that is going on.
    current: Option<Stretch>,
    points: Vec<(f64, f64)>,
}

#[derive(Clone, Copy, Debug)]
struct Stretch {
    until_s: f64,
    low: (f64, f64),
    high: (f64, f64),
}

/// Points of a curve, at most; a chart is some 370 pixels wide.
const MOST_POINTS: usize = 3000;

impl Curve {
    /// Takes a sample, later than all before; what is no number is left out.
    pub fn take(&mut self, at_s: f64, value: f64) {
        let sample = (at_s, value);
        match &mut self.current {
            Some(stretch) if at_s < stretch.until_s => {
                if value < stretch.low.1 {
                    stretch.low = sample;
                }
                if value > stretch.high.1 {
                    stretch.high = sample;
                }
            }
            _ if value.is_finite() => {
                self.end_stretch();
                self.current = Some(Stretch { until_s: at_s + self.stretch_s, low: sample, high: sample });
                if self.points.len() > MOST_POINTS {
                    self.thin();
                }
            }
            _ => {}
        }
    }

    /// Halves the number of points: two are left of each stretch.
    fn thin(&mut self) {
        let span_s = self.current.map_or(0.0, |stretch| stretch.low.0) - self.points[0].0;
        let mut thinner = Self { stretch_s: 4.0 * span_s / MOST_POINTS as f64, ..Self::default() };
        self.end_stretch();
        self.points.iter().for_each(|&(at_s, value)| thinner.take(at_s, value));
        *self = thinner;
    }

    /// Time (s) and value, in order of time.
    pub fn points(mut self) -> Vec<(f64, f64)> {
        self.end_stretch();
        self.points
    }

    fn end_stretch(&mut self) {
        let Some(Stretch { low, high, .. }) = self.current.take() else { return };
        let (first, second) = if low.0 <= high.0 { (low, high) } else { (high, low) };
        self.points.push(first);
        if second != first {
            self.points.push(second);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_of_one_sample_stays_in_a_long_run() {
        let mut curve = Curve::default();
        let wave = |nth: i32| if nth == 54_321 { -7.0 } else { f64::from(nth % 7) };
        (0..1_000_000).for_each(|nth| curve.take(f64::from(nth) * 0.01, wave(nth)));
        let points = curve.points();
        assert!((MOST_POINTS / 3..=MOST_POINTS + 2).contains(&points.len()), "{} points", points.len());
        assert!(points.contains(&(543.21, -7.0)) && points.is_sorted_by(|a, b| a.0 <= b.0));
    }

    #[test]
    fn a_short_run_keeps_every_sample() {
        let mut curve = Curve::default();
        (0..1000).for_each(|nth| curve.take(f64::from(nth), f64::from(nth % 7)));
        assert_eq!(curve.points().len(), 1000);
    }

    #[test]
    fn nothing_and_what_is_no_number_make_no_points() {
        let mut curve = Curve::default();
        assert!(curve.clone().points().is_empty());
        curve.take(0.0, f64::NAN);
        curve.take(0.1, 2.0);
        curve.take(0.2, f64::NAN);
        curve.take(0.3, f64::INFINITY);
        assert_eq!(curve.points(), [(0.1, 2.0)]);
    }
}
