//! What a stack is made from.

use crate::bus::read_bit_rate;
use crate::config::{Bound, Document, Problem, Problems, Reader, Section};
use crate::control::ControllerConfig;
use crate::robot::{Pose, Robot};
use crate::safety::{Grounds, Limits};
use crate::schema::{Motor, Nameplate, Profile};
use crate::time::Duration;
use crate::wheels::{Wheel, Wheels};

/// All that a stack needs to know.
#[derive(Clone, Debug)]
pub struct StackConfig {
    /// T.
    pub period: Duration,
    /// Where the robot stands when the stack starts.
    pub start: Pose,
    /// Belief, path and law.
    pub controller: ControllerConfig,
    /// The motor drives.
    pub drive: DriveConfig,
    /// The frames they speak.
    pub profile: Profile,
    /// Limits of the safety gate.
    pub safety: Limits,
}

/// The motor drives, as far as their frames do not say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveConfig {
    /// Encoder counts a turn of the motor shaft.
    pub counts_per_turn: u32,
    /// Torque limit at the wheel, N m.
    pub torque_limit_nm: f64,
    /// Time constant of the current loop, s; 0 is none.
    pub current_loop_s: f64,
    /// What the profile leaves open of the motors, or the robot has otherwise.
    pub plate: Nameplate,
}

/// A robot's own file.
#[derive(Clone, Debug)]
pub struct RobotFile {
    /// What the stack is made from.
    pub stack: StackConfig,
    /// The nominal bit rate that its bus must have, where the file says.
    pub bit_rate_bit_s: Option<u32>,
    /// The file with what it is based on and all overrides, as one TOML text.
    pub text: String,
}

impl RobotFile {
    /// Reads a file, with overrides laid over it. Keys that only a simulation
    /// knows are passed over, so that a scenario will do.
    ///
    /// # Errors
    /// Everything that is wrong with it, with its place.
    pub fn load(path: &str, overrides: &[String]) -> Result<Self, Problems> {
        let mut document = Document::open(path, &[])?;
        for assignment in overrides {
            document.set(assignment)?;
        }
        Self::read(&document, None)
    }

    /// Reads a robot that speaks with drives of this profile, whatever the
    /// document calls it: one from a log, where both are kept as texts.
    ///
    /// # Errors
    /// Everything that is wrong with it, with its place.
    pub fn with_profile(document: &Document, profile: Profile) -> Result<Self, Problems> {
        Self::read(document, Some(profile))
    }

    fn read(document: &Document, profile: Option<Profile>) -> Result<Self, Problems> {
        let reader = Reader::new(document);
        let root = reader.root();
        let robot = root.section("robot");
        let truth = Robot::read(&robot, None);
        let stack = match profile {
            Some(profile) => StackConfig::with_profile(&root, &truth, profile),
            None => StackConfig::read(&root, &truth),
        };
        robot.pass_over("friction");
        let bus = root.section("bus");
        bus.pass_over("link");
        bus.pass_over("data_bitrate_bit_s");
        bus.pass_over("delay_s");
        let bit_rate_bit_s = bus.has("bitrate_bit_s").then(|| read_bit_rate(&bus));
        SIMULATION_ONLY.iter().for_each(|key| root.pass_over(key));
        Ok(Self { stack: reader.finish(stack)?, bit_rate_bit_s, text: document.resolved() })
    }
}

impl StackConfig {
    /// Reads everything but the robot itself, which a scenario has as the
    /// truth. What is wrong is reported to the section's reader.
    pub fn read(root: &Section<'_>, robot: &Robot) -> Self {
        let profile = read_profile(&root.section("drive"));
        Self::of(root, robot, profile)
    }

    /// The same with drives of this profile, whatever `[drive]` calls it.
    pub fn with_profile(root: &Section<'_>, robot: &Robot, profile: Profile) -> Self {
        let drive = root.section("drive");
        drive.pass_over("profile");
        OVERRIDES.iter().for_each(|key| drive.pass_over(key));
        Self::of(root, robot, profile)
    }

    fn of(root: &Section<'_>, robot: &Robot, mut profile: Profile) -> Self {
        let period = read_period(root);
        let section = root.section("drive");
        let drive = DriveConfig::read(&section, &profile);
        let controller = ControllerConfig::read(root, robot, period.as_secs_f64());
        profile.fit(&drive.motor(controller.belief.gear_ratio));
        check_torque_limit(&section, &drive, &profile);
        let grounds = grounds(&drive, &profile, &controller);
        let safety = Limits::read(&root.section("safety"), &grounds);
        Self { period, start: Pose::read(&root.section("start")), controller, drive, profile, safety }
    }
}

