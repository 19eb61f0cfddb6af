//! Wheels that are off the floor: they turn by themselves, while the robot
//! rolls on over the other one.

use canloop::robot::Robot;
use canloop::wheels::{Wheel, Wheels};

use super::course::Course;
use super::dynamics::Dynamics;
use super::friction::Friction;
use super::torque::Torque;
use super::turning::Turning;

/// Which wheels are off the floor, and how those turn.
#[derive(Clone, Debug)]
pub struct Lift {
    lifted: Wheels<bool>,
    air: Turning,
    /// By how much each wheel has turned further than its side has rolled, rad,
    /// as of its last landing.
    slipped_rad: Wheels<f64>,
}

impl Lift {
    /// Both wheels on the floor.
    pub fn none(robot: &Robot, friction: Wheels<Friction>) -> Self {
        let air = Turning::new(Dynamics::in_the_air(robot, friction));
        Self { lifted: Wheels::default(), air, slipped_rad: Wheels::default() }
    }

    /// Which wheels are off the floor.
    pub const fn lifted(&self) -> Wheels<bool> {
        self.lifted
    }

    /// The dynamics of a robot or of friction that has changed; of both, the
    /// floor's are returned.
    pub fn refit(&mut self, robot: &Robot, friction: Wheels<Friction>) -> Dynamics {
        self.air.dynamics = Dynamics::in_the_air(robot, friction);
        Dynamics::on_the_floor(robot, friction, self.lifted)
    }

    /// These wheels are off the floor from now on, the others on it. One that
    /// comes down grips at once: it and the robot go on at one speed. With both
    /// in the air the robot stands on something else, at rest.
    pub fn change(&mut self, lifted: Wheels<bool>, robot: &Robot, friction: Wheels<Friction>, floor: &mut Turning) {
        let before = std::mem::replace(&mut self.lifted, lifted);
        for wheel in Wheel::BOTH {
            if lifted[wheel] && !before[wheel] {
                self.air.angle_rad[wheel] = floor.angle_rad[wheel] + self.slipped_rad[wheel];
                self.air.speed_rad_s[wheel] = floor.speed_rad_s[wheel];
            }
        }
        if lifted.all(|&is_lifted| is_lifted) {
            floor.speed_rad_s = Wheels::default();
        }
        for wheel in Wheel::BOTH.into_iter().filter(|&wheel| before[wheel] && !lifted[wheel]) {
            self.slipped_rad[wheel] = self.air.angle_rad[wheel] - floor.angle_rad[wheel];
            let landing_rad_s = std::mem::take(&mut self.air.speed_rad_s[wheel]);
            floor.speed_rad_s = floor.dynamics.after_landing(wheel, landing_rad_s, floor.speed_rad_s, robot);
            let in_the_air = Wheels::from_fn(|other| lifted[other] || before[other] && other != wheel);
            floor.dynamics = Dynamics::on_the_floor(robot, friction, in_the_air);
        }
        floor.dynamics = self.refit(robot, friction);
    }

    /// Moves lifted wheels on by `span_s` seconds under their share of
    /// `torque`; the rest of it is left for the floor.
    pub fn advance(&mut self, span_s: f64, torque: Wheels<Torque>, refinement: f64, course: &Course) -> Wheels<Torque> {
        if !self.lifted.any(|&is_lifted| is_lifted) {
            return torque;
        }
        let share = |is_in_the_air: bool| {
            torque.zip_with(
                self.lifted,
                |torque, is_lifted| {
                    if is_lifted == is_in_the_air { torque } else { Torque::constant(0.0) }
                },
            )
        };
        let (of_air, of_floor) = (share(true), share(false));
        // The robot's own course is the floor's business.
        self.air.advance(span_s, of_air, refinement, &mut course.clone());
        of_floor
    }

    /// Angles, rad, and speeds, rad/s, of the wheels, as encoders see them.
    pub fn seen(&self, floor: &Turning) -> (Wheels<f64>, Wheels<f64>) {
        let angle = |wheel| match self.lifted[wheel] {
            true => self.air.angle_rad[wheel],
            false => floor.angle_rad[wheel] + self.slipped_rad[wheel],
        };
        let speed = |wheel| if self.lifted[wheel] { self.air.speed_rad_s[wheel] } else { floor.speed_rad_s[wheel] };
        (Wheels::from_fn(angle), Wheels::from_fn(speed))
    }
}
