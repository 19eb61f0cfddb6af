//! A scenario: the robot as it is, the stack that drives it, the bus between
//! them, and what is expected of the run.

use canloop::bus::{BitRates, read_bit_rate};
use canloop::config::{Bound, Document, Problems, Reader, Section};
use canloop::robot::Robot;
use canloop::stack::StackConfig;
use canloop::time::{Duration, Instant};
use canloop::wheels::{Wheel, Wheels};

use crate::drive::DriveSpec;
use crate::encoder::Encoder;
use crate::expect::{Expectation, Vocabulary};
use crate::plant::{Friction, Plant};
use crate::timeline::{Planned, read_events};
use crate::virtual_robot::VirtualRobot;

/// Everything that a run is made from.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Its name, for folders and summaries.
    pub name: String,
    /// Where all randomness comes from.
    pub seed: u64,
    /// Simulated time, s.
    pub duration_s: f64,
    /// The robot as it is.
    pub robot: Robot,
    /// Friction as it is.
    pub friction: Wheels<Friction>,
    /// The stack, with what it believes.
    pub stack: StackConfig,
    /// What joins the two.
    pub link: Link,
    /// How much later each frame reaches the bus than it was sent, as through
    /// an adapter or a gateway.
    pub bus_delay: Duration,
    /// What happens on the way.
    pub events: Vec<Planned>,
    /// What must hold.
    pub expectations: Vec<Expectation>,
    /// The scenario as one TOML text, with its base and the overrides in it.
    pub text: String,
    /// The name or the path that it was loaded by.
    pub given: String,
    /// The overrides laid over it, as given.
    pub overrides: Vec<String>,
}

/// What joins stack and plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// Law and plant joined directly, exact sensors, no frames: the paper's
    /// own simulation.
    Ideal,
    /// Frames over a CAN bus with these bit rates.
    Can(BitRates),
}

/// The scenarios that ship with the program, by name.
pub const SHIPPED: &[(&str, &str)] = &include!(concat!(env!("OUT_DIR"), "/scenarios.rs"));

impl Scenario {
    /// Loads a shipped scenario by its name, or a file by its path, with
    /// `KEY=VALUE` overrides laid over it.
    pub fn load(name_or_path: &str, overrides: &[String]) -> Result<Self, Problems> {
        let mut document = Document::open(name_or_path, SHIPPED)?;
        for assignment in overrides {
            document.set(assignment)?;
        }
        let reader = Reader::new(&document);
        let mut scenario = Self::read(&reader.root());
        scenario.text = document.resolved();
        scenario.given = name_or_path.to_owned();
        scenario.overrides = overrides.to_vec();
        reader.finish(scenario)
    }

    /// Number of periods simulated.
    pub fn ticks(&self) -> u64 {
        (self.duration_s / self.period_s()).round() as u64
    }

    /// T, s.
    pub fn period_s(&self) -> f64 {
        self.stack.period.as_secs_f64()
    }

    /// The plant, at rest at the start.
    pub fn plant(&self) -> Plant {
        Plant::new(self.robot, self.friction, self.stack.start)
    }

    /// Drives and plant as they are, not as the stack believes them to be,
    /// switched on at `start`.
    pub fn virtual_robot(&self, start: Instant) -> VirtualRobot {
        let mut profile = self.stack.profile.clone();
        profile.fit(&self.stack.drive.motor(self.robot.gear_ratio));
        VirtualRobot::new(profile, self.plant(), self.drive_spec(), start)
    }

    /// The simulated drives.
    pub fn drive_spec(&self) -> DriveSpec {
        let drive = &self.stack.drive;
        DriveSpec {
            encoder: Encoder { counts_per_turn: drive.counts_per_turn, gear_ratio: self.robot.gear_ratio },
            torque_limit_nm: drive.torque_limit_nm,
            torque_step_nm: self.stack.profile.command_torque(Wheel::Right).resolution_nm,
            current_loop_s: drive.current_loop_s,
        }
    }

