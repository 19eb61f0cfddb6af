//! Every controller, with and without friction, ideal and over CAN.

use canloop::config::Problems;

use crate::scenario::Scenario;

/// One run of the set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Case {
    /// The controller's name.
    pub controller: &'static str,
    /// With or without.
    pub friction: Friction,
    /// Link and period.
    pub setup: Setup,
    /// Whether the robot starts off its path, at (8, 4, 0), and a pose loop
    /// brings it there.
    pub from_aside: bool,
}

/// Whether the floor brakes the wheels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Friction {
    /// T(theta') = 0, viscous friction too.
    None,
    /// As in the paper, section 4.
    Paper,
}

/// What joins law and plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setup {
    /// The paper's own: directly.
    Ideal {
        /// T, ms.
        period_ms: u32,
    },
    /// Through frames, at T = 5 ms.
    Can,
}

/// The laws with the paper's gains, as overrides of a scenario.
const CONTROLLERS: [(&str, &str); 4] = [
    ("dac", r#"controller={law="dac",kd_per_s=3.0,kp_per_s2=0.6}"#),
    ("dac-matched", r#"controller={law="dac-matched",kd_per_s=3.0,kp_per_s2=0.6,filter=0.3}"#),
    ("pi-speed", r#"controller={law="pi-speed",kp=1.0,ki=3.0}"#),
    ("pi-angle", r#"controller={law="pi-angle",kp=1.0,ki=3.0}"#),
];

/// The scenario that they all vary.
const BASE: &str = "dac-friction";
const NO_FRICTION: &str = "robot.friction={viscous_nm_s_per_rad=0,static_nm=0,coulomb_nm=0,stribeck_s_per_rad=0}";

/// The whole set, in the order of the table.
pub fn cases() -> Vec<Case> {
    let setups = [Setup::Ideal { period_ms: 1 }, Setup::Ideal { period_ms: 5 }, Setup::Can];
    let mut cases = Vec::new();
    for setup in setups {
        for (controller, _) in CONTROLLERS {
            for friction in [Friction::None, Friction::Paper] {
                cases.push(Case { controller, friction, setup, from_aside: false });
            }
        }
    }
    let aside = Case { controller: "dac-matched", friction: Friction::Paper, setup: Setup::Can, from_aside: true };
    cases.push(aside);
    cases
}

impl Case {
    /// The scenario, without expectations.
    pub fn scenario(&self) -> Result<Scenario, Problems> {
        Scenario::load(BASE, &self.overrides())
    }

    /// How anybody can run just this one.
    pub fn reproduce_line(&self) -> String {
        let sets: Vec<String> = self.overrides().iter().map(|set| format!("--set '{set}'")).collect();
        format!("hil-sim run {BASE} {}", sets.join(" "))
    }

    fn overrides(&self) -> Vec<String> {
        let mut sets = vec!["expect=[]".to_owned()];
        let law = CONTROLLERS.iter().find(|(name, _)| *name == self.controller);
        sets.extend(law.map(|(_, set)| (*set).to_owned()));
        if self.friction == Friction::None {
            sets.push(NO_FRICTION.to_owned());
        }
        if let Setup::Ideal { period_ms } = self.setup {
            sets.push(r#"bus.link="ideal""#.to_owned());
            sets.push(format!("period_s=0.00{period_ms}"));
        }
        if self.from_aside {
            sets.push(r#"controller.pose_loop="kanayama""#.to_owned());
            sets.push("start={x_m=8.0,y_m=4.0,heading_rad=0.0}".to_owned());
        }
        sets
    }
}

impl Friction {
    /// A word for tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Paper => "paper",
        }
    }
}

impl Setup {
    /// A word for tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ideal { .. } => "ideal",
            Self::Can => "CAN",
        }
    }

    /// T, ms.
    pub const fn period_ms(self) -> u32 {
        match self {
            Self::Ideal { period_ms } => period_ms,
            Self::Can => 5,
        }
    }
}
