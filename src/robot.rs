//! The two-wheeled robot: kinematics (eq 1-2) and inertia (eq 5). The plant
//! holds one as the truth, the stack another as its belief.

use crate::config::{Bound, Section};
use crate::wheels::Wheels;

/// Geometry and inertia of the robot and of the load it carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Robot {
    /// Which equations of motion.
    pub model: Model,
    /// Mass of the robot without its load (the paper's M), kg.
    pub mass_kg: f64,
    /// Moment of inertia about the vertical axis through the axle's middle (I), kg m^2.
    pub inertia_kg_m2: f64,
    /// Half the distance between the wheels (b), m.
    pub half_track_m: f64,
    /// Wheel radius (r), m.
    pub wheel_radius_m: f64,
    /// Inertia of a wheel about its axle (J_w), kg m^2.
    pub wheel_inertia_kg_m2: f64,
    /// Inertia of a motor's rotor (J_0), kg m^2.
    pub motor_inertia_kg_m2: f64,
    /// Motor turns per wheel turn (k).
    pub gear_ratio: f64,
    /// What it carries.
    pub load: Load,
}

/// The load, a mass whose centre of gravity lies off the axle's middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Mass of the load (m), kg.
    pub mass_kg: f64,
    /// Distance of the centre of gravity from the axle's middle (d), m.
    pub cog_distance_m: f64,
    /// Its direction (alpha), rad: 0 is to the right, pi/2 straight ahead.
    pub cog_angle_rad: f64,
}

/// The equations of motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Model {
    /// Eq 5 as printed, for reproduction: d^2 (M+m) counts the lateral
    /// offset twice, and velocity terms are left out.
    #[default]
    Paper,
    /// Exact for a rigid body.
    RigidBody,
}

/// How the body moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Forward speed of the axle's middle, m/s.
    pub speed_m_s: f64,
    /// Yaw rate, counter-clockwise positive, rad/s.
    pub yaw_rate_rad_s: f64,
}

/// Where the body is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// East, m.
    pub x_m: f64,
    /// North, m.
    pub y_m: f64,
    /// Heading from the x axis, counter-clockwise positive, rad; not wrapped.
    pub heading_rad: f64,
}

/// The symmetric 2x2 inertia seen at the wheels, kg m^2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassMatrix {
    /// Right wheel's own.
    pub m11: f64,
    /// Coupling.
    pub m12: f64,
    /// Left wheel's own.
    pub m22: f64,
}

/// Where a robot can stand, m. Beyond, a double cannot tell micrometres.
const FIELD_M: Bound = Bound::Within(-1e6, 1e6);

impl Robot {
    /// Reads a `[robot]` section. What it leaves out is taken from `fallback`;
    /// without one everything must be there. The bounds are far beyond any
    /// robot on wheels: what they keep out is a wrong unit or a slip of the key.
    pub fn read(section: &Section<'_>, fallback: Option<&Self>) -> Self {
        let number = |section: &Section<'_>, key: &str, bound: Bound, other: Option<f64>| match other {
            Some(default) => section.number_or(key, default, bound),
            None => section.number(key, bound),
        };
        let own = |key: &str, bound: Bound, field: fn(&Self) -> f64| number(section, key, bound, fallback.map(field));
        let models = match fallback {
            Some(Self { model: Model::RigidBody, .. }) => [("rigid-body", Model::RigidBody), ("paper", Model::Paper)],
            _ => [("paper", Model::Paper), ("rigid-body", Model::RigidBody)],
        };
        let load = section.section("load");
        let of_load = |key: &str, bound: Bound, field: fn(&Load) -> f64| {
            number(&load, key, bound, fallback.map(|robot| field(&robot.load)))
        };
        Self {
            model: section.choice("model", &models, false),
            mass_kg: own("mass_kg", Bound::Within(1e-3, 1e6), |robot| robot.mass_kg),
            inertia_kg_m2: own("inertia_kg_m2", Bound::Within(1e-6, 1e6), |robot| robot.inertia_kg_m2),
            half_track_m: own("half_track_m", Bound::Within(1e-3, 1e3), |robot| robot.half_track_m),
            wheel_radius_m: own("wheel_radius_m", Bound::Within(1e-3, 1e3), |robot| robot.wheel_radius_m),
            wheel_inertia_kg_m2: own("wheel_inertia_kg_m2", Bound::Within(0.0, 1e6), |robot| robot.wheel_inertia_kg_m2),
            motor_inertia_kg_m2: own("motor_inertia_kg_m2", Bound::Within(0.0, 1e6), |robot| robot.motor_inertia_kg_m2),
            gear_ratio: own("gear_ratio", Bound::Within(1e-3, 1e4), |robot| robot.gear_ratio),
            load: Load {
                mass_kg: of_load("mass_kg", Bound::Within(0.0, 1e6), |load| load.mass_kg),
                cog_distance_m: of_load("cog_distance_m", Bound::Within(0.0, 1e3), |load| load.cog_distance_m),
                cog_angle_rad: of_load("cog_angle_rad", Bound::Within(-1e3, 1e3), |load| load.cog_angle_rad),
            },
        }
    }

    /// Body speeds from wheel speeds (rad/s), eq 1-2.
    pub fn twist(&self, wheel_speed_rad_s: Wheels<f64>) -> Twist {
        let Wheels { right, left } = wheel_speed_rad_s;
        Twist {
            speed_m_s: self.wheel_radius_m * (right + left) / 2.0,
            yaw_rate_rad_s: self.wheel_radius_m * (right - left) / (2.0 * self.half_track_m),
        }
    }

    /// Eq 1-2 solved for the wheels. They are linear: a distance (m) and a turn
    /// (rad) give wheel angles (rad), speeds give speeds, accelerations
    /// accelerations.
    pub fn wheels(&self, forward: f64, turn: f64) -> Wheels<f64> {
        let side = self.half_track_m * turn;
        Wheels { right: (forward + side) / self.wheel_radius_m, left: (forward - side) / self.wheel_radius_m }
    }

    /// Mass of robot and load together, kg.
    pub fn total_mass_kg(&self) -> f64 {
        self.mass_kg + self.load.mass_kg
    }

    /// How far the centre of gravity lies to the right of the axle's middle, m.
    pub fn cog_right_m(&self) -> f64 {
        self.load.cog_distance_m * libm::cos(self.load.cog_angle_rad)
    }

    /// How far the centre of gravity lies ahead of the axle, m.
    pub fn cog_ahead_m(&self) -> f64 {
        self.load.cog_distance_m * libm::sin(self.load.cog_angle_rad)
    }

    /// Inertia of what turns with a wheel, brought to its axle: J_w + k^2 J_0, kg m^2.
    pub fn turning_inertia_kg_m2(&self) -> f64 {
        self.wheel_inertia_kg_m2 + self.gear_ratio * self.gear_ratio * self.motor_inertia_kg_m2
    }

    /// Inertia at the wheels, eq 5.
    pub fn mass_matrix(&self) -> MassMatrix {
        let total_kg = self.total_mass_kg();
        let right_arm_m = self.half_track_m + self.cog_right_m();
        let left_arm_m = self.half_track_m - self.cog_right_m();
        let ratio = self.wheel_radius_m / (2.0 * self.half_track_m);
        let c = ratio * ratio;
        let offset_m = match self.model {
            Model::Paper => self.load.cog_distance_m,
            Model::RigidBody => self.cog_ahead_m(),
        };
        let q = c * (self.inertia_kg_m2 + offset_m * offset_m * total_kg);
        let j = self.turning_inertia_kg_m2();
        MassMatrix {
            m11: c * total_kg * right_arm_m * right_arm_m + q + j,
            m12: c * total_kg * right_arm_m * left_arm_m - q,
            m22: c * total_kg * left_arm_m * left_arm_m + q + j,
        }
    }
}

