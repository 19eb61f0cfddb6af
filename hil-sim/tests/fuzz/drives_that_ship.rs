//! The drives that ship, each with the scenario that drives the paper's robot
//! with it.

use canloop::bus::BitRates;
use hil_sim::scenario::{Link, Scenario};

use crate::drives::DRIVES;
use crate::script::Script;

/// What a robot has set, so that nothing goes unwatched.
const WATCHES: [&str; 3] =
    ["safety.following_error_rad=0.5", "safety.wheel_speed_limit_rad_s=4.0", "safety.saturation_timeout_s=0.1"];

/// A scenario for every profile that ships.
pub struct ShippedDrives(Vec<Scenario>);

impl ShippedDrives {
    pub fn load() -> Self {
        let watches = WATCHES.map(str::to_owned);
        let load = |name: &str| Scenario::load(name, &watches).expect("a good scenario");
        Self(DRIVES.iter().map(|drive| load(drive.scenario)).collect())
    }

    /// The one that the script is about: it names the profile.
    pub fn chosen_by(&self, script: &Script<'_>) -> &Scenario {
        script.chosen(&self.0, |scenario| &scenario.stack.profile.name)
    }
}

/// The bit rates of the scenario's bus.
pub fn bit_rates(scenario: &Scenario) -> BitRates {
    match scenario.link {
        Link::Can(rates) => rates,
        Link::Ideal => unreachable!("these scenarios have a bus"),
    }
}
