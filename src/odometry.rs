//! How the wheels turn and where the robot is, from what the drives report.

use crate::control::Measured;
use crate::estimator::{Estimator, Sample};
use crate::robot::{Pose, Robot};
use crate::wheels::Wheels;

/// Integrates what the drives report.
pub struct Odometry {
    robot: Robot,
    estimators: Wheels<Estimator>,
    pose: Pose,
}

impl Odometry {
    /// A robot that stands at `start`, its wheels followed by `estimators`.
    pub fn new(robot: Robot, estimators: Wheels<Estimator>, start: Pose) -> Self {
        Self { robot, estimators, pose: start }
    }

    /// Takes what both drives reported, each `span_s` seconds after the report
    /// before.
    pub fn update(&mut self, samples: Wheels<Sample>, span_s: Wheels<f64>) -> Measured {
        let right = self.estimators.right.update(samples.right, span_s.right);
        let left = self.estimators.left.update(samples.left, span_s.left);
        let motion = Wheels { right, left };
        self.move_pose(motion.map(|motion| motion.moved_rad));
        Measured {
            angle_rad: motion.map(|motion| motion.angle_rad),
            speed_rad_s: motion.map(|motion| motion.speed_rad_s),
            acceleration_rad_s2: motion.map(|motion| motion.acceleration_rad_s2),
            torque_nm: motion.map(|motion| motion.torque_nm),
        }
    }

    /// Where the robot is believed to be.
    pub fn pose(&self) -> Pose {
        self.pose
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
    use crate::schema::PositionScale;

    const PERIOD_S: Wheels<f64> = Wheels { right: 0.005, left: 0.005 };

    fn odometry() -> Odometry {
        let robot = Robot::of_the_paper(80.0);
        let rad_per_unit = 2.0 * std::f64::consts::PI / 3000.0;
        let scale = PositionScale { rad_per_unit, wraps_at: Some(4_294_967_296.0), resolution: 1.0 };
        Odometry::new(robot, Wheels::both(Estimator::new(Some(scale), None, 0.005)), Pose::default())
    }

    fn at(counts: Wheels<i32>) -> Wheels<Sample> {
        counts.map(|counts| Sample { position: Some(f64::from(counts)), ..Sample::default() })
    }

    #[test]
    fn positions_that_wrap_go_straight_on() {
        let mut odometry = odometry();
        let mut counts = Wheels::both(i32::MAX - 100);
        let mut measured = Measured::default();
        for _ in 0..10 {
            measured = odometry.update(at(counts), PERIOD_S);
            counts = counts.map(|counts| counts.wrapping_add(60));
        }
        assert!((measured.angle_rad.right - 2.0 * std::f64::consts::PI * 540.0 / 3000.0).abs() < 1e-12);
        assert_eq!(odometry.pose().y_m, 0.0);
        assert!(odometry.pose().x_m > 0.0);
    }

    #[test]
    fn wheels_against_each_other_turn_the_robot_on_the_spot() {
        let mut odometry = odometry();
        odometry.update(at(Wheels::default()), PERIOD_S);
        odometry.update(at(Wheels { right: 300, left: -300 }), PERIOD_S);
        let angle_rad = 2.0 * std::f64::consts::PI * 300.0 / 3000.0;
        assert!((odometry.pose().heading_rad - 0.122 * angle_rad / 0.27).abs() < 1e-12);
        assert!(odometry.pose().distance_m(&Pose::default()) < 1e-15);
    }
}