impl MassMatrix {
    /// Torque (N m) that gives this acceleration (rad/s^2).
    pub fn times(&self, acceleration: Wheels<f64>) -> Wheels<f64> {
        Wheels {
            right: self.m11 * acceleration.right + self.m12 * acceleration.left,
            left: self.m12 * acceleration.right + self.m22 * acceleration.left,
        }
    }

    /// Acceleration (rad/s^2) that this torque (N m) gives.
    pub fn solve(&self, torque: Wheels<f64>) -> Wheels<f64> {
        let determinant = self.m11 * self.m22 - self.m12 * self.m12;
        Wheels {
            right: (self.m22 * torque.right - self.m12 * torque.left) / determinant,
            left: (self.m11 * torque.left - self.m12 * torque.right) / determinant,
        }
    }
}

impl Pose {
    /// Distance to another pose in the plane, m.
    pub fn distance_m(&self, other: &Self) -> f64 {
        libm::hypot(self.x_m - other.x_m, self.y_m - other.y_m)
    }

    /// Reads a section of `x_m`, `y_m`, `heading_rad`.
    pub fn read(section: &Section<'_>) -> Self {
        Self {
            x_m: section.number("x_m", FIELD_M),
            y_m: section.number("y_m", FIELD_M),
            heading_rad: section.number("heading_rad", Bound::Within(-1e3, 1e3)),
        }
    }
}

/// `angle` brought into `[-pi, pi]`.
pub fn wrap_angle_rad(angle: f64) -> f64 {
    libm::remainder(angle, 2.0 * std::f64::consts::PI)
}

#[cfg(test)]
impl Robot {
    /// The paper's, with so much load; its lists say 60 kg, its simulations 80.
    pub(crate) fn of_the_paper(load_kg: f64) -> Self {
        Self {
            model: Model::Paper,
            mass_kg: 46.5,
            inertia_kg_m2: 1.3133,
            half_track_m: 0.27,
            wheel_radius_m: 0.122,
            wheel_inertia_kg_m2: 0.0144,
            motor_inertia_kg_m2: 0.0125,
            gear_ratio: 3.0,
            load: Load { mass_kg: load_kg, cog_distance_m: 0.2, cog_angle_rad: 2.0 * std::f64::consts::FRAC_PI_3 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_paper_s_mass_matrix_has_the_known_entries() {
        for (load_kg, m11, m12, m22) in
            [(80.0, 0.63881313, 0.08082839, 1.33615609), (60.0, 0.56847653, 0.05745091, 1.15556764)]
        {
            let m = Robot::of_the_paper(load_kg).mass_matrix();
            for (got, expected) in [(m.m11, m11), (m.m12, m12), (m.m22, m22)] {
                assert!((got - expected).abs() < 5e-9, "{got} instead of {expected}");
            }
        }
    }

    #[test]
    fn wheel_speeds_undo_the_twist() {
        let robot = Robot::of_the_paper(80.0);
        let wheels = Wheels { right: 1.7, left: -0.4 };
        let twist = robot.twist(wheels);
        let back = robot.wheels(twist.speed_m_s, twist.yaw_rate_rad_s);
        assert!((back - wheels).all(|error| error.abs() < 1e-14));
    }

    #[test]
    fn the_heading_grows_with_the_right_wheel() {
        assert!(Robot::of_the_paper(80.0).twist(Wheels { right: 1.0, left: 0.0 }).yaw_rate_rad_s > 0.0);
    }
}
