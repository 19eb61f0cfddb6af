//! Guidance and law in one: from how the robot moves to torque.

use crate::config::Section;
use crate::path::{Path, Reference};
use crate::robot::{Pose, Robot};
use crate::wheels::Wheels;

use super::guidance::{Guidance, PoseLoop, Sampling};
use super::law::{Law, LawConfig, Measured, Target};

/// All that a controller is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerConfig {
    /// What the controller believes the robot to be.
    pub belief: Robot,
    /// Where it should go.
    pub path: Path,
    /// How it gets to the path.
    pub pose_loop: PoseLoop,
    /// How the wheels get to their targets.
    pub law: LawConfig,
    /// T, s.
    pub period_s: f64,
}

/// Leads the robot along its path, one period at a time.
pub struct Controller {
    guidance: Guidance,
    law: Box<dyn Law + Send>,
}

/// What the controller makes of one period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Decision {
    /// How the wheels should turn.
    pub target: Target,
    /// With what torque, N m; neither limited nor checked.
    pub torque_nm: Wheels<f64>,
}

impl ControllerConfig {
    /// Reads `[path]` and `[controller]`; what `[controller.model]` leaves out
    /// of the robot is as in `robot`.
    pub fn read(root: &Section<'_>, robot: &Robot, period_s: f64) -> Self {
        let section = root.section("controller");
        Self {
            belief: Robot::read(&section.section("model"), Some(robot)),
            path: Path::read(&root.section("path")),
            pose_loop: PoseLoop::read(&section),
            law: LawConfig::read(&section, period_s),
            period_s,
        }
    }

    /// Builds the controller.
    pub fn build(&self, sampling: Sampling) -> Controller {
        let path = self.path.clone();
        Controller {
            guidance: Guidance::new(path, self.belief, self.period_s, self.pose_loop, sampling),
            law: self.law.build(&self.belief, self.period_s),
        }
    }
}

impl Controller {
    /// Goes back to the path's beginning and forgets the past.
    pub fn reset(&mut self) {
        self.guidance.reset();
        self.law.reset();
    }

    /// Leads along another path, from its beginning.
    pub fn follow(&mut self, path: Path) {
        self.guidance.follow(path);
        self.law.reset();
    }

    /// The path at this tick.
    pub fn reference(&self) -> &Reference {
        self.guidance.reference()
    }

    /// Goes on to the next tick.
    pub fn advance(&mut self) {
        self.guidance.advance();
    }

    /// Leaves the path and brings the wheels to rest, the faster one at this
    /// deceleration.
    pub fn brake(&mut self, measured: &Measured, deceleration_rad_s2: f64) {
        self.guidance.brake(measured, deceleration_rad_s2);
    }

    /// Whether the wheels are being brought to rest.
    pub const fn is_braking(&self) -> bool {
        self.guidance.is_braking()
    }

    /// Whether the wheels are wanted to be at rest, and braking is over.
    pub fn is_braked(&self) -> bool {
        self.guidance.is_braked()
    }

    /// Decides this tick's torque. To be asked once a tick.
    pub fn decide(&mut self, pose: &Pose, measured: &Measured) -> Decision {
        let target = self.guidance.target(pose);
        Decision { target, torque_nm: self.law.torque_nm(&target, measured) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::tests::{PERIOD_S, circle, robot};

    fn controller() -> Controller {
        let law = LawConfig::Dac { kd_per_s: 3.0, kp_per_s2: 0.6 };
        let pose_loop = PoseLoop::None;
        ControllerConfig { belief: robot(), path: circle(), pose_loop, law, period_s: PERIOD_S }
            .build(Sampling::OverBus)
    }

    /// Decisions of the first ticks, at which the robot lags behind.
    fn first_decisions(controller: &mut Controller) -> [Decision; 3] {
        let lagging = Measured { angle_rad: Wheels::both(-0.1), ..Measured::default() };
        std::array::from_fn(|_| {
            let decision = controller.decide(&Pose::default(), &lagging);
            controller.advance();
            decision
        })
    }

    #[test]
    fn it_leads_along_the_path_and_a_reset_begins_anew() {
        let mut controller = controller();
        let start = *controller.reference();
        assert_eq!(start.pose, circle().start());
        let first = first_decisions(&mut controller);
        assert_ne!(first[0].torque_nm, first[1].torque_nm, "the law remembers");
        assert!(controller.reference().distance_m > start.distance_m);
        controller.reset();
        assert_eq!(*controller.reference(), start);
        assert_eq!(first_decisions(&mut controller), first);
    }

    #[test]
    fn braking_is_over_when_the_wheels_are_wanted_at_rest() {
        let mut controller = controller();
        assert!(!controller.is_braking() && !controller.is_braked());
        let turning = Measured { speed_rad_s: Wheels::both(0.05), ..Measured::default() };
        controller.brake(&turning, 5.0);
        assert!(controller.is_braking() && !controller.is_braked());
        for _ in 0..3 {
            controller.decide(&Pose::default(), &turning);
        }
        assert!(controller.is_braking() && controller.is_braked());
    }
}
