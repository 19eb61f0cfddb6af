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
    /// The position of a motor whose wheel has turned by `angle_rad`, in whole
    /// counts.
    pub fn counts(&self, angle_rad: f64) -> i64 {
        let turns = angle_rad * self.gear_ratio / (2.0 * std::f64::consts::PI);
        (turns * f64::from(self.counts_per_turn)).floor() as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_whole_counts() {
        let encoder = Encoder { counts_per_turn: 1000, gear_ratio: 2.0 };
        let turn = 2.0 * std::f64::consts::PI;
        assert_eq!(encoder.counts(0.5 * turn + 1e-9), 1000);
        assert_eq!(encoder.counts(-1e-9), -1);
    }
}
