//! What can be wrong with a drive, beyond the faults that it knows of itself.

use canloop::schema::Feedback;

/// What is wrong with a drive just now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trouble {
    /// Whether it has power. Without, it gives no torque, hears nothing and
    /// says nothing; with power again it boots.
    pub is_powered: bool,
    /// The torque that it can give at most, N m, where that is less than usual.
    pub torque_limit_nm: f64,
    /// What it reports as torque for each N m that it applies.
    pub torque_sensor_gain: f64,
    /// Counts that its encoder is off by.
    pub encoder_offset_counts: i64,
    /// Whether its encoder counts the wrong way.
    pub encoder_is_reversed: bool,
    /// The count at which its encoder is stuck, if it is.
    pub encoder_stuck_at: Option<i64>,
    /// Whether its feedback stays out, though it goes on otherwise.
    pub is_mute: bool,
}

impl Trouble {
    /// A sound drive.
    pub const NONE: Self = Self {
        is_powered: true,
        torque_limit_nm: f64::INFINITY,
        torque_sensor_gain: 1.0,
        encoder_offset_counts: 0,
        encoder_is_reversed: false,
        encoder_stuck_at: None,
        is_mute: false,
    };

    /// What the encoder says where a sound one would say `counts`.
    pub fn counts(&self, counts: i64) -> i64 {
        let turned = if self.encoder_is_reversed { -counts } else { counts };
        self.encoder_stuck_at.unwrap_or(turned + self.encoder_offset_counts)
    }

    /// What the drive reports where a sound one would report this.
    pub fn reported(&self, feedback: Feedback) -> Feedback {
        let turns_seen = if self.encoder_is_reversed { -1.0 } else { 1.0 };
        let turns_seen = if self.encoder_stuck_at.is_some() { 0.0 } else { turns_seen };
        Feedback {
            speed_rad_s: feedback.speed_rad_s.map(|speed| speed * turns_seen),
            torque_applied_nm: feedback.torque_applied_nm.map(|torque| torque * self.torque_sensor_gain),
            ..feedback
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_encoder_is_reversed_off_or_stuck() {
        let counts = |trouble: Trouble| trouble.counts(100);
        assert_eq!(counts(Trouble::NONE), 100);
        assert_eq!(counts(Trouble { encoder_is_reversed: true, ..Trouble::NONE }), -100);
        assert_eq!(counts(Trouble { encoder_offset_counts: 7, ..Trouble::NONE }), 107);
        assert_eq!(counts(Trouble { encoder_stuck_at: Some(3), encoder_offset_counts: 7, ..Trouble::NONE }), 3);
    }

    #[test]
    fn what_is_reported_of_speed_and_torque_goes_with_it() {
        let feedback = Feedback { speed_rad_s: Some(2.0), torque_applied_nm: Some(10.0), ..Feedback::default() };
        assert_eq!(Trouble::NONE.reported(feedback), feedback);
        let wrong = Trouble { encoder_is_reversed: true, torque_sensor_gain: 1.2, ..Trouble::NONE }.reported(feedback);
        assert_eq!((wrong.speed_rad_s, wrong.torque_applied_nm), (Some(-2.0), Some(12.0)));
        let stuck = Trouble { encoder_stuck_at: Some(0), ..Trouble::NONE }.reported(feedback);
        assert_eq!(stuck.speed_rad_s, Some(0.0));
    }
}
