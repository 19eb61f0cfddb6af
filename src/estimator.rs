//! How a wheel turns, from what its drive reports: a position, a speed, or
//! both, as coarse as the drive has them.
//!
//! With h(k) the time between two samples, the wheel has moved by
//!
//! ```text
//! d(k) = p(k) - p(k-1)                    from positions, unwrapped
//! d(k) = h(k) { s(k) + s(k-1) } / 2       from speeds
//! ```
//!
//! and from there on all is the same:
//!
//! ```text
//! speed          v(k) = d(k) / h(k)
//! acceleration   a(k) = 2 { v(k) - v(k-1) } / { h(k) + h(k-1) }
//! torque         { tau(k) + tau(k-1) } / 2
//! ```
//!
//! The acceleration is the mean over the last two spans, and so is the torque
//! that goes with it: a matched pair. Of position and speed the one is taken
//! whose step makes the smaller step of v. Where that is the speed, the angle
//! is its integral, kept within half a step of the position, so that it does
//! not drift.

use crate::schema::PositionScale;

/// Follows one wheel.
#[derive(Clone, Copy, Debug)]
pub struct Estimator {
    scale: PositionScale,
    /// Whether it moves by speeds.
    by_speed: bool,
    last: Option<Last>,
}

/// What a drive reported of one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Position in the unit of its signal.
    pub position: Option<f64>,
    /// Speed of the wheel, rad/s.
    pub speed_rad_s: Option<f64>,
    /// Torque at the wheel in the span that ended then, N m.
    pub torque_nm: f64,
}

/// How the wheel turned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Since the sample before, rad.
    pub moved_rad: f64,
    /// Since the first sample, rad.
    pub angle_rad: f64,
    /// rad/s.
    pub speed_rad_s: f64,
    /// rad/s^2.
    pub acceleration_rad_s2: f64,
    /// Torque that acted while that acceleration happened, N m.
    pub torque_nm: f64,
}

#[derive(Clone, Copy, Debug)]
struct Last {
    position: f64,
    /// Units of position since the first sample; never wraps.
    travelled: f64,
    /// As reported, rad/s.
    reported_rad_s: f64,
    /// As estimated, rad/s.
    speed_rad_s: f64,
    /// The integral of the speed, rad.
    integral_rad: f64,
    span_s: f64,
    torque_nm: f64,
}

impl Estimator {
    /// For a drive that reports its position on `scale` and its speed in steps
    /// of so many rad/s, or one of them, every `period_s`.
    pub fn new(scale: Option<PositionScale>, speed_step_rad_s: Option<f64>, period_s: f64) -> Self {
        let position_step_rad_s = scale.map(|scale| scale.resolution * scale.rad_per_unit / period_s);
        let by_speed = match (position_step_rad_s, speed_step_rad_s) {
            (Some(of_position), Some(of_speed)) => of_speed < of_position,
            (None, _) => true,
            (Some(_), None) => false,
        };
        Self { scale: scale.unwrap_or_default(), by_speed, last: None }
    }

    /// Takes a sample, `span_s` after the one before.
    #[inline]
    pub fn update(&mut self, sample: Sample, span_s: f64) -> Motion {
        let Sample { torque_nm, .. } = sample;
        let position = sample.position.unwrap_or_default();
        let reported_rad_s = sample.speed_rad_s.unwrap_or_default();
        let last = self.last.unwrap_or(Last {
            position,
            travelled: 0.0,
            reported_rad_s,
            speed_rad_s: 0.0,
            integral_rad: 0.0,
            span_s,
            torque_nm,
        });
        let moved = self.unwrapped(position - last.position);
        let travelled = last.travelled + moved;
        let (mut moved_rad, mut angle_rad) = (moved * self.scale.rad_per_unit, travelled * self.scale.rad_per_unit);
        if self.by_speed {
            moved_rad = if self.last.is_some() { 0.5 * span_s * (reported_rad_s + last.reported_rad_s) } else { 0.0 };
            angle_rad = self.within_a_step(last.integral_rad + moved_rad, angle_rad, sample.position.is_some());
        }
        let speed_rad_s = moved_rad * (1.0 / span_s);
        self.last =
            Some(Last { position, travelled, reported_rad_s, speed_rad_s, integral_rad: angle_rad, span_s, torque_nm });
        Motion {
            moved_rad,
            angle_rad,
            speed_rad_s,
            acceleration_rad_s2: (speed_rad_s - last.speed_rad_s) * (2.0 / (span_s + last.span_s)),
            torque_nm: (torque_nm + last.torque_nm) * 0.5,
        }
    }

