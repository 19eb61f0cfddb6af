//! What the safety chain lets pass, from `[safety]`.

use crate::config::{Bound, Section};
use crate::time::Duration;

/// Limits that the safety chain keeps; see `[safety]`. What is infinite is not
/// watched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Torque at a wheel, N m.
    pub torque_limit_nm: f64,
    /// Change of torque at a wheel, N m/s.
    pub torque_rate_nm_per_s: f64,
    /// Periods without feedback after which the stack trips.
    pub feedback_timeout_periods: u32,
    /// Time without a sign of life from a drive, s.
    pub heartbeat_timeout_s: f64,
    /// The so many-th damaged frame within the window trips.
    pub damaged_frames: u32,
    /// That window, s.
    pub damaged_frames_window_s: f64,
    /// How much further than at its last speed a wheel may turn in a period, rad.
    pub encoder_jump_rad: f64,
    /// Wheel angle error, rad.
    pub following_error_rad: f64,
    /// Wheel speed, either way, rad/s.
    pub wheel_speed_limit_rad_s: f64,
    /// For how long the law may ask for more torque than the limit, s.
    pub saturation_timeout_s: f64,
    /// Periods by which the loop may wake up late.
    pub overrun_periods: u32,
    /// How long the drives may take to enable, s.
    pub enable_timeout_s: f64,
    /// How hard a stop brakes the faster wheel, rad/s^2.
    pub stop_deceleration_rad_s2: f64,
    /// How long a stop may take to bring the wheels to rest, s.
    pub stop_timeout_s: f64,
    /// Wheel speed at which a wheel counts as at rest, rad/s.
    pub rest_speed_rad_s: f64,
}

/// What of a robot its limits are made from where they are not given.
#[derive(Clone, Copy, Debug)]
pub struct Grounds<'p> {
    /// The drives' profile, for messages.
    pub profile_name: &'p str,
    /// The drives' torque limit at a wheel, N m.
    pub torque_limit_nm: f64,
    /// How often drives give a sign of life, if they do.
    pub heartbeat_period: Option<Duration>,
    /// Angle of a wheel that the drives' reports cannot tell from another, rad.
    pub position_step_rad: f64,
    /// The most that the torque limit can accelerate a wheel, rad/s^2.
    pub acceleration_rad_s2: f64,
    /// T, s.
    pub period_s: f64,
}

/// Signs of life that may stay out.
const HEARTBEATS: f64 = 3.0;
/// The least encoder jump that is one: no wheel on a floor does that in a
/// millisecond or ten.
const JUMP_RAD: f64 = 0.1;
/// Steps of the position that are no jump, and how much lighter than believed
/// a robot may be.
const MARGIN: f64 = 4.0;

impl Limits {
    /// Reads a `[safety]` section. The torque limit is the drive's unless a
    /// lower one is given. What is wrong is reported to the section's reader.
    pub fn read(section: &Section<'_>, grounds: &Grounds<'_>) -> Self {
        let number = |key: &str, default: f64| section.number_or(key, default, Bound::Positive);
        let periods = |key: &str, default: i64| section.integer_or(key, default, 1, 1000) as u32;
        Self {
            torque_limit_nm: number("torque_limit_nm", grounds.torque_limit_nm).min(grounds.torque_limit_nm),
            torque_rate_nm_per_s: number("torque_rate_nm_per_s", f64::INFINITY),
            feedback_timeout_periods: periods("feedback_timeout_periods", 2),
            heartbeat_timeout_s: read_heartbeat_timeout(section, grounds),
            damaged_frames: section.integer_or("damaged_frames", 3, 1, 100) as u32,
            damaged_frames_window_s: number("damaged_frames_window_s", 1.0),
            encoder_jump_rad: number("encoder_jump_rad", grounds.encoder_jump_rad()),
            following_error_rad: number("following_error_rad", f64::INFINITY),
            wheel_speed_limit_rad_s: number("wheel_speed_limit_rad_s", f64::INFINITY),
            saturation_timeout_s: number("saturation_timeout_s", f64::INFINITY),
            overrun_periods: periods("overrun_periods", 1),
            enable_timeout_s: number("enable_timeout_s", 5.0),
            stop_deceleration_rad_s2: number("stop_deceleration_rad_s2", 5.0),
            stop_timeout_s: number("stop_timeout_s", 5.0),
            rest_speed_rad_s: number("rest_speed_rad_s", 0.05),
        }
    }

    /// Keys of what a robot can do that is not watched.
    pub fn unwatched(&self) -> impl Iterator<Item = &'static str> {
        let watches = [
            ("following_error_rad", self.following_error_rad),
            ("wheel_speed_limit_rad_s", self.wheel_speed_limit_rad_s),
            ("saturation_timeout_s", self.saturation_timeout_s),
        ];
        watches.into_iter().filter(|(_, limit)| limit.is_infinite()).map(|(key, _)| key)
    }
}

