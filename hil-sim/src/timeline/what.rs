//! The kinds of events.

use canloop::path::Path;
use canloop::robot::Load;
use canloop::safety::Operator;
use canloop::schema::FaultCode;
use canloop::time::Duration;
use canloop::wheels::{Wheel, Wheels};

use crate::virtual_robot::VirtualRobot;
use crate::wire::Fault;

/// What happens. `Wheels<bool>` says to which drives.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// The operator wants something.
    Operator(Operator),
    /// The operator wants the robot to follow another path.
    NewPath(Path),
    /// Something is wrong with the bus.
    Bus(Fault),
    /// No power; when it is back, the drive boots.
    PowerLoss(Wheels<bool>),
    /// The drive raises a fault of its own.
    DriveFault(Wheels<bool>, FaultCode),
    /// The drive gives this torque at most, N m.
    TorqueLimit(Wheels<bool>, f64),
    /// The drive reports so many N m of torque for each that it applies.
    TorqueSensor(Wheels<bool>, f64),
    /// The encoder stays where it is.
    EncoderStuck(Wheels<bool>),
    /// The encoder jumps by this angle of the wheel, rad.
    EncoderJump(Wheels<bool>, f64),
    /// The encoder counts the wrong way.
    EncoderReversed(Wheels<bool>),
    /// The supply breaks down while both drives together give more torque, N m.
    BrownOut(f64),
    /// The drives' own clocks run so many times too slow.
    ClockDrift(f64),
    /// What the drives do by their own clocks comes so much later, s.
    ClockPhase(f64),
    /// Feedback stays out.
    FeedbackDropout(Wheels<bool>),
    /// Wheels off the floor.
    WheelLift(Wheels<bool>),
    /// Another load.
    Load(Load),
    /// Friction is so many times what it is, everywhere or in a region.
    Friction(Wheels<bool>, f64, Option<Region>),
    /// A push: a force along the heading, N, and a moment counter-clockwise, N m.
    Push {
        /// N.
        force_n: f64,
        /// N m.
        moment_nm: f64,
    },
    /// A slope.
    Slope {
        /// How steep, rad.
        angle_rad: f64,
        /// Where it goes up, rad from the x axis.
        uphill_rad: f64,
    },
}

/// A round patch of floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Its centre, m.
    pub center_m: [f64; 2],
    /// m.
    pub radius_m: f64,
}

impl What {
    /// What it does to the bus while it goes on, if it does.
    pub const fn bus_fault(&self) -> Option<Fault> {
        match *self {
            Self::Bus(fault) => Some(fault),
            _ => None,
        }
    }

    /// What happens once, when it begins.
    pub(super) fn begin(&self, robot: &mut VirtualRobot) {
        match *self {
            Self::DriveFault(wheels, fault) => {
                Wheel::BOTH
                    .into_iter()
                    .filter(|&wheel| wheels[wheel])
                    .for_each(|wheel| robot.raise_fault(wheel, fault));
            }
            Self::ClockPhase(by_s) => robot.set_back_clock(Duration::from_secs_f64(by_s)),
            _ => {}
        }
    }

    /// What happens whenever it has come to that while it goes on.
    pub(super) fn strike(&self, robot: &mut VirtualRobot) {
        if let Self::BrownOut(most_nm) = *self {
            let Wheels { right, left } = robot.torque_applied_nm().map(f64::abs);
            if right + left > most_nm {
                Wheel::BOTH.into_iter().for_each(|wheel| robot.raise_fault(wheel, FaultCode::UnderVoltage));
            }
        }
    }
}

impl Region {
    /// Whether a place in the plane, m, is in it.
    pub fn has(&self, x_m: f64, y_m: f64) -> bool {
        libm::hypot(x_m - self.center_m[0], y_m - self.center_m[1]) <= self.radius_m
    }
}
