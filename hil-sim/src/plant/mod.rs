//! The robot's dynamics: wheel torques in, wheel angles and pose out.
//!
//! Eq 5 gives the wheels' acceleration, eq 6-8 the friction, eq 1-2 the pose.
//! Sticking is true sticking: a stuck wheel has no speed and no acceleration
//! at all. The motion is cut into stretches at the instants when a wheel comes
//! to rest or breaks loose, and within a stretch it is smooth.

mod course;
mod dynamics;
mod event;
mod friction;
mod grip;
mod lift;
mod limit;
mod stretch;
mod torque;
mod turning;

use canloop::robot::{Load, Pose, Robot};
use canloop::wheels::Wheels;

use course::Course;
use dynamics::Dynamics;
use lift::Lift;
use turning::Turning;

pub use friction::Friction;
pub use torque::Torque;

/// The robot on the floor, with motors that give torque.
#[derive(Clone, Debug)]
pub struct Plant {
    robot: Robot,
    /// In the wheels' bearings and gears.
    friction: Wheels<Friction>,
    /// How wheels on the floor turn, and the robot with them.
    floor: Turning,
    /// How wheels off the floor turn.
    lift: Lift,
    course: Course,
    /// What pushes the robot, as torque at the wheels, N m.
    pushed_nm: Wheels<f64>,
    state: State,
    /// Divides the length of every step.
    refinement: f64,
}

/// Where the plant is and how it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// What the wheels have turned since the start, rad.
    pub angle_rad: Wheels<f64>,
    /// How fast they turn, rad/s.
    pub speed_rad_s: Wheels<f64>,
    /// Where the middle of the axle is.
    pub pose: Pose,
}

impl Plant {
    /// A robot at rest at `start`, its wheel angles zero.
    pub fn new(robot: Robot, friction: Wheels<Friction>, start: Pose) -> Self {
        Self {
            robot,
            friction,
            floor: Turning::new(Dynamics::new(&robot, friction)),
            lift: Lift::none(&robot, friction),
            pushed_nm: Wheels::default(),
            course: Course::new(&robot, start),
            state: State { pose: start, ..State::default() },
            refinement: 1.0,
        }
    }

    /// The same plant with its internal steps shorter by `factor`, to check
    /// that results do not depend on them.
    pub fn with_finer_steps(self, factor: f64) -> Self {
        Self { refinement: self.refinement * factor, ..self }
    }

    /// Moves on by `span_s` seconds, however many, under this torque, which
    /// must be finite. Nothing happens for zero or less.
    pub fn advance(&mut self, span_s: f64, torque: Wheels<Torque>) {
        let Self { floor, lift, course, .. } = self;
        let on_floor = lift.advance(span_s, torque, self.refinement, course);
        let pushed = on_floor.zip_with(self.pushed_nm, |torque, pushed_nm| torque.raised_by(pushed_nm));
        if !lift.lifted().all(|&is_lifted| is_lifted) {
            floor.advance(span_s, pushed, self.refinement, course);
        }
        let (angle_rad, speed_rad_s) = lift.seen(floor);
        self.state = State { angle_rad, speed_rad_s, pose: course.pose() };
    }

    /// Another load, or the same one elsewhere, from now on. The wheels go on
    /// at the speed that they have.
    pub fn set_load(&mut self, load: Load) {
        self.robot.load = load;
        self.floor.dynamics = self.lift.refit(&self.robot, self.friction);
    }

    /// Other friction from now on.
    pub fn set_friction(&mut self, friction: Wheels<Friction>) {
        self.friction = friction;
        self.floor.dynamics = self.lift.refit(&self.robot, friction);
    }

    /// These wheels are off the floor from now on, the others on it, where one
    /// that comes down grips at once. The robot rolls on over the wheel that it
    /// has left; with none it stands on something else, at rest.
    pub fn lift(&mut self, lifted: Wheels<bool>) {
        if lifted != self.lift.lifted() {
            self.lift.change(lifted, &self.robot, self.friction, &mut self.floor);
            (self.state.angle_rad, self.state.speed_rad_s) = self.lift.seen(&self.floor);
        }
    }

    /// The friction of the wheels.
    pub const fn friction(&self) -> &Wheels<Friction> {
        &self.friction
    }

    /// The robot as it is now, with its load.
    pub const fn robot(&self) -> &Robot {
        &self.robot
    }

    /// Pushes the robot from now on with a force along its heading, N, at the
    /// middle of the axle, and a moment about it, N m, counter-clockwise. What
    /// pushes it sideways the wheels hold.
    pub fn push(&mut self, force_n: f64, moment_nm: f64) {
        let Robot { wheel_radius_m, half_track_m, .. } = self.robot;
        // The same power at the wheels: eq 1-2 transposed.
        let (straight_nm, turning_nm) =
            (force_n * wheel_radius_m / 2.0, moment_nm * wheel_radius_m / (2.0 * half_track_m));
        self.pushed_nm = Wheels { right: straight_nm + turning_nm, left: straight_nm - turning_nm };
    }

    /// The present state.
    pub const fn state(&self) -> &State {
        &self.state
    }

    /// Acceleration, rad/s^2, of wheels on the floor just now under this torque,
    /// N m; zero for a wheel that sticks.
    pub fn acceleration(&self, torque_nm: Wheels<f64>) -> Wheels<f64> {
        let Turning { dynamics, speed_rad_s, .. } = &self.floor;
        let grip = dynamics.grip(*speed_rad_s, torque_nm);
        dynamics.mobility(grip).times(dynamics.net_nm(grip, *speed_rad_s, torque_nm))
    }

    /// Which wheels are at rest with dry friction holding them.
    pub fn is_stuck(&self) -> Wheels<bool> {
        self.state.speed_rad_s.zip_with(self.friction, |speed, friction| speed == 0.0 && friction.is_dry())
    }

    /// Gives the wheels these speeds, rad/s, at once, as a start for tests.
    pub fn set_speed(&mut self, speed_rad_s: Wheels<f64>) {
        self.floor.speed_rad_s = speed_rad_s;
        self.state.speed_rad_s = speed_rad_s;
    }
}
