//! The control laws and what leads them along a path.
//!
//! Once a period, [`Guidance`] says how the wheels should turn, and a [`Law`]
//! says with what torque. Both are joined in a [`Controller`], which the stack
//! and the paper's own ideal simulation share.

mod controller;
mod dac;
mod guidance;
mod law;
mod pi;

pub use controller::{Controller, ControllerConfig, Decision};
pub use guidance::{Guidance, Kanayama, PoseLoop, Sampling};
pub use law::{Law, LawConfig, Measured, Target};

#[cfg(test)]
mod tests {
    use crate::path::Path;
    use crate::path::geometry::{Geometry, Shape};
    use crate::path::profile::SpeedProfile;
    use crate::robot::{Pose, Robot};

    pub const PERIOD_S: f64 = 0.005;

    /// The paper's robot with its load.
    pub fn robot() -> Robot {
        Robot::of_the_paper(80.0)
    }

    /// Eq 19: round (5, 5) at 4 m, in 150 s.
    pub fn circle() -> Path {
        let start = Pose { x_m: 9.0, y_m: 5.0, heading_rad: std::f64::consts::FRAC_PI_2 };
        let length_m = 8.0 * std::f64::consts::PI;
        let geometry = Geometry::new(start, &[(length_m, Shape::Arc { curvature_per_m: 0.25 })]);
        Path::new(geometry, SpeedProfile::even(length_m, 150.0))
    }
}
