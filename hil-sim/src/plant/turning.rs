//! A pair of wheels that turn, under torque and friction.

use canloop::wheels::Wheels;

use super::course::Course;
use super::dynamics::Dynamics;
use super::stretch::{Step, Stretch};
use super::torque::Torque;

/// A wheel turns no faster than this, rad/s, whatever the torque: it keeps
/// absurd input within finite numbers.
const FASTEST_RAD_S: f64 = 1e5;

/// How two wheels turn, and what makes them.
#[derive(Clone, Debug)]
pub struct Turning {
    /// What turns torque into acceleration.
    pub dynamics: Dynamics,
    /// What they have turned since the start, rad.
    pub angle_rad: Wheels<f64>,
    /// How fast they turn, rad/s.
    pub speed_rad_s: Wheels<f64>,
}

impl Turning {
    /// Wheels at rest.
    pub fn new(dynamics: Dynamics) -> Self {
        Self { dynamics, angle_rad: Wheels::default(), speed_rad_s: Wheels::default() }
    }

    /// Moves on by `span_s` seconds in steps whose lengths `refinement`
    /// divides, and takes the robot along its `course`.
    pub fn advance(&mut self, span_s: f64, mut torque: Wheels<Torque>, refinement: f64, course: &mut Course) {
        let mut left_s = span_s;
        while left_s > 0.0 {
            let step = self.step(left_s, torque, refinement, course);
            if self.commit(&step) {
                course.follow(&step, self.angle_rad);
            }
            left_s -= step.span_s;
            if left_s > 0.0 {
                torque = torque.map(|torque| torque.after(step.span_s));
            }
        }
    }

    /// One step, no longer than `left_s` and not beyond the instant at which
    /// a wheel comes to rest or breaks loose.
    fn step(&self, left_s: f64, torque: Wheels<Torque>, refinement: f64, course: &Course) -> Step {
        let grip = self.dynamics.grip(self.speed_rad_s, torque.map(|torque| torque.now_nm()));
        let stretch = Stretch::new(&self.dynamics, grip, self.speed_rad_s, torque);
        let step = stretch.step(stretch.step_limit(left_s, refinement, course));
        stretch.lasting(step)
    }

    /// Whether anything has moved.
    fn commit(&mut self, step: &Step) -> bool {
        let none = Wheels::default();
        if self.speed_rad_s == none && step.speed == none && step.turned == none {
            return false;
        }
        self.angle_rad = self.angle_rad + step.turned;
        self.speed_rad_s = step.speed.map(|speed| speed.clamp(-FASTEST_RAD_S, FASTEST_RAD_S));
        true
    }
}
