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
    use crate::robot::{Load, Model, Pose, Robot};

    pub const PERIOD_S: f64 = 0.005;

    /// The paper's robot with its load.
    pub fn robot() -> Robot {
        Robot {
            model: Model::Paper,
            mass_kg: 46.5,
            inertia_kg_m2: 1.3133,
            half_track_m: 0.27,
            wheel_radius_m: 0.122,
            wheel_inertia_kg_m2: 0.0144,
            motor_inertia_kg_m2: 0.0125,
            gear_ratio: 3.0,
            load: Load { mass_kg: 80.0, cog_distance_m: 0.2, cog_angle_rad: 2.0 * std::f64::consts::FRAC_PI_3 },
        }
    }

    /// Eq 19: round (5, 5) at 4 m, in 150 s.
    pub fn circle() -> Path {
        let start = Pose { x_m: 9.0, y_m: 5.0, heading_rad: std::f64::consts::FRAC_PI_2 };
        let length_m = 8.0 * std::f64::consts::PI;
        let geometry = Geometry::new(start, &[(length_m, Shape::Arc { curvature_per_m: 0.25 })]);
        Path::new(geometry, SpeedProfile::even(length_m, 150.0))
    }
}
