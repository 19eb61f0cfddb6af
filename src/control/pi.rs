//! The PI control that the paper compares with, eq 20, in two readings.

use crate::wheels::Wheels;

use super::law::{Law, Measured, Target};

/// `tau = kp (w* - w) + ki int(w* - w)`: what the paper's figures show.
pub struct PiSpeed(Pi);

/// `tau = kp (theta* - theta) + ki int(theta* - theta)`: eq 20 as printed. On
/// wheels that are free to turn, `m s^3 + kp s + ki` has no damping term, so it
/// diverges whatever the gains.
pub struct PiAngle(Pi);

struct Pi {
    kp: f64,
    ki: f64,
    period_s: f64,
    integral: Wheels<f64>,
}

impl PiSpeed {
    /// `kp` in N m s/rad, `ki` in N m/rad.
    pub fn new(kp: f64, ki: f64, period_s: f64) -> Self {
        Self(Pi::new(kp, ki, period_s))
    }
}

impl PiAngle {
    /// `kp` in N m/rad, `ki` in N m/(rad s).
    pub fn new(kp: f64, ki: f64, period_s: f64) -> Self {
        Self(Pi::new(kp, ki, period_s))
    }
}

impl Law for PiSpeed {
    fn torque_nm(&mut self, target: &Target, measured: &Measured) -> Wheels<f64> {
        self.0.torque_nm(target.speed_rad_s - measured.speed_rad_s)
    }

    fn reset(&mut self) {
        self.0.integral = Wheels::default();
    }
}

impl Law for PiAngle {
    fn torque_nm(&mut self, target: &Target, measured: &Measured) -> Wheels<f64> {
        self.0.torque_nm(target.angle_rad - measured.angle_rad)
    }

    fn reset(&mut self) {
        self.0.integral = Wheels::default();
    }
}

impl Pi {
    fn new(kp: f64, ki: f64, period_s: f64) -> Self {
        Self { kp, ki, period_s, integral: Wheels::default() }
    }

    fn torque_nm(&mut self, error: Wheels<f64>) -> Wheels<f64> {
        self.integral = self.integral + error * self.period_s;
        error * self.kp + self.integral * self.ki
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOTH: Wheels<f64> = Wheels { right: 2.0, left: -4.0 };

    /// Errors of 2 and -4 in what `of` picks; errors of 100 in the rest.
    fn off_by(of: fn(&mut Target) -> &mut Wheels<f64>) -> Target {
        let far = Wheels::both(100.0);
        let mut target = Target { angle_rad: far, speed_rad_s: far, acceleration_rad_s2: far };
        *of(&mut target) = BOTH;
        target
    }

    fn torques_nm(law: &mut impl Law, target: &Target) -> [Wheels<f64>; 2] {
        [law.torque_nm(target, &Measured::default()), law.torque_nm(target, &Measured::default())]
    }

    /// kp e + ki int e, with kp 3, ki 5 and T 0.1 s.
    fn expected_nm() -> [Wheels<f64>; 2] {
        [BOTH * 3.5, BOTH * 4.0]
    }

    #[test]
    fn on_speed_it_acts_on_the_error_of_speed_and_its_integral() {
        let (mut law, target) = (PiSpeed::new(3.0, 5.0, 0.1), off_by(|target| &mut target.speed_rad_s));
        assert_eq!(torques_nm(&mut law, &target), expected_nm());
        law.reset();
        assert_eq!(torques_nm(&mut law, &target), expected_nm());
        let measured = Measured { speed_rad_s: BOTH, ..Measured::default() };
        law.reset();
        assert_eq!(law.torque_nm(&target, &measured), Wheels::default());
    }

    #[test]
    fn on_angle_it_acts_on_the_error_of_angle_and_its_integral() {
        let (mut law, target) = (PiAngle::new(3.0, 5.0, 0.1), off_by(|target| &mut target.angle_rad));
        assert_eq!(torques_nm(&mut law, &target), expected_nm());
        law.reset();
        assert_eq!(torques_nm(&mut law, &target), expected_nm());
        let measured = Measured { angle_rad: BOTH, ..Measured::default() };
        law.reset();
        assert_eq!(law.torque_nm(&target, &measured), Wheels::default());
    }
}
