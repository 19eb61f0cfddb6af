//! Where the path wants the robot, as far as the far side can know: the path
//! begins at the SYNC at which both drives are enabled.

use canloop::path::Path;
use canloop::robot::Pose;

use crate::scenario::Scenario;

/// A path and when it began.
pub struct Route {
    path: Path,
    period_s: f64,
    enabled_at: Option<u64>,
}

impl Route {
    /// The path of `scenario`, not yet begun.
    pub fn new(scenario: &Scenario) -> Self {
        Self { path: scenario.stack.controller.path.clone(), period_s: scenario.period_s(), enabled_at: None }
    }

    /// The reference at SYNC number `tick`, at which the drives were `enabled`
    /// or not.
    pub fn at(&mut self, tick: u64, enabled: bool) -> Pose {
        if enabled {
            self.enabled_at.get_or_insert(tick);
        }
        let into_path = self.enabled_at.map_or(0, |first| tick - first);
        self.path.at(into_path as f64 * self.period_s).pose
    }
}
