//! Digital acceleration control, eq 12.

use crate::robot::MassMatrix;
use crate::wheels::Wheels;

use super::law::{Law, Measured, Target};

/// Eq 12 as printed:
/// `tau(k) = tau(k-1) + M { theta''* - theta'' + K_D e' + K_P e }`.
///
/// tau(k-1) is its own last command. That is what acts only where a torque acts
/// at once; over a bus it acts a period late, and the loop rings.
pub struct Dac {
    pd: Pd,
    last_command_nm: Wheels<f64>,
}

/// Eq 12 fed with the torque that was applied while the measured acceleration
/// happened, both through the same low-pass: a disturbance observer.
///
/// `f(k) = f(k-1) + alpha { tau_applied - M theta''_measured - f(k-1) }`,
/// `tau = f + M { theta''* + K_D e' + K_P e }`. With alpha 1 and no delay this
/// is eq 12 again.
pub struct DacMatched {
    pd: Pd,
    filter: f64,
    disturbance_nm: Wheels<f64>,
}

/// What both share: M times the acceleration that the error asks for.
struct Pd {
    mass: MassMatrix,
    kd_per_s: f64,
    kp_per_s2: f64,
}

impl Dac {
    /// The law for a robot of inertia `mass`.
    pub fn new(mass: MassMatrix, kd_per_s: f64, kp_per_s2: f64) -> Self {
        Self { pd: Pd { mass, kd_per_s, kp_per_s2 }, last_command_nm: Wheels::default() }
    }
}

impl DacMatched {
    /// The law for a robot of inertia `mass`; `filter` is alpha, `0..=1`.
    pub fn new(mass: MassMatrix, kd_per_s: f64, kp_per_s2: f64, filter: f64) -> Self {
        Self { pd: Pd { mass, kd_per_s, kp_per_s2 }, filter, disturbance_nm: Wheels::default() }
    }
}

impl Law for Dac {
    fn torque_nm(&mut self, target: &Target, measured: &Measured) -> Wheels<f64> {
        let missing = self.pd.acceleration_rad_s2(target, measured) - measured.acceleration_rad_s2;
        self.last_command_nm = self.last_command_nm + self.pd.mass.times(missing);
        self.last_command_nm
    }

    fn reset(&mut self) {
        self.last_command_nm = Wheels::default();
    }
}

impl Law for DacMatched {
    fn torque_nm(&mut self, target: &Target, measured: &Measured) -> Wheels<f64> {
        let unexplained_nm = measured.torque_nm - self.pd.mass.times(measured.acceleration_rad_s2);
        self.disturbance_nm = self.disturbance_nm + (unexplained_nm - self.disturbance_nm) * self.filter;
        self.disturbance_nm + self.pd.mass.times(self.pd.acceleration_rad_s2(target, measured))
    }

    fn reset(&mut self) {
        self.disturbance_nm = Wheels::default();
    }
}

impl Pd {
    fn acceleration_rad_s2(&self, target: &Target, measured: &Measured) -> Wheels<f64> {
        let error_rad = target.angle_rad - measured.angle_rad;
        let error_rad_s = target.speed_rad_s - measured.speed_rad_s;
        target.acceleration_rad_s2 + error_rad_s * self.kd_per_s + error_rad * self.kp_per_s2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MASS: MassMatrix = MassMatrix { m11: 2.0, m12: 0.5, m22: 3.0 };
    const KD_PER_S: f64 = 3.0;
    const KP_PER_S2: f64 = 0.6;

    fn pair(right: f64, left: f64) -> Wheels<f64> {
        Wheels { right, left }
    }

    fn target() -> Target {
        Target { angle_rad: pair(1.5, 2.0), speed_rad_s: pair(0.25, 0.5), acceleration_rad_s2: pair(0.1, -0.2) }
    }

    fn measured() -> Measured {
        Measured {
            angle_rad: pair(1.0, 3.0),
            speed_rad_s: pair(0.5, 0.25),
            acceleration_rad_s2: pair(0.4, 0.3),
            torque_nm: pair(10.0, -20.0),
        }
    }

    /// theta''* + K_D e' + K_P e of these two.
    fn wanted_rad_s2() -> Wheels<f64> {
        pair(0.1 - 3.0 * 0.25 + 0.6 * 0.5, -0.2 + 3.0 * 0.25 - 0.6)
    }

    #[track_caller]
    fn assert_near(found: Wheels<f64>, expected: Wheels<f64>) {
        assert!((found - expected).all(|off| off.abs() < 1e-12), "{found:?} instead of {expected:?}");
    }

    #[test]
    fn eq_12_adds_to_its_last_command_the_inertia_times_what_the_acceleration_misses() {
        let mut law = Dac::new(MASS, KD_PER_S, KP_PER_S2);
        let step_nm = MASS.times(wanted_rad_s2() - measured().acceleration_rad_s2);
        assert_near(law.torque_nm(&target(), &measured()), step_nm);
        assert_near(law.torque_nm(&target(), &measured()), step_nm * 2.0);
        law.reset();
        assert_near(law.torque_nm(&target(), &measured()), step_nm);
    }

    #[test]
    fn the_matched_law_adds_to_the_torque_that_was_applied() {
        let mut law = DacMatched::new(MASS, KD_PER_S, KP_PER_S2, 1.0);
        let unexplained_nm = measured().torque_nm - MASS.times(measured().acceleration_rad_s2);
        let expected_nm = unexplained_nm + MASS.times(wanted_rad_s2());
        assert_near(law.torque_nm(&target(), &measured()), expected_nm);
        assert_near(law.torque_nm(&target(), &measured()), expected_nm);
    }

    #[test]
    fn its_filter_approaches_a_steady_disturbance_by_alpha_a_period() {
        let mut law = DacMatched::new(MASS, KD_PER_S, KP_PER_S2, 0.25);
        let unexplained_nm = measured().torque_nm - MASS.times(measured().acceleration_rad_s2);
        for share in [0.25, 0.4375, 0.578125] {
            let expected_nm = unexplained_nm * share + MASS.times(wanted_rad_s2());
            assert_near(law.torque_nm(&target(), &measured()), expected_nm);
        }
        law.reset();
        assert_near(law.torque_nm(&target(), &measured()), unexplained_nm * 0.25 + MASS.times(wanted_rad_s2()));
    }
}
