//! What is odd about stamps.

use crate::time::{Duration, Instant};

/// Seen from record to record.
#[derive(Default)]
pub(super) struct Stamps {
    before: Option<Instant>,
    /// Divides all stamps, ns.
    divisor: u64,
    /// How many are earlier than the one before, and by how much at most.
    pub backwards: u64,
    pub furthest_back: Duration,
    /// How many are the same as the one before.
    pub repeated: u64,
    /// The longest silence on all buses together, and when it began.
    pub longest_gap: Option<(Duration, Instant)>,
}

impl Stamps {
    /// Takes the next stamp into account.
    pub fn add(&mut self, at: Instant) {
        self.divisor = common_divisor(self.divisor, at.as_nanos().unsigned_abs());
        let Some(before) = self.before.replace(at) else { return };
        let step = at - before;
        if step < Duration::ZERO {
            self.backwards += 1;
            self.furthest_back = self.furthest_back.max(Duration::ZERO - step);
        }
        self.repeated += u64::from(step == Duration::ZERO);
        if self.longest_gap.is_none_or(|(longest, _)| step > longest) {
            self.longest_gap = Some((step, before));
        }
    }

    /// The power of ten that all stamps are whole multiples of, at most a
    /// second, ns; `None` where all are 0.
    pub fn resolution_ns(&self) -> Option<u64> {
        let powers = (0..=9).rev().map(|exponent| 10_u64.pow(exponent));
        (self.divisor > 0).then(|| powers.into_iter().find(|power| self.divisor.is_multiple_of(*power))).flatten()
    }
}

/// Euclid's, of numbers of which the first soon stays what it is.
fn common_divisor(mut a: u64, mut b: u64) -> u64 {
    while a != 0 {
        (a, b) = (b % a, a);
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_resolution_is_a_power_of_ten_that_divides_all() {
        let resolution = |stamps: &[i64]| {
            let mut seen = Stamps::default();
            stamps.iter().for_each(|nanos| seen.add(Instant::from_nanos(*nanos)));
            seen.resolution_ns()
        };
        assert_eq!(resolution(&[5_000_000, 10_000_000, 20_000_000]), Some(1_000_000));
        assert_eq!(resolution(&[0, 0]), None);
        assert_eq!(resolution(&[2_000_000_000, 40_000_000_000]), Some(1_000_000_000));
        assert_eq!(resolution(&[1_436_509_052_249_713_000, 1_436_509_052_249_714_000]), Some(1_000));
        assert_eq!(resolution(&[7]), Some(1));
    }
}
