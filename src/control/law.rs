//! What every control law takes and gives, and which laws there are.

use crate::config::{Bound, Section};
use crate::robot::{MassMatrix, Robot};
use crate::wheels::Wheels;

use super::dac::{Dac, DacMatched};
use super::pi::{PiAngle, PiSpeed};

/// A control law, from how the wheels turn and should turn to torque.
///
/// Called once a period; the period is fixed when the law is made.
pub trait Law {
    /// Torque at the wheels for the period to come, N m.
    fn torque_nm(&mut self, target: &Target, measured: &Measured) -> Wheels<f64>;

    /// Forgets the past, as when motion begins anew.
    fn reset(&mut self);
}

/// How the wheels should turn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Target {
    /// rad since motion began.
    pub angle_rad: Wheels<f64>,
    /// rad/s, taken the way `Measured::speed_rad_s` is.
    pub speed_rad_s: Wheels<f64>,
    /// rad/s^2, for the period in which the torque will act.
    pub acceleration_rad_s2: Wheels<f64>,
}

/// How they turn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// rad since motion began.
    pub angle_rad: Wheels<f64>,
    /// rad/s.
    pub speed_rad_s: Wheels<f64>,
    /// rad/s^2.
    pub acceleration_rad_s2: Wheels<f64>,
    /// Torque that acted while that acceleration happened, N m.
    pub torque_nm: Wheels<f64>,
}

/// A law and its gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LawConfig {
    /// Eq 12 as printed: fed with its own last command.
    Dac {
        /// K_D, 1/s.
        kd_per_s: f64,
        /// K_P, 1/s^2.
        kp_per_s2: f64,
    },
    /// Eq 12 fed with the torque that was applied, through a low-pass.
    DacMatched {
        /// K_D, 1/s.
        kd_per_s: f64,
        /// K_P, 1/s^2.
        kp_per_s2: f64,
        /// alpha, `0..=1`; 1 filters nothing.
        filter: f64,
    },
    /// Eq 20 acting on wheel speed, as the paper's figures need it.
    PiSpeed {
        /// N m s/rad.
        kp: f64,
        /// N m/rad.
        ki: f64,
    },
    /// Eq 20 as printed, acting on wheel angle; unstable.
    PiAngle {
        /// N m/rad.
        kp: f64,
        /// N m/(rad s).
        ki: f64,
    },
}

#[derive(Clone, Copy)]
enum Kind {
    Dac,
    DacMatched,
    PiSpeed,
    PiAngle,
}

impl LawConfig {
    /// Reads the law's keys of a `[controller]` section.
    pub fn read(section: &Section<'_>, period_s: f64) -> Self {
        let laws = [
            ("dac", Kind::Dac),
            ("dac-matched", Kind::DacMatched),
            ("pi-speed", Kind::PiSpeed),
            ("pi-angle", Kind::PiAngle),
        ];
        let kind = section.choice("law", &laws, true);
        section.allow(&["kd_per_s", "kp_per_s2", "filter", "kp", "ki"]);
        match kind {
            Kind::Dac => {
                let (kd_per_s, kp_per_s2) = read_dac_gains(section, period_s);
                Self::Dac { kd_per_s, kp_per_s2 }
            }
            Kind::DacMatched => {
                let (kd_per_s, kp_per_s2) = read_dac_gains(section, period_s);
                let filter = section.number_or("filter", 1.0, Bound::Within(1e-6, 1.0));
                Self::DacMatched { kd_per_s, kp_per_s2, filter }
            }
            Kind::PiSpeed | Kind::PiAngle => {
                let kp = section.number("kp", Bound::Within(0.0, 1e6));
                let ki = section.number("ki", Bound::Within(0.0, 1e6));
                if matches!(kind, Kind::PiSpeed) { Self::PiSpeed { kp, ki } } else { Self::PiAngle { kp, ki } }
            }
        }
    }

    /// Builds the law for a robot that is believed to be `robot`.
    pub fn build(&self, robot: &Robot, period_s: f64) -> Box<dyn Law + Send> {
        let mass: MassMatrix = robot.mass_matrix();
        match *self {
            Self::Dac { kd_per_s, kp_per_s2 } => Box::new(Dac::new(mass, kd_per_s, kp_per_s2)),
            Self::DacMatched { kd_per_s, kp_per_s2, filter } => {
                Box::new(DacMatched::new(mass, kd_per_s, kp_per_s2, filter))
            }
            Self::PiSpeed { kp, ki } => Box::new(PiSpeed::new(kp, ki, period_s)),
            Self::PiAngle { kp, ki } => Box::new(PiAngle::new(kp, ki, period_s)),
        }
    }

    /// Its name in a configuration.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Dac { .. } => "dac",
            Self::DacMatched { .. } => "dac-matched",
            Self::PiSpeed { .. } => "pi-speed",
            Self::PiAngle { .. } => "pi-angle",
        }
    }
}

/// What a magnitude of exactly 1 may come out as.
const ROUNDING: f64 = 1e-12;

/// K_D and K_P, refused when the paper's error dynamics with them are unstable.
fn read_dac_gains(section: &Section<'_>, period_s: f64) -> (f64, f64) {
    let kd_per_s = section.number("kd_per_s", Bound::Finite);
    let kp_per_s2 = section.number("kp_per_s2", Bound::Finite);
    let radius = spectral_radius(kd_per_s, kp_per_s2, period_s);
    if radius > 1.0 + ROUNDING {
        let kd_may_be = kd_per_s > 0.0 && kd_per_s * period_s <= 2.0;
        let culprit = if kd_may_be { "kp_per_s2" } else { "kd_per_s" };
        let problem = section
            .problem(
                culprit,
                "these gains are unstable",
                &format!(
                    "found K_D {kd_per_s:?} and K_P {kp_per_s2:?} with T {period_s} s: an eigenvalue of the error matrix A \
                     has magnitude {radius:.6}, expected at most 1"
                ),
            )
            .help("keep K_D below 2/T and K_P between 0 and 2 K_D/T");
        section.report(problem);
    }
    (kd_per_s, kp_per_s2)
}

