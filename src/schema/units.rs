//! From what a drive measures and is told, in its own units and on its own
//! side of the gear, to what happens at the wheel.

use crate::config::{Bound, Section};

const TURN_RAD: f64 = 2.0 * std::f64::consts::PI;

/// What must be known of motor, encoder and gear to read a drive's numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// Encoder counts a turn of the motor shaft.
    pub counts_per_turn: u32,
    /// Motor turns per wheel turn.
    pub gear_ratio: f64,
    /// The numbers of its nameplate.
    pub plate: Nameplate,
}

/// What is known of a motor beside its encoder; `None` where a profile's units
/// need none of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Nameplate {
    /// Torque at the shaft for one ampere, N m/A.
    pub torque_constant_nm_per_a: Option<f64>,
    /// Rated torque at the shaft, N m.
    pub rated_torque_nm: Option<f64>,
    /// Torque at the shaft for one step of a unit that the drive does not say, N m.
    pub torque_per_unit_nm: Option<f64>,
    /// Electrical turns per turn of the shaft.
    pub pole_pairs: Option<f64>,
}

/// Side of the gear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Motor,
    Wheel,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TorqueUnit {
    NewtonMeters,
    Amperes,
    PerMilleOfRated,
    DriveUnits,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PositionUnit {
    Counts,
    Turns,
    Radians,
    Degrees,
    ElectricalTurns,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SpeedUnit {
    CountsPerSecond,
    TurnsPerSecond,
    RadiansPerSecond,
    TurnsPerMinute,
    ElectricalTurnsPerMinute,
}

pub(super) const SIDES: [(&str, Side); 2] = [("wheel", Side::Wheel), ("motor", Side::Motor)];

pub(super) const TORQUE_UNITS: [(&str, TorqueUnit); 4] = [
    ("N m", TorqueUnit::NewtonMeters),
    ("A", TorqueUnit::Amperes),
    ("per mille of rated", TorqueUnit::PerMilleOfRated),
    ("drive unit", TorqueUnit::DriveUnits),
];

pub(super) const POSITION_UNITS: [(&str, PositionUnit); 5] = [
    ("counts", PositionUnit::Counts),
    ("turns", PositionUnit::Turns),
    ("rad", PositionUnit::Radians),
    ("deg", PositionUnit::Degrees),
    ("electrical turns", PositionUnit::ElectricalTurns),
];

pub(super) const SPEED_UNITS: [(&str, SpeedUnit); 5] = [
    ("counts/s", SpeedUnit::CountsPerSecond),
    ("turns/s", SpeedUnit::TurnsPerSecond),
    ("rad/s", SpeedUnit::RadiansPerSecond),
    ("rpm", SpeedUnit::TurnsPerMinute),
    ("erpm", SpeedUnit::ElectricalTurnsPerMinute),
];

impl Nameplate {
    /// Reads what a section says of the motor; what it leaves out is as in
    /// `fallback`.
    pub fn read(section: &Section<'_>, fallback: &Self) -> Self {
        let number = |key, other: Option<f64>| section.number_or_none(key, Bound::Within(1e-9, 1e6)).or(other);
        Self {
            torque_constant_nm_per_a: number("torque_constant_nm_per_a", fallback.torque_constant_nm_per_a),
            rated_torque_nm: number("rated_torque_nm", fallback.rated_torque_nm),
            torque_per_unit_nm: number("torque_per_unit_nm", fallback.torque_per_unit_nm),
            pole_pairs: number("pole_pairs", fallback.pole_pairs),
        }
    }

    /// The number under a key.
    pub fn get(&self, key: &str) -> Option<f64> {
        match key {
            "torque_constant_nm_per_a" => self.torque_constant_nm_per_a,
            "rated_torque_nm" => self.rated_torque_nm,
            "torque_per_unit_nm" => self.torque_per_unit_nm,
            "pole_pairs" => self.pole_pairs,
            _ => None,
        }
    }
}

impl Motor {
    /// N m at the wheel for one unit.
    pub(super) fn torque_nm(&self, unit: TorqueUnit, side: Side) -> f64 {
        let plate = &self.plate;
        let nm = match unit {
            TorqueUnit::NewtonMeters => 1.0,
            TorqueUnit::Amperes => known(plate.torque_constant_nm_per_a),
            TorqueUnit::PerMilleOfRated => known(plate.rated_torque_nm) / 1000.0,
            TorqueUnit::DriveUnits => known(plate.torque_per_unit_nm),
        };
        nm * self.gear(side)
    }

    /// Rad at the wheel for one unit.
    pub(super) fn position_rad(&self, unit: PositionUnit, side: Side) -> f64 {
        TURN_RAD / (self.positions_per_turn(unit) * self.gear(side))
    }

    /// Units for one encoder count.
    pub(super) fn positions_per_count(&self, unit: PositionUnit, side: Side) -> f64 {
        let at_motor = self.positions_per_turn(unit) / f64::from(self.counts_per_turn);
        if side == Side::Motor { at_motor } else { at_motor / self.gear_ratio }
    }

    /// Rad/s at the wheel for one unit.
    pub(super) fn speed_rad_s(&self, unit: SpeedUnit, side: Side) -> f64 {
        let per_turn_a_second = match unit {
            SpeedUnit::CountsPerSecond => f64::from(self.counts_per_turn),
            SpeedUnit::TurnsPerSecond => 1.0,
            SpeedUnit::RadiansPerSecond => TURN_RAD,
            SpeedUnit::TurnsPerMinute => 60.0,
            SpeedUnit::ElectricalTurnsPerMinute => 60.0 * known(self.plate.pole_pairs),
        };
        TURN_RAD / (per_turn_a_second * self.gear(side))
    }

    fn positions_per_turn(&self, unit: PositionUnit) -> f64 {
        match unit {
            PositionUnit::Counts => f64::from(self.counts_per_turn),
            PositionUnit::Turns => 1.0,
            PositionUnit::Radians => TURN_RAD,
            PositionUnit::Degrees => 360.0,
            PositionUnit::ElectricalTurns => known(self.plate.pole_pairs),
        }
    }

    /// What turns a speed at this side into one at the motor.
    const fn gear(&self, side: Side) -> f64 {
        match side {
            Side::Motor => self.gear_ratio,
            Side::Wheel => 1.0,
        }
    }
}

impl TorqueUnit {
    /// The key of the nameplate without which it means nothing.
    pub const fn needs(self) -> Option<&'static str> {
        match self {
            Self::NewtonMeters => None,
            Self::Amperes => Some("torque_constant_nm_per_a"),
            Self::PerMilleOfRated => Some("rated_torque_nm"),
            Self::DriveUnits => Some("torque_per_unit_nm"),
        }
    }
}

impl PositionUnit {
    /// The key of the nameplate without which it means nothing.
    pub fn needs(self) -> Option<&'static str> {
        (self == Self::ElectricalTurns).then_some("pole_pairs")
    }
}

impl SpeedUnit {
    /// The key of the nameplate without which it means nothing.
    pub fn needs(self) -> Option<&'static str> {
        (self == Self::ElectricalTurnsPerMinute).then_some("pole_pairs")
    }
}

/// Until a robot says otherwise, 1: a profile is read before the robot is known.
fn known(number: Option<f64>) -> f64 {
    number.unwrap_or(1.0)
}
