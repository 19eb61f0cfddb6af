//! Reference paths: where the robot should be at any moment, how fast, and
//! with what acceleration.
//!
//! A path is a curve in the plane ([`geometry`]) run through by a speed
//! profile ([`profile`]). Both are closed forms in arc length and time, so a
//! path can be asked about any moment, ahead or behind, and wheel angles follow
//! from it without integrating anything.

pub mod geometry;
pub mod profile;
mod read;

use crate::robot::{Pose, Robot, Twist};
use crate::wheels::Wheels;
use geometry::Geometry;
use profile::SpeedProfile;

/// A curve and the speed along it.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    geometry: Geometry,
    profile: SpeedProfile,
}

/// What the path wants at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reference {
    /// Where the robot should be; the heading is not wrapped.
    pub pose: Pose,
    /// How fast it should move.
    pub twist: Twist,
    /// How fast its speed should change, m/s^2.
    pub acceleration_m_s2: f64,
    /// How fast its yaw rate should change, rad/s^2.
    pub yaw_acceleration_rad_s2: f64,
    /// Distance covered since the path's beginning, m.
    pub distance_m: f64,
    /// Heading gained since the path's beginning, rad.
    pub turn_rad: f64,
}

impl Path {
    /// Joins a curve and a speed profile of the same length.
    pub fn new(geometry: Geometry, profile: SpeedProfile) -> Self {
        Self { geometry, profile }
    }

    /// The reference `time_s` after the path's beginning; it rests at its ends
    /// before and after.
    pub fn at(&self, time_s: f64) -> Reference {
        let along = self.profile.at(time_s);
        let point = self.geometry.at(along.distance_m);
        Reference {
            pose: point.pose,
            twist: Twist { speed_m_s: along.speed_m_s, yaw_rate_rad_s: point.curvature_per_m * along.speed_m_s },
            acceleration_m_s2: along.acceleration_m_s2,
            yaw_acceleration_rad_s2: point.curvature_per_m * along.acceleration_m_s2
                + point.curvature_rate_per_m2 * along.speed_m_s * along.speed_m_s,
            distance_m: along.distance_m,
            turn_rad: point.pose.heading_rad - self.geometry.start().heading_rad,
        }
    }

    /// Where it begins.
    pub fn start(&self) -> Pose {
        self.geometry.start()
    }

    /// How long it takes, s.
    pub fn duration_s(&self) -> f64 {
        self.profile.duration_s()
    }
}

impl Reference {
    /// Wheel angles since the path's beginning, rad.
    pub fn wheel_angles_rad(&self, robot: &Robot) -> Wheels<f64> {
        robot.wheels(self.distance_m, self.turn_rad)
    }

    /// Wheel speeds, rad/s.
    pub fn wheel_speeds_rad_s(&self, robot: &Robot) -> Wheels<f64> {
        robot.wheels(self.twist.speed_m_s, self.twist.yaw_rate_rad_s)
    }

    /// Wheel accelerations, rad/s^2.
    pub fn wheel_accelerations_rad_s2(&self, robot: &Robot) -> Wheels<f64> {
        robot.wheels(self.acceleration_m_s2, self.yaw_acceleration_rad_s2)
    }
}