    /// A difference of positions without the jump where they begin anew.
    #[inline]
    fn unwrapped(&self, difference: f64) -> f64 {
        match self.scale.wraps_at {
            Some(turn) if difference >= 0.5 * turn => difference - turn,
            Some(turn) if difference < -0.5 * turn => difference + turn,
            _ => difference,
        }
    }

    /// The integral of the speed, no further from the position than that is
    /// coarse.
    fn within_a_step(&self, integral_rad: f64, position_rad: f64, has_position: bool) -> f64 {
        if !has_position {
            return integral_rad;
        }
        let half_rad = 0.5 * self.scale.resolution * self.scale.rad_per_unit;
        integral_rad.clamp(position_rad - half_rad, position_rad + half_rad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.005;

    /// 1000 units a turn in a field of 16 bits.
    fn scale() -> PositionScale {
        PositionScale { rad_per_unit: 2.0 * std::f64::consts::PI / 1000.0, wraps_at: Some(65536.0), resolution: 1.0 }
    }

    fn at(position: f64, torque_nm: f64) -> Sample {
        Sample { position: Some(position), torque_nm, ..Sample::default() }
    }

    #[test]
    fn positions_that_wrap_go_on_in_both_directions() {
        for step in [900.0, -900.0] {
            let mut estimator = Estimator::new(Some(scale()), None, PERIOD_S);
            let mut motion = Motion::default();
            for k in 0..200 {
                let position = (f64::from(k) * step).rem_euclid(65536.0);
                motion = estimator.update(at(position, 0.0), PERIOD_S);
            }
            assert!((motion.angle_rad - 199.0 * step * scale().rad_per_unit).abs() < 1e-9, "{motion:?}");
        }
    }

    #[test]
    fn acceleration_and_torque_are_means_over_the_same_two_spans() {
        let mut estimator = Estimator::new(Some(scale()), None, 0.01);
        for (position, torque_nm) in [(0.0, 0.0), (10.0, 4.0)] {
            estimator.update(at(position, torque_nm), 0.01);
        }
        let motion = estimator.update(at(40.0, 6.0), 0.01);
        assert!((motion.acceleration_rad_s2 - 20.0 * scale().rad_per_unit / 1e-4).abs() < 1e-9);
        assert_eq!(motion.torque_nm, 5.0);
    }

    #[test]
    fn a_speed_alone_is_integrated() {
        let mut estimator = Estimator::new(None, Some(0.1), PERIOD_S);
        let mut motion = Motion::default();
        for k in 0..101 {
            let speed_rad_s = Some(f64::from(k) * 0.01);
            motion = estimator.update(Sample { speed_rad_s, ..Sample::default() }, PERIOD_S);
        }
        assert!((motion.angle_rad - 0.25).abs() < 1e-12);
        assert!((motion.acceleration_rad_s2 - 2.0).abs() < 1e-9);
    }

    #[test]
    fn a_coarse_position_keeps_a_fine_speed_from_drifting() {
        let coarse = PositionScale { resolution: 10.0, ..scale() };
        let mut estimator = Estimator::new(Some(coarse), Some(1e-3), PERIOD_S);
        let mut motion = Motion::default();
        for k in 0..2000 {
            // It turns by a unit in a period, and the speed is reported 2 % too low.
            let position = Some((f64::from(k) / 10.0).floor() * 10.0);
            let speed_rad_s = Some(0.98 * scale().rad_per_unit / PERIOD_S);
            motion = estimator.update(Sample { position, speed_rad_s, torque_nm: 0.0 }, PERIOD_S);
        }
        assert!((motion.angle_rad / scale().rad_per_unit - 1999.0).abs() <= 10.0, "{motion:?}");
        assert!((motion.speed_rad_s * PERIOD_S / scale().rad_per_unit - 0.98).abs() < 1e-9);
    }
}
