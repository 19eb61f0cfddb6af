//! From the turning of the wheels to the pose, eq 1-2.

use canloop::robot::{Pose, Robot};
use canloop::wheels::Wheels;

use super::stretch::Step;

/// The robot's way over the floor.
#[derive(Clone, Debug)]
pub struct Course {
    robot: Robot,
    start_heading_rad: f64,
    pose: Pose,
    /// Sine and cosine of the heading.
    sine: f64,
    cosine: f64,
}

impl Course {
    /// A way that begins at `start`, where the wheel angles are zero.
    pub fn new(robot: Robot, start: Pose) -> Self {
        let (sine, cosine) = libm::sincos(start.heading_rad);
        Self { robot, start_heading_rad: start.heading_rad, pose: start, sine, cosine }
    }

    /// Where the robot is now.
    pub const fn pose(&self) -> Pose {
        self.pose
    }

    /// Goes on by one step, at whose end the wheels stand at `angle_rad`.
    ///
    /// The heading follows from the angles without error. The place is the
    /// way rolled along the old heading, exact as well, less what the turn
    /// during the step takes off: that alone is left to Simpson's rule.
    pub fn follow(&mut self, step: &Step, angle_rad: Wheels<f64>) {
        let rolled = self.robot.twist(step.turned);
        let end_m_s = self.robot.twist(step.speed).speed_m_s;
        let mid_m_s = self.robot.twist(step.mid_speed).speed_m_s;
        let (end_sine, end_fall) = sine_and_fall(rolled.yaw_rate_rad_s);
        let (mid_sine, mid_fall) = sine_and_fall(self.robot.twist(step.mid_turned).yaw_rate_rad_s);
        let sixth_s = step.span_s / 6.0;
        let ahead_m = rolled.speed_m_s - sixth_s * (4.0 * mid_m_s * mid_fall + end_m_s * end_fall);
        let aside_m = sixth_s * (4.0 * mid_m_s * mid_sine + end_m_s * end_sine);
        self.pose.x_m += self.cosine * ahead_m - self.sine * aside_m;
        self.pose.y_m += self.sine * ahead_m + self.cosine * aside_m;
        self.pose.heading_rad = self.start_heading_rad + self.robot.twist(angle_rad).yaw_rate_rad_s;
        (self.sine, self.cosine) = libm::sincos(self.pose.heading_rad);
    }
}

/// `sin x` and `1 - cos x` of the small turn in a step.
fn sine_and_fall(x: f64) -> (f64, f64) {
    let square = x * x;
    let sine = x * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0)));
    let fall = square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0));
    (sine, fall)
}