impl Grounds<'_> {
    /// Far beyond what torque can do to a wheel in a period, and beyond what
    /// coarse reports do.
    fn encoder_jump_rad(&self) -> f64 {
        let by_torque_rad = self.acceleration_rad_s2 * self.period_s * self.period_s;
        JUMP_RAD.max(MARGIN * by_torque_rad).max(MARGIN * self.position_step_rad)
    }
}

fn read_heartbeat_timeout(section: &Section<'_>, grounds: &Grounds<'_>) -> f64 {
    const KEY: &str = "heartbeat_timeout_s";
    let Some(period) = grounds.heartbeat_period else {
        if section.has(KEY) {
            let found = format!("found it for drives of the profile `{}`", grounds.profile_name);
            section.complain(KEY, &format!("{found}, which give no sign of life at a fixed rate"));
        }
        section.allow(&[KEY]);
        return f64::INFINITY;
    };
    section.number_or(KEY, HEARTBEATS * period.as_secs_f64(), Bound::Positive)
}

#[cfg(test)]
impl Limits {
    /// As a robot has them that says nothing, at a period of some milliseconds.
    pub(super) fn for_tests() -> Self {
        Self {
            torque_limit_nm: 90.0,
            torque_rate_nm_per_s: f64::INFINITY,
            feedback_timeout_periods: 2,
            heartbeat_timeout_s: 0.3,
            damaged_frames: 3,
            damaged_frames_window_s: 1.0,
            encoder_jump_rad: 0.1,
            following_error_rad: f64::INFINITY,
            wheel_speed_limit_rad_s: f64::INFINITY,
            saturation_timeout_s: f64::INFINITY,
            overrun_periods: 1,
            enable_timeout_s: 5.0,
            stop_deceleration_rad_s2: 5.0,
            stop_timeout_s: 5.0,
            rest_speed_rad_s: 0.05,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{Document, Problems, Reader};

    const GROUNDS: Grounds<'_> = Grounds {
        profile_name: "acme",
        torque_limit_nm: 90.0,
        heartbeat_period: Some(Duration::from_millis(100)),
        position_step_rad: 1e-4,
        acceleration_rad_s2: 150.0,
        period_s: 0.005,
    };

    fn read(text: &str, grounds: &Grounds<'_>) -> Result<Limits, Problems> {
        let document = Document::parse("robot.toml", text)?;
        let reader = Reader::new(&document);
        let limits = Limits::read(&reader.root(), grounds);
        reader.finish(limits)
    }

    #[test]
    fn what_is_not_given_follows_from_the_drives_or_is_not_watched() {
        let limits = read("", &GROUNDS).unwrap();
        assert_eq!((limits.torque_limit_nm, limits.torque_rate_nm_per_s), (90.0, f64::INFINITY));
        assert_eq!((limits.feedback_timeout_periods, limits.overrun_periods, limits.damaged_frames), (2, 1, 3));
        assert!((limits.heartbeat_timeout_s - 0.3).abs() < 1e-12);
        let keys: Vec<_> = limits.unwatched().collect();
        assert_eq!(keys, ["following_error_rad", "wheel_speed_limit_rad_s", "saturation_timeout_s"]);
        let limits = read("following_error_rad = 1\nwheel_speed_limit_rad_s = 1", &GROUNDS).unwrap();
        assert_eq!(limits.unwatched().collect::<Vec<_>>(), ["saturation_timeout_s"]);
    }

    #[test]
    fn the_torque_limit_is_never_above_that_of_the_drives() {
        assert_eq!(read("torque_limit_nm = 60", &GROUNDS).unwrap().torque_limit_nm, 60.0);
        assert_eq!(read("torque_limit_nm = 100", &GROUNDS).unwrap().torque_limit_nm, 90.0);
    }

    #[test]
    fn a_jump_is_more_than_torque_and_coarse_reports_can_do() {
        let jump_rad = |grounds: &Grounds<'_>| read("", grounds).unwrap().encoder_jump_rad;
        assert_eq!(jump_rad(&GROUNDS), 0.1);
        assert!((jump_rad(&Grounds { period_s: 0.1, ..GROUNDS }) - 6.0).abs() < 1e-12);
        assert!((jump_rad(&Grounds { position_step_rad: 0.5, ..GROUNDS }) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn drives_without_a_heartbeat_have_no_limit_for_it() {
        let silent = Grounds { heartbeat_period: None, ..GROUNDS };
        assert_eq!(read("", &silent).unwrap().heartbeat_timeout_s, f64::INFINITY);
        let problems = read("heartbeat_timeout_s = 1", &silent).unwrap_err().to_string();
        assert!(problems.contains("robot.toml:1:") && problems.contains("no sign of life"), "{problems}");
    }
}
