//! Chance that can be had again: the same seed and channel, the same numbers,
//! on every machine and in every version.

/// A row of random numbers: PCG-XSH-RR 64/32 of M. E. O'Neill, "PCG: A Family
/// of Simple Fast Space-Efficient Statistically Good Algorithms for Random
/// Number Generation", 2014.
#[derive(Clone, Debug)]
pub struct Chance {
    state: u64,
    increment: u64,
}

const MULTIPLIER: u64 = 6_364_136_223_846_793_005;

impl Chance {
    /// The row of a channel. Rows of different channels have nothing to do
    /// with each other.
    pub const fn new(seed: u64, channel: u64) -> Self {
        let increment = channel << 1 | 1;
        let state = increment.wrapping_add(seed).wrapping_mul(MULTIPLIER).wrapping_add(increment);
        Self { state, increment }
    }

    /// The next 32 bits.
    pub const fn bits(&mut self) -> u32 {
        let old = self.state;
        self.state = old.wrapping_mul(MULTIPLIER).wrapping_add(self.increment);
        ((((old >> 18) ^ old) >> 27) as u32).rotate_right((old >> 59) as u32)
    }

    /// One of `0..end`, all alike but for one part in 2^32 / `end`.
    pub const fn below(&mut self, end: u32) -> u32 {
        ((self.bits() as u64 * end as u64) >> 32) as u32
    }

    /// Whether something happens that does with this probability. What is
    /// certain, or never happens, takes no number from the row.
    pub fn happens(&mut self, probability: f64) -> bool {
        if probability >= 1.0 {
            return true;
        }
        probability > 0.0 && f64::from(self.bits()) < probability * 4_294_967_296.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_are_those_of_the_author_s_demonstration() {
        // pcg32-demo of pcg-c-basic: seed 42, stream 54.
        let mut chance = Chance::new(42, 54);
        let expected = [0xA15C_02B7, 0x7B47_F409, 0xBA1D_3330, 0x83D2_F293, 0xBFA4_784B, 0xCBED_606E];
        assert_eq!(expected.map(|_| chance.bits()), expected);
    }

    #[test]
    fn a_probability_is_kept_in_the_long_run() {
        let mut chance = Chance::new(1, 0);
        let count = (0..100_000).filter(|_| chance.happens(0.25)).count();
        assert!((24_500..25_500).contains(&count), "{count}");
        assert!(!chance.happens(0.0) && !chance.happens(f64::NAN) && chance.happens(1.0));
    }

    #[test]
    fn channels_have_rows_of_their_own() {
        let row = |channel| {
            let mut chance = Chance::new(7, channel);
            [0; 4].map(|_| chance.below(1000))
        };
        assert_eq!(row(1), row(1));
        assert_ne!(row(1), row(2));
    }
}
