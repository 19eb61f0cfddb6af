//! A position sensor that counts.

/// An incremental encoder on the motor shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoder {
    /// Counts a turn of the motor shaft.
    pub counts_per_turn: u32,
    /// Motor turns per wheel turn.
    pub gear_ratio: f64,
}

impl Encoder {
    /// The position of a motor whose wheel has turned by `angle_rad`: whole
    /// counts, wrapped at 32 bits.
    pub fn counts(&self, angle_rad: f64) -> i32 {
        let turns = angle_rad * self.gear_ratio / (2.0 * std::f64::consts::PI);
        (turns * f64::from(self.counts_per_turn)).floor() as i64 as i32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_whole_counts_that_wrap_at_32_bits() {
        let encoder = Encoder { counts_per_turn: 1000, gear_ratio: 2.0 };
        let turn = 2.0 * std::f64::consts::PI;
        assert_eq!(encoder.counts(0.5 * turn + 1e-9), 1000);
        assert_eq!(encoder.counts(-1e-9), -1);
        assert_eq!(encoder.counts((f64::from(i32::MAX) + 1.5) / 2000.0 * turn), i32::MIN);
    }
}
