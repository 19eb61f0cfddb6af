//! What the events that are going on make of the robot, all together.

use canloop::robot::{Load, Pose, Robot};
use canloop::wheels::{Wheel, Wheels};

use super::what::What;
use crate::drive::Trouble;
use crate::plant::Friction;
use crate::virtual_robot::VirtualRobot;

/// The robot without events, and what was made of it last.
#[derive(Clone, Debug)]
pub(super) struct Effects {
    load: Load,
    friction: Wheels<Friction>,
    last: Laid,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Laid {
    load: Load,
    friction: Wheels<Friction>,
    force_n: f64,
    moment_nm: f64,
    clock_drift: f64,
    lifted: Wheels<bool>,
    trouble: Wheels<Trouble>,
}

/// m/s^2.
const GRAVITY_M_S2: f64 = 9.806_65;

impl Effects {
    pub fn of(robot: &VirtualRobot) -> Self {
        let (load, friction) = (robot.plant().robot().load, *robot.plant().friction());
        Self { load, friction, last: Laid::nothing(load, friction) }
    }

    /// Lays all that is going on over the robot; each with the encoder counts
    /// at its beginning.
    pub fn lay<'w>(&mut self, going_on: impl Iterator<Item = (&'w What, Wheels<i64>)>, robot: &mut VirtualRobot) {
        let mut laid = Laid::nothing(self.load, self.friction);
        for (what, counts) in going_on {
            laid.add(what, counts, robot);
        }
        let last = std::mem::replace(&mut self.last, laid);
        if laid.load != last.load {
            robot.plant_mut().set_load(laid.load);
        }
        if laid.friction != last.friction {
            robot.plant_mut().set_friction(laid.friction);
        }
        robot.plant_mut().lift(laid.lifted);
        robot.plant_mut().push(laid.force_n, laid.moment_nm);
        robot.set_clock_drift(laid.clock_drift);
        for wheel in Wheel::BOTH.into_iter().filter(|&wheel| laid.trouble[wheel] != last.trouble[wheel]) {
            robot.get_into(wheel, laid.trouble[wheel]);
        }
    }
}

impl Laid {
    fn nothing(load: Load, friction: Wheels<Friction>) -> Self {
        let (lifted, trouble) = (Wheels::default(), Wheels::both(Trouble::NONE));
        Self { load, friction, force_n: 0.0, moment_nm: 0.0, clock_drift: 0.0, lifted, trouble }
    }

    fn add(&mut self, what: &What, counts: Wheels<i64>, robot: &VirtualRobot) {
        let trouble = |wheels: Wheels<bool>, troubles: &mut Wheels<Trouble>, get: &dyn Fn(&mut Trouble, Wheel)| {
            Wheel::BOTH.into_iter().filter(|&wheel| wheels[wheel]).for_each(|wheel| get(&mut troubles[wheel], wheel));
        };
        match *what {
            What::Operator(_) | What::NewPath(_) | What::Bus(_) => {}
            What::DriveFault(..) | What::BrownOut(_) | What::ClockPhase(_) => {}
            What::ClockDrift(drift) => self.clock_drift += drift,
            What::PowerLoss(wheels) => trouble(wheels, &mut self.trouble, &|it, _| it.is_powered = false),
            What::TorqueLimit(wheels, limit_nm) => {
                trouble(wheels, &mut self.trouble, &|it, _| it.torque_limit_nm = it.torque_limit_nm.min(limit_nm));
            }
            What::TorqueSensor(wheels, gain) => {
                trouble(wheels, &mut self.trouble, &|it, _| it.torque_sensor_gain *= gain);
            }
            What::EncoderStuck(wheels) => {
                trouble(wheels, &mut self.trouble, &|it, wheel| it.encoder_stuck_at = Some(counts[wheel]));
            }
            What::EncoderJump(wheels, jump_rad) => trouble(wheels, &mut self.trouble, &|it, wheel| {
                it.encoder_offset_counts += robot.drive(wheel).counts_in(jump_rad);
            }),
            What::EncoderReversed(wheels) => {
                trouble(wheels, &mut self.trouble, &|it, _| it.encoder_is_reversed ^= true);
            }
            What::FeedbackDropout(wheels) => trouble(wheels, &mut self.trouble, &|it, _| it.is_mute = true),
            What::WheelLift(wheels) => self.lifted = self.lifted.zip_with(wheels, |one, other| one || other),
            What::Load(load) => self.load = load,
            What::Friction(wheels, factor, region) => {
                let (body, plant) = (&robot.state().pose, robot.plant().robot());
                for wheel in Wheel::BOTH.into_iter().filter(|&wheel| wheels[wheel]) {
                    let [x_m, y_m] = place_m(wheel, body, plant);
                    if region.is_none_or(|region| region.has(x_m, y_m)) {
                        self.friction[wheel] = times(self.friction[wheel], factor);
                    }
                }
            }
            What::Push { force_n, moment_nm } => self.push(force_n, moment_nm),
            What::Slope { angle_rad, uphill_rad } => {
                let (plant, heading_rad) = (robot.plant().robot(), robot.state().pose.heading_rad);
                self.slope(plant, angle_rad, uphill_rad - heading_rad);
            }
        }
    }

    fn push(&mut self, force_n: f64, moment_nm: f64) {
        self.force_n += force_n;
        self.moment_nm += moment_nm;
    }

    /// Weight pulls downhill at the centre of gravity: ahead of the axle it
    /// turns the robot as well.
    fn slope(&mut self, robot: &Robot, angle_rad: f64, uphill_from_heading_rad: f64) {
        let pull_n = robot.total_mass_kg() * GRAVITY_M_S2 * libm::sin(angle_rad);
        let (ahead, aside) = (-libm::cos(uphill_from_heading_rad), -libm::sin(uphill_from_heading_rad));
        let moment_nm = pull_n * (aside * robot.cog_ahead_m() + ahead * robot.cog_right_m());
        self.push(pull_n * ahead, moment_nm);
    }
}

/// Where a wheel stands, m.
fn place_m(wheel: Wheel, body: &Pose, robot: &Robot) -> [f64; 2] {
    let (sin, cos) = libm::sincos(body.heading_rad);
    let left_m = if wheel == Wheel::Left { robot.half_track_m } else { -robot.half_track_m };
    [body.x_m - left_m * sin, body.y_m + left_m * cos]
}

fn times(friction: Friction, factor: f64) -> Friction {
    Friction {
        viscous_nm_s_per_rad: friction.viscous_nm_s_per_rad * factor,
        static_nm: friction.static_nm * factor,
        coulomb_nm: friction.coulomb_nm * factor,
        ..friction
    }
}