    fn read(root: &Section<'_>) -> Self {
        let robot = root.section("robot");
        let truth = Robot::read(&robot, None);
        let duration_s = root.number("duration_s", Bound::Within(1e-3, 1e6));
        // Followed already, when the document was opened.
        root.text_or_none("base");
        let stack = StackConfig::read(root, &truth);
        let events = read_events(root, &truth, &stack.profile.dbc, duration_s);
        let names: Vec<String> = events.iter().map(|event| event.name.clone()).collect();
        let scenario = Self {
            name: read_name(root),
            seed: root.integer_or("seed", 0, 0, i64::MAX) as u64,
            duration_s,
            friction: read_friction(&robot.section("friction")),
            expectations: read_expectations(root, &Vocabulary { dbc: &stack.profile.dbc, events: &names, duration_s }),
            events,
            stack,
            robot: truth,
            link: read_link(&root.section("bus")),
            bus_delay: read_delay(&root.section("bus")),
            text: String::new(),
            given: String::new(),
            overrides: Vec::new(),
        };
        if scenario.link == Link::Ideal && !scenario.events.is_empty() {
            root.complain("event", "found events on an ideal link, which nothing can go wrong on, expected a bus");
        }
        if scenario.period_s() > duration_s {
            root.complain("period_s", &format!("found a period longer than `duration_s`, {duration_s}"));
        }
        scenario
    }
}

/// The name becomes a folder, so it may not lead out of its parent.
fn read_name(root: &Section<'_>) -> String {
    if !root.has("name") {
        return root.text("name");
    }
    let is_good = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    let name = root.text_or_none("name");
    if let Some(bad) =
        name.as_deref().filter(|name| name.is_empty() || name.starts_with('.') || !name.chars().all(is_good))
    {
        root.complain("name", &format!("found {bad:?}, expected letters, digits, `-`, `_` and `.`"));
    }
    name.unwrap_or_default()
}

fn read_expectations(root: &Section<'_>, vocabulary: &Vocabulary<'_>) -> Vec<Expectation> {
    let sections = root.sections("expect");
    let read = |one: &Section<'_>| Expectation::read(one, vocabulary, one.is_overlaid_by(root, "duration_s"));
    sections.iter().flat_map(read).collect()
}

fn read_link(bus: &Section<'_>) -> Link {
    let is_can = bus.choice("link", &[("can", true), ("ideal", false)], false);
    let nominal_bit_s = read_bit_rate(bus);
    let usual = i64::from(nominal_bit_s);
    let data_bit_s = bus.integer_or("data_bitrate_bit_s", usual, usual, 8_000_000) as u32;
    if is_can { Link::Can(BitRates { nominal_bit_s, data_bit_s }) } else { Link::Ideal }
}

fn read_delay(bus: &Section<'_>) -> Duration {
    let delay_s = bus.number_or("delay_s", 0.0, Bound::Within(0.0, 1.0));
    if delay_s.is_nan() { Duration::ZERO } else { Duration::from_secs_f64(delay_s) }
}

/// Both wheels alike, unless `right` or `left` overrides a number. No section
/// at all is no friction.
fn read_friction(section: &Section<'_>) -> Wheels<Friction> {
    if section.keys().is_empty() {
        return Wheels::default();
    }
    let read = |section: &Section<'_>, both: Option<Friction>| {
        let number = |key: &str, most: f64, default: Option<f64>| match default {
            Some(default) => section.number_or(key, default, Bound::Within(0.0, most)),
            None => section.number(key, Bound::Within(0.0, most)),
        };
        let friction = Friction {
            viscous_nm_s_per_rad: number("viscous_nm_s_per_rad", 1e4, both.map(|both| both.viscous_nm_s_per_rad)),
            static_nm: number("static_nm", 1e6, both.map(|both| both.static_nm)),
            coulomb_nm: number("coulomb_nm", 1e6, both.map(|both| both.coulomb_nm)),
            stribeck_s_per_rad: number("stribeck_s_per_rad", 1e6, both.map(|both| both.stribeck_s_per_rad)),
        };
        let own = both.is_none() || section.has("static_nm") || section.has("coulomb_nm");
        if own && friction.static_nm < friction.coulomb_nm {
            let found = format!("found {}, less than `coulomb_nm`, {}", friction.static_nm, friction.coulomb_nm);
            section.complain("static_nm", &format!("{found}; expected at least as much"));
        }
        friction
    };
    let both = read(section, None);
    Wheels { right: read(&section.section("right"), Some(both)), left: read(&section.section("left"), Some(both)) }
}
