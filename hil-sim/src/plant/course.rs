//! From the turning of the wheels to the pose, eq 1-2.

use canloop::robot::{Pose, Robot, Twist};
use canloop::wheels::Wheels;

use super::stretch::Step;

/// The robot's way over the floor.
#[derive(Clone, Debug)]
pub struct Course {
    /// Way of the axle's middle per sum of the wheels' turns, m/rad.
    roll_ratio: f64,
    /// Turn of the body per difference of the wheels' turns.
    yaw_ratio: f64,
    start_heading_rad: f64,
    pose: Pose,
    /// Sine and cosine of the heading.
    sine: f64,
    cosine: f64,
}

impl Course {
    /// A way that begins at `start`, where the wheel angles are zero.
    pub fn new(robot: &Robot, start: Pose) -> Self {
        let (sine, cosine) = libm::sincos(start.heading_rad);
        let Twist { speed_m_s: roll_ratio, yaw_rate_rad_s: yaw_ratio } = robot.twist(Wheels { right: 1.0, left: 0.0 });
        Self { roll_ratio, yaw_ratio, start_heading_rad: start.heading_rad, pose: start, sine, cosine }
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
        let (end_sine, end_fall) = sine_and_fall(self.yaw(step.turned));
        let (mid_sine, mid_fall) = sine_and_fall(self.yaw(step.mid_turned));
        let (end_m_s, mid_m_s) = (self.roll(step.speed), self.roll(step.mid_speed));
        let sixth_s = step.span_s * (1.0 / 6.0);
        let ahead_m = self.roll(step.turned) - sixth_s * (4.0 * mid_m_s * mid_fall + end_m_s * end_fall);
        let aside_m = sixth_s * (4.0 * mid_m_s * mid_sine + end_m_s * end_sine);
        self.pose.x_m += self.cosine * ahead_m - self.sine * aside_m;
        self.pose.y_m += self.sine * ahead_m + self.cosine * aside_m;
        self.pose.heading_rad = self.start_heading_rad + self.yaw(angle_rad);
        (self.sine, self.cosine) = libm::sincos(self.pose.heading_rad);
    }

    /// Turn of the body for these turns, or turn rates, of the wheels.
    pub fn yaw(&self, wheels: Wheels<f64>) -> f64 {
        self.yaw_ratio * (wheels.right - wheels.left)
    }

    fn roll(&self, wheels: Wheels<f64>) -> f64 {
        self.roll_ratio * (wheels.right + wheels.left)
    }
}

/// `sin x` and `1 - cos x` of the small turn in a step, by their series.
fn sine_and_fall(x: f64) -> (f64, f64) {
    let square = x * x;
    let sine = x * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5040.0))));
    let fall = square * (1.0 / 2.0 - square * (1.0 / 24.0 - square * (1.0 / 720.0)));
    (sine, fall)
}