/// What limits are made from that are not given.
fn grounds<'p>(drive: &DriveConfig, profile: &'p Profile, controller: &ControllerConfig) -> Grounds<'p> {
    let mass = controller.belief.mass_matrix();
    let by_one = |torque: Wheels<f64>| mass.solve(torque * drive.torque_limit_nm).map(f64::abs);
    let most = by_one(Wheels { right: 1.0, left: 0.0 }) + by_one(Wheels { right: 0.0, left: 1.0 });
    let step_rad =
        |wheel: Wheel| profile.position_scale(wheel).map_or(0.0, |scale| scale.resolution * scale.rad_per_unit);
    Grounds {
        profile_name: &profile.name,
        torque_limit_nm: drive.torque_limit_nm,
        heartbeat_period: profile.heartbeat_period,
        position_step_rad: Wheel::BOTH.map(step_rad).into_iter().fold(0.0, f64::max),
        acceleration_rad_s2: most.right.max(most.left),
        period_s: controller.period_s,
    }
}

/// What `[drive]` may say otherwise than its profile.
const OVERRIDES: [&str; 2] = ["node_ids", "constants"];

/// What a scenario says beside the robot's configuration.
const SIMULATION_ONLY: [&str; 6] = ["base", "duration_s", "event", "expect", "name", "seed"];

impl DriveConfig {
    /// Reads the numbers of a `[drive]` section; what it does not say of the
    /// motors is as in `profile`.
    pub fn read(section: &Section<'_>, profile: &Profile) -> Self {
        let plate = Nameplate::read(section, &profile.plate);
        for key in profile.needs_of_plate().into_iter().filter(|key| plate.get(key).is_none()) {
            section.number(key, Bound::Positive);
        }
        Self {
            plate,
            counts_per_turn: section.integer("counts_per_turn", 1, 1 << 30) as u32,
            torque_limit_nm: section.number("torque_limit_nm", Bound::Within(1e-3, 1e6)),
            current_loop_s: section.number_or("current_loop_s", 0.0, Bound::Within(0.0, 10.0)),
        }
    }

    /// The motors behind a gear of this ratio.
    pub const fn motor(&self, gear_ratio: f64) -> Motor {
        Motor { counts_per_turn: self.counts_per_turn, gear_ratio, plate: self.plate }
    }
}

/// `period_s`: from 10 us, below which no classic bus carries a frame, to 10 s.
fn read_period(root: &Section<'_>) -> Duration {
    Duration::from_secs_f64(root.number("period_s", Bound::Within(1e-5, 10.0)))
}

/// The profile that `[drive]` names, a shipped one or a file, with what the
/// section says otherwise. What is wrong with it is reported, and a shipped one
/// stands in for it.
fn read_profile(section: &Section<'_>) -> Profile {
    let name = section.text("profile");
    let stand_in = || Profile::builtin("wheel_drive").expect("wheel_drive is built in");
    if name.is_empty() {
        OVERRIDES.iter().for_each(|key| section.pass_over(key));
        return stand_in();
    }
    let path = section.path_of("profile", &name);
    let name = if name.ends_with(".toml") { path.display().to_string() } else { name };
    match Profile::load(&name) {
        Ok(profile) => profile.overridden(section),
        Err(problems) => {
            problems.0.into_iter().for_each(|problem| section.report(located(section, problem)));
            OVERRIDES.iter().for_each(|key| section.pass_over(key));
            stand_in()
        }
    }
}

/// The problem itself, if it has a place in the profile or its DBC; else one
/// at the key that names the profile.
fn located(section: &Section<'_>, problem: Problem) -> Problem {
    if problem.place.is_some() {
        return problem;
    }
    let here = section.problem("profile", &problem.title, "named here");
    Problem { help: problem.help, ..here }
}

/// A limit that no command can carry would never be reached.
fn check_torque_limit(section: &Section<'_>, drive: &DriveConfig, profile: &Profile) {
    let most_nm =
        Wheel::BOTH.map(|wheel| profile.command_torque(wheel).maximum_nm).into_iter().fold(f64::NAN, f64::min);
    if drive.torque_limit_nm > most_nm {
        let found = format!("found {}, expected at most {most_nm}, the most that a command", drive.torque_limit_nm);
        section.complain("torque_limit_nm", &format!("{found} of the profile `{}` can carry", profile.name));
    }
}