/// Largest magnitude of an eigenvalue of the matrix A of the paper's error
/// dynamics: e'' = -K_D e'(k) - K_P e(k), held over a period T, takes (e, e')
/// to A (e, e') with
///
/// ```text
/// A = | 1 - K_P T^2/2    T - K_D T^2/2 |
///     |    -K_P T            1 - K_D T |
/// ```
///
/// NaN when an argument is.
fn spectral_radius(kd_per_s: f64, kp_per_s2: f64, period_s: f64) -> f64 {
    let (kd, kp) = (kd_per_s * period_s, kp_per_s2 * period_s * period_s);
    let half_trace = 1.0 - (kd + 0.5 * kp) / 2.0;
    let determinant = 1.0 - kd + 0.5 * kp;
    let discriminant = half_trace * half_trace - determinant;
    if discriminant < 0.0 { determinant.sqrt() } else { half_trace.abs() + discriminant.sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{Document, Reader};
    use crate::control::tests::robot;

    #[test]
    fn the_paper_s_gains_are_stable_and_the_limits_are_where_jury_s_test_puts_them() {
        let period_s = 0.005;
        assert!(spectral_radius(3.0, 0.6, period_s) < 1.0);
        assert!(spectral_radius(1.99 / period_s, 0.6, period_s) < 1.0);
        assert!(spectral_radius(2.01 / period_s, 0.6, period_s) > 1.0);
        assert!(spectral_radius(3.0, 1.99 * 3.0 / period_s, period_s) < 1.0);
        assert!(spectral_radius(3.0, 2.01 * 3.0 / period_s, period_s) > 1.0);
        assert!(spectral_radius(3.0, -0.1, period_s) > 1.0);
        assert!(spectral_radius(-0.1, 0.6, period_s) > 1.0);
    }

    fn read(text: &str) -> Result<LawConfig, String> {
        let document = Document::parse("robot.toml", text).expect("TOML");
        let reader = Reader::new(&document);
        let law = LawConfig::read(&reader.root(), 0.005);
        reader.finish(law).map_err(|problems| problems.to_string())
    }

    #[test]
    fn every_law_is_read_with_its_own_gains() {
        let (kd_per_s, kp_per_s2) = (3.0, 0.6);
        let laws = [
            ("kd_per_s = 3\nkp_per_s2 = 0.6", LawConfig::Dac { kd_per_s, kp_per_s2 }),
            ("kd_per_s = 3\nkp_per_s2 = 0.6\nfilter = 0.3", LawConfig::DacMatched { kd_per_s, kp_per_s2, filter: 0.3 }),
            ("kd_per_s = 3\nkp_per_s2 = 0.6", LawConfig::DacMatched { kd_per_s, kp_per_s2, filter: 1.0 }),
            ("kp = 1\nki = 3", LawConfig::PiSpeed { kp: 1.0, ki: 3.0 }),
            ("kp = 1\nki = 3", LawConfig::PiAngle { kp: 1.0, ki: 3.0 }),
        ];
        for (gains, law) in laws {
            assert_eq!(read(&format!("law = \"{}\"\n{gains}", law.name())), Ok(law));
        }
    }

    #[test]
    fn gains_that_are_unstable_are_refused_at_the_key_that_makes_them_so() {
        let refused = |kd_per_s: f64, kp_per_s2: f64| {
            let text = format!("law = \"dac\"\nkd_per_s = {kd_per_s:?}\nkp_per_s2 = {kp_per_s2:?}");
            read(&text).err().map(|error| if error.contains("robot.toml:2:") { "kd_per_s" } else { "kp_per_s2" })
        };
        // K_D T of 2 is the limit, and K_P of 2 K_D / T.
        assert_eq!([refused(3.0, 0.6), refused(399.0, 0.6), refused(3.0, 1199.0)], [None; 3]);
        // Nothing moves, so nothing diverges.
        assert_eq!(refused(0.0, 0.0), None);
        assert_eq!([refused(401.0, 0.6), refused(-0.1, 0.6), refused(0.0, 0.6)], [Some("kd_per_s"); 3]);
        assert_eq!([refused(3.0, 1201.0), refused(3.0, -0.1), refused(400.0, -1.0)], [Some("kp_per_s2"); 3]);
    }

    #[test]
    fn every_law_is_built_as_what_it_is() {
        let mass = robot().mass_matrix();
        let target = Target { angle_rad: Wheels { right: 1.0, left: 2.0 }, ..Target::default() };
        let measured = Measured { torque_nm: Wheels::both(10.0), ..Measured::default() };
        let torque_nm = |law: LawConfig| law.build(&robot(), 0.5).torque_nm(&target, &measured);
        let wanted_nm = mass.times(target.angle_rad * 0.6);
        let (kd_per_s, kp_per_s2) = (3.0, 0.6);
        assert_eq!(torque_nm(LawConfig::Dac { kd_per_s, kp_per_s2 }), wanted_nm);
        let matched = LawConfig::DacMatched { kd_per_s, kp_per_s2, filter: 0.5 };
        assert_eq!(torque_nm(matched), Wheels::both(5.0) + wanted_nm);
        assert_eq!(torque_nm(LawConfig::PiSpeed { kp: 1.0, ki: 3.0 }), Wheels::default());
        let pi_angle = LawConfig::PiAngle { kp: 1.0, ki: 3.0 };
        assert_eq!(torque_nm(pi_angle), target.angle_rad * 2.5);
    }
}
