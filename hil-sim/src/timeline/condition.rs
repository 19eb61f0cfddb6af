//! `when` of an event: a signal and a bound on it.

use canloop::wheels::Wheels;

use crate::plant::State;

/// Such as `x_m < 2.5`. Only what the robot really does can be asked about:
/// the far side of a bus knows nothing else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// Its place in [`SIGNALS`].
    signal: usize,
    is_above: bool,
    bound: f64,
}

type Signal = fn(&State) -> f64;

/// What can be asked about.
pub const SIGNALS: [(&str, Signal); 9] = [
    ("x_m", |state| state.pose.x_m),
    ("y_m", |state| state.pose.y_m),
    ("heading_rad", |state| state.pose.heading_rad),
    ("true_angle_right_rad", |state| state.angle_rad.right),
    ("true_angle_left_rad", |state| state.angle_rad.left),
    ("true_speed_right_rad_s", |state| state.speed_rad_s.right),
    ("true_speed_left_rad_s", |state| state.speed_rad_s.left),
    ("fastest_wheel_rad_s", |state| {
        let Wheels { right, left } = state.speed_rad_s.map(f64::abs);
        right.max(left)
    }),
    ("slowest_wheel_rad_s", |state| {
        let Wheels { right, left } = state.speed_rad_s.map(f64::abs);
        right.min(left)
    }),
];

impl Condition {
    /// Reads `SIGNAL < NUMBER` or `SIGNAL > NUMBER`. The error says what was
    /// found and what was expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let expected = "expected a signal, `<` or `>`, and a number, such as `x_m < 2.5`";
        let (at, is_above) = match (text.find('<'), text.find('>')) {
            (Some(at), None) => (at, false),
            (None, Some(at)) => (at, true),
            _ => return Err(format!("found {text:?}, {expected}")),
        };
        let (name, bound) = (text[..at].trim(), text[at + 1..].trim());
        let signal = SIGNALS.iter().position(|(known, _)| *known == name);
        let names = || SIGNALS.map(|(known, _)| known).join(", ");
        let signal = signal.ok_or_else(|| format!("found the signal {name:?}, expected one of {}", names()))?;
        let bound: f64 = bound.parse().map_err(|_| format!("found {bound:?} for a number, {expected}"))?;
        if bound.is_finite() { Ok(Self { signal, is_above, bound }) } else { Err(format!("found {bound}, {expected}")) }
    }

    /// Whether it holds of a robot in this state.
    pub fn holds(&self, state: &State) -> bool {
        let (_, signal) = SIGNALS[self.signal];
        let value = signal(state);
        if self.is_above { value > self.bound } else { value < self.bound }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canloop::robot::Pose;

    #[test]
    fn a_signal_is_compared_with_a_number() {
        let state = State { pose: Pose { x_m: 2.0, ..Pose::default() }, ..State::default() };
        for (text, holds) in [("x_m < 2.5", true), ("x_m>2.5", false), (" x_m  >  1e0 ", true), ("x_m < 2", false)] {
            assert_eq!(Condition::parse(text).map(|condition| condition.holds(&state)), Ok(holds), "{text}");
        }
    }

    #[test]
    fn what_is_no_comparison_is_refused_with_what_was_expected() {
        for (text, says) in [
            ("x_m", "expected a signal"),
            ("x_m < 1 > 2", "expected a signal"),
            ("speed < 1", "\"speed\", expected one of x_m"),
            ("x_m < far", "\"far\" for a number"),
            ("x_m < inf", "found inf"),
        ] {
            let error = Condition::parse(text).expect_err(text);
            assert!(error.contains(says), "{text}: {error}");
        }
    }
}
