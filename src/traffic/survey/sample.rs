//! A part of many numbers, small and of a fixed size, from which quantiles of
//! all can be told: all of them while they are few, then each with the same
//! probability (Vitter's algorithm R, 1985).

/// Numbers that are kept.
const KEPT: usize = 2048;

/// The sample. The same numbers in the same order give the same one.
#[derive(Default)]
pub(super) struct Sample {
    kept: Vec<i64>,
    seen: u64,
    chance: u64,
}

impl Sample {
    /// Takes another number.
    pub fn add(&mut self, number: i64) {
        self.seen += 1;
        if self.kept.len() < KEPT {
            self.kept.push(number);
            return;
        }
        // Knuth's linear congruential generator; its upper bits are the good ones.
        self.chance = self.chance.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let place = (u128::from(self.chance) * u128::from(self.seen)) >> 64;
        if let Some(kept) = self.kept.get_mut(place as usize) {
            *kept = number;
        }
    }

    /// The numbers kept, in order.
    pub fn sorted(&self) -> Vec<i64> {
        let mut sorted = self.kept.clone();
        sorted.sort_unstable();
        sorted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_numbers_are_all_kept_and_many_are_kept_evenly() {
        let mut sample = Sample::default();
        (0..1_000).rev().for_each(|number| sample.add(number));
        assert_eq!(sample.sorted(), (0..1_000).collect::<Vec<_>>());
        (1_000..1_000_000).for_each(|number| sample.add(number));
        let sorted = sample.sorted();
        assert_eq!(sorted.len(), KEPT);
        assert!((450_000..550_000).contains(&sorted[KEPT / 2]), "{}", sorted[KEPT / 2]);
    }
}
