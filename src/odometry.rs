//! How the wheels turn and where the robot is, from encoder counts.

use crate::control::Measured;
use crate::robot::{Pose, Robot};
use crate::time::Duration;
use crate::wheels::{Wheel, Wheels};

/// Integrates latched encoder positions.
pub struct Odometry {
    robot: Robot,
    rad_per_count: f64,
    last: Option<Sample>,
    pose: Pose,
}

#[derive(Clone, Copy)]
struct Sample {
    position_counts: Wheels<i32>,
    /// Counts since the beginning; never wraps.
    travelled_counts: Wheels<i64>,
    speed_rad_s: Wheels<f64>,
    span_s: f64,
    torque_nm: Wheels<f64>,
}

impl Odometry {
    /// A robot that stands at `start`, with encoders of `counts_per_turn` at
    /// the motor shafts.
    pub fn new(robot: Robot, counts_per_turn: u32, start: Pose) -> Self {
        let counts_per_wheel_turn = f64::from(counts_per_turn) * robot.gear_ratio;
        Self { robot, rad_per_count: 2.0 * std::f64::consts::PI / counts_per_wheel_turn, last: None, pose: start }
    }

    /// Takes positions that both drives latched `span` after the ones before,
    /// and the mean torque applied (N m) in between. Positions wrap at 32 bits.
    ///
    /// The acceleration is a second difference, so it is the mean over the last
    /// two spans; the torque that goes with it is their mean, too.
    pub fn update(&mut self, position_counts: Wheels<i32>, torque_applied_nm: Wheels<f64>, span: Duration) -> Measured {
        let span_s = span.as_secs_f64();
        let last = self.last.unwrap_or(Sample {
            position_counts,
            travelled_counts: Wheels::default(),
            speed_rad_s: Wheels::default(),
            span_s,
            torque_nm: torque_applied_nm,
        });
        let moved_counts = position_counts.zip_with(last.position_counts, i32::wrapping_sub);
        let moved_rad = moved_counts.map(|counts| f64::from(counts) * self.rad_per_count);
        let speed_rad_s = moved_rad * (1.0 / span_s);
        let travelled_counts = last.travelled_counts.zip_with(moved_counts, |sum, moved| sum + i64::from(moved));
        self.last =
            Some(Sample { position_counts, travelled_counts, speed_rad_s, span_s, torque_nm: torque_applied_nm });
        self.move_pose(moved_rad);
        Measured {
            angle_rad: travelled_counts.map(|counts| counts as f64 * self.rad_per_count),
            speed_rad_s,
            acceleration_rad_s2: (speed_rad_s - last.speed_rad_s) * (2.0 / (span_s + last.span_s)),
            torque_nm: (torque_applied_nm + last.torque_nm) * 0.5,
        }
    }

    /// Where the robot is believed to be.
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// Counts that a wheel has moved since the beginning.
    pub fn travelled_counts(&self, wheel: Wheel) -> i64 {
        self.last.map_or(0, |last| last.travelled_counts[wheel])
    }

    /// Moves along an arc: exact while both wheels keep their speeds over the span.
    fn move_pose(&mut self, moved_rad: Wheels<f64>) {
        let moved = self.robot.twist(moved_rad);
        let (distance_m, turn_rad) = (moved.speed_m_s, moved.yaw_rate_rad_s);
        let half_rad = 0.5 * turn_rad;
        // sin(x)/x by its series: at the angles of one period its next term is below rounding.
        let square = half_rad * half_rad;
        let chord_m = if square < 1e-4 {
            distance_m * (1.0 - square / 6.0 * (1.0 - square / 20.0))
        } else {
            distance_m * libm::sin(half_rad) / half_rad
        };
        let (sin, cos) = libm::sincos(self.pose.heading_rad + half_rad);
        self.pose.x_m += chord_m * cos;
        self.pose.y_m += chord_m * sin;
        self.pose.heading_rad += turn_rad;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{Load, Model};

    fn odometry() -> Odometry {
        let robot = Robot {
            model: Model::Paper,
            mass_kg: 46.5,
            inertia_kg_m2: 1.3133,
            half_track_m: 0.27,
            wheel_radius_m: 0.122,
            wheel_inertia_kg_m2: 0.0144,
            motor_inertia_kg_m2: 0.0125,
            gear_ratio: 3.0,
            load: Load { mass_kg: 80.0, cog_distance_m: 0.2, cog_angle_rad: 2.0 },
        };
        Odometry::new(robot, 1000, Pose::default())
    }

    #[test]
    fn positions_that_wrap_go_on() {
        let mut odometry = odometry();
        let period = Duration::from_millis(5);
        let mut counts = Wheels::both(i32::MAX - 100);
        for _ in 0..10 {
            odometry.update(counts, Wheels::default(), period);
            counts = counts.map(|counts| counts.wrapping_add(60));
        }
        assert_eq!(odometry.travelled_counts(Wheel::Right), 540);
        assert_eq!(odometry.pose().y_m, 0.0);
        assert!(odometry.pose().x_m > 0.0);
    }

    #[test]
    fn wheels_against_each_other_turn_the_robot_on_the_spot() {
        let mut odometry = odometry();
        odometry.update(Wheels::default(), Wheels::default(), Duration::from_millis(5));
        odometry.update(Wheels { right: 300, left: -300 }, Wheels::default(), Duration::from_millis(5));
        let angle_rad = 2.0 * std::f64::consts::PI * 300.0 / 3000.0;
        assert!((odometry.pose().heading_rad - 0.122 * angle_rad / 0.27).abs() < 1e-12);
        assert!(odometry.pose().distance_m(&Pose::default()) < 1e-15);
    }

    #[test]
    fn acceleration_and_torque_are_means_over_the_same_two_periods() {
        let mut odometry = odometry();
        let period = Duration::from_millis(10);
        let at = |counts: i32| Wheels::both(counts);
        odometry.update(at(0), Wheels::both(0.0), period);
        odometry.update(at(10), Wheels::both(4.0), period);
        let measured = odometry.update(at(40), Wheels::both(6.0), period);
        let rad_per_count = 2.0 * std::f64::consts::PI / 3000.0;
        assert!((measured.acceleration_rad_s2.left - 20.0 * rad_per_count / 1e-4).abs() < 1e-9);
        assert_eq!(measured.torque_nm.left, 5.0);
    }
}
