//! How full a bus was over time, in no more stretches than a picture shows.

/// Bits that crossed a bus in each stretch of time. Stretches get longer as the
/// run does.
#[derive(Clone, Debug)]
pub struct LoadCurve {
    bits: Vec<u64>,
    stretch_s: f64,
}

/// Stretches at most; a chart is some 370 pixels wide.
const MOST_STRETCHES: usize = 300;

impl LoadCurve {
    /// Nothing yet; stretches are this long at first, s.
    pub const fn new(stretch_s: f64) -> Self {
        Self { bits: Vec::new(), stretch_s }
    }

    /// So many bits crossed at this moment, s; what was before the beginning
    /// counts as at it.
    pub fn take(&mut self, at_s: f64, bits: u64) {
        while at_s >= MOST_STRETCHES as f64 * self.stretch_s {
            self.bits = self.bits.chunks(2).map(|two| two.iter().sum()).collect();
            self.stretch_s *= 2.0;
        }
        let stretch = (at_s / self.stretch_s) as usize;
        if stretch >= self.bits.len() {
            self.bits.resize(stretch + 1, 0);
        }
        self.bits[stretch] += bits;
    }

    /// Time, s, and load until `until_s`, in steps; `whole_bit_s` is a load of 1.
    pub fn points(&self, until_s: f64, whole_bit_s: f64) -> Vec<(f64, f64)> {
        let step = |(nth, bits): (usize, &u64)| {
            let from_s = nth as f64 * self.stretch_s;
            let until_s = (from_s + self.stretch_s).min(until_s);
            let load = *bits as f64 / whole_bit_s / (until_s - from_s);
            // A last stretch that hardly began says nothing.
            (until_s - from_s > 0.5 * self.stretch_s).then_some([(from_s, load), (until_s, load)])
        };
        self.bits.iter().enumerate().filter_map(step).flatten().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_load_stays_even_however_long_it_lasts() {
        let mut curve = LoadCurve::new(0.1);
        (0..100_000).for_each(|nth| curve.take(f64::from(nth) * 0.01, 50));
        let points = curve.points(1000.0, 10_000.0);
        assert!(points.len() <= 2 * MOST_STRETCHES, "{} points", points.len());
        assert!(points.iter().all(|(_, load)| (load - 0.5).abs() < 0.02), "{points:?}");
    }

    #[test]
    fn a_last_stretch_that_hardly_began_is_left_out() {
        let mut curve = LoadCurve::new(1.0);
        [0.5, 1.2].into_iter().for_each(|at_s| curve.take(at_s, 100));
        assert_eq!(curve.points(1.3, 100.0), [(0.0, 1.0), (1.0, 1.0)]);
    }
}
