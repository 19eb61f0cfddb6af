//! Where the path wants the robot, as far as the far side can know when it
//! began.

use canloop::path::Path;
use canloop::robot::Pose;

use crate::scenario::Scenario;

/// A path, run through from some period on.
pub struct Route {
    path: Path,
    period_s: f64,
}

impl Route {
    /// The path of `scenario`.
    pub fn new(scenario: &Scenario) -> Self {
        Self { path: scenario.stack.controller.path.clone(), period_s: scenario.period_s() }
    }

    /// The reference in period `tick`, the path having begun or not.
    pub fn at(&self, tick: u64, path_began: Option<u64>) -> Pose {
        let into_path = path_began.map_or(0, |first| tick - first);
        self.path.at(into_path as f64 * self.period_s).pose
    }
}
