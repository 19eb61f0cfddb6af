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
