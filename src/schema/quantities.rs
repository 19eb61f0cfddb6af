//! The quantities that messages carry, each in one signal.

use super::conversation::StateId;
use super::decode_error::DecodeError;
use super::encoding::Rounding;
use super::message::{DriveState, FaultCode};
use super::pattern::Pattern;
use super::signal::{Raw, Signal};
use super::units::{Motor, PositionUnit, Side, SpeedUnit, TorqueUnit};

/// The torques that a signal can express.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TorqueScale {
    /// Distance between neighbours, N m.
    pub resolution_nm: f64,
    /// Least, N m.
    pub minimum_nm: f64,
    /// Greatest, N m.
    pub maximum_nm: f64,
}

/// How a position signal counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PositionScale {
    /// What the wheel turns for one unit, rad.
    pub rad_per_unit: f64,
    /// After how many units it begins anew; `None` is never.
    pub wraps_at: Option<f64>,
    /// Units between neighbours; 0 for a floating-point signal.
    pub resolution: f64,
}

/// A torque and the range that it is kept in.
#[derive(Clone, Debug)]
pub(super) struct Torque {
    pub signal: Signal,
    pub unit: TorqueUnit,
    pub side: Side,
    pub rounding: Rounding,
    pub nm_per_unit: f64,
    pub scale: TorqueScale,
}

/// A position.
#[derive(Clone, Debug)]
pub(super) struct Position {
    pub signal: Signal,
    pub unit: PositionUnit,
    pub side: Side,
    pub units_per_count: f64,
    /// Whether it is the encoder's count itself.
    pub is_count: bool,
    pub scale: PositionScale,
}

/// A speed.
#[derive(Clone, Debug)]
pub(super) struct Speed {
    pub signal: Signal,
    pub unit: SpeedUnit,
    pub side: Side,
    pub rounding: Rounding,
    pub rad_s_per_unit: f64,
}

/// The drive's state.
#[derive(Clone, Debug)]
pub(super) struct StateField {
    pub signal: Signal,
    /// How each of the profile's states shows, those of them that do.
    pub shows: Vec<(StateId, DriveState, Pattern)>,
    /// What stands there in all other states.
    pub elsewhere: Option<Pattern>,
}

/// A fault.
#[derive(Clone, Debug)]
pub(super) struct FaultField {
    pub signal: Signal,
    /// The first that fits counts.
    pub faults: Vec<(FaultCode, Pattern)>,
    /// Whether the state stands in the same signal.
    pub shares_state: bool,
}

impl Torque {
    /// The same for this motor.
    pub fn fit(&mut self, motor: &Motor) {
        self.nm_per_unit = motor.torque_nm(self.unit, self.side);
        self.scale = scale(&self.signal, self.nm_per_unit);
    }

    #[inline]
    pub fn encode(&self, data: &mut [u8], torque_nm: f64) {
        let torque_nm = if torque_nm.is_nan() { 0.0 } else { torque_nm };
        let kept_nm = torque_nm.clamp(self.scale.minimum_nm, self.scale.maximum_nm);
        encode_rounded(&self.signal, self.rounding, data, kept_nm / self.nm_per_unit);
    }

    #[inline]
    pub fn decode(&self, data: &[u8; 64]) -> Result<f64, DecodeError> {
        let torque_nm = self.signal.decode(data) * self.nm_per_unit;
        if torque_nm.is_finite() { Ok(torque_nm) } else { Err(DecodeError::NotFinite { role: "torque" }) }
    }
}

/// What the bits of `signal` can express, kept to the range that the DBC
/// gives where it gives one.
fn scale(signal: &Signal, nm_per_unit: f64) -> TorqueScale {
    let end = |beyond: f64| {
        let mut data = [0; 64];
        signal.encode(&mut data, beyond);
        signal.decode(&data)
    };
    let (mut minimum, mut maximum) = (end(f64::MIN), end(f64::MAX));
    if signal.minimum < signal.maximum {
        minimum = minimum.max(signal.minimum);
        maximum = maximum.min(signal.maximum);
    }
    let resolution = if signal.is_float() { 0.0 } else { signal.factor.abs() };
    TorqueScale {
        resolution_nm: resolution * nm_per_unit,
        minimum_nm: minimum * nm_per_unit,
        maximum_nm: maximum * nm_per_unit,
    }
}

impl Position {
    /// The same for this motor.
    pub fn fit(&mut self, motor: &Motor) {
        self.units_per_count = motor.positions_per_count(self.unit, self.side);
        let signal = &self.signal;
        let is_whole = !signal.is_float();
        self.is_count = signal.is_integer() && self.units_per_count == 1.0;
        let step = if is_whole { signal.factor.abs() } else { 0.0 };
        self.scale = PositionScale {
            rad_per_unit: motor.position_rad(self.unit, self.side),
            wraps_at: is_whole.then(|| step * (1_u64 << signal.bit_count()) as f64),
            resolution: step,
        };
    }

    /// A whole-number signal holds the step that has been reached, wrapped at
    /// its width.
    #[inline]
    pub fn encode(&self, data: &mut [u8], position: f64) {
        if self.is_count {
            self.signal.encode_bits(data, position as i64 as u64);
        } else if self.signal.is_float() {
            self.signal.encode(data, position);
        } else {
            let steps = ((position - self.signal.offset) / self.signal.factor).floor();
            self.signal.encode_bits(data, steps as i64 as u64);
        }
    }

    #[inline]
    pub fn decode(&self, data: &[u8; 64]) -> Result<f64, DecodeError> {
        let position = self.signal.decode(data);
        if position.is_finite() { Ok(position) } else { Err(DecodeError::NotFinite { role: "position" }) }
    }
}

impl Speed {
    /// The same for this motor.
    pub fn fit(&mut self, motor: &Motor) {
        self.rad_s_per_unit = motor.speed_rad_s(self.unit, self.side);
    }

    pub fn encode(&self, data: &mut [u8], speed_rad_s: f64) {
        encode_rounded(&self.signal, self.rounding, data, speed_rad_s / self.rad_s_per_unit);
    }

    pub fn decode(&self, data: &[u8; 64]) -> Result<f64, DecodeError> {
        let speed_rad_s = self.signal.decode(data) * self.rad_s_per_unit;
        if speed_rad_s.is_finite() { Ok(speed_rad_s) } else { Err(DecodeError::NotFinite { role: "speed" }) }
    }

    /// The distance between neighbours, rad/s; 0 for a floating-point signal.
    pub fn resolution_rad_s(&self) -> f64 {
        if self.signal.is_float() { 0.0 } else { self.signal.factor.abs() * self.rad_s_per_unit }
    }
}

/// Writes a number; what is beyond the signal's bits becomes the nearest that
/// they hold.
#[inline]
fn encode_rounded(signal: &Signal, rounding: Rounding, data: &mut [u8], physical: f64) {
    match rounding {
        Rounding::TowardsZero if !signal.is_float() => {
            let raw = (physical - signal.offset) / signal.factor;
            signal.encode_raw(data, Raw::Real(raw.trunc()));
        }
        _ => signal.encode(data, physical),
    }
}

impl StateField {
    #[inline]
    pub fn encode(&self, data: &mut [u8; 64], state: Option<StateId>) {
        let shown = self.shows.iter().find(|(known, ..)| Some(*known) == state);
        if let Some(pattern) = shown.map(|(.., pattern)| pattern).or(self.elsewhere.as_ref()) {
            pattern.write(&self.signal, data);
        }
    }

    /// The state that the bits show. Where several show the same, a fault
    /// that stands beside them tells which.
    #[inline]
    pub fn decode(&self, data: &[u8; 64], fault: Option<FaultCode>) -> Result<Option<StateId>, DecodeError> {
        let bits = self.signal.decode_bits(data);
        let mut fitting = self.shows.iter().filter(|(.., pattern)| pattern.fits(bits));
        let first = fitting.next();
        let is_faulty = fault.is_some_and(|fault| fault != FaultCode::None);
        let matches = |(_, means, _): &&(StateId, DriveState, Pattern)| (*means == DriveState::Fault) == is_faulty;
        match first {
            Some(first) if fault.is_none() || matches(&first) => Ok(Some(first.0)),
            Some(first) => Ok(Some(fitting.find(matches).unwrap_or(first).0)),
            None if self.elsewhere.as_ref().is_some_and(|pattern| pattern.fits(bits)) => Ok(None),
            None => Err(unknown("state", &self.signal, data)),
        }
    }
}

impl FaultField {
    #[inline]
    pub fn encode(&self, data: &mut [u8; 64], fault: FaultCode) {
        let known = self.faults.iter().find(|(known, _)| *known == fault);
        // A fault that the drive has no number for shows as one that it has.
        if let Some((_, pattern)) = known.or(self.faults.last()) {
            pattern.write(&self.signal, data);
        }
    }

    /// The fault that the bits show; what the profile does not name is a
    /// fault all the same.
    #[inline]
    pub fn decode(&self, data: &[u8; 64]) -> FaultCode {
        let bits = self.signal.decode_bits(data);
        let known = self.faults.iter().find(|(_, pattern)| pattern.fits(bits));
        known.map_or(FaultCode::Other, |&(fault, _)| fault)
    }
}

/// The complaint that the raw value of a signal means nothing.
pub(super) fn unknown(role: &'static str, signal: &Signal, data: &[u8; 64]) -> DecodeError {
    let found = match signal.decode_raw(data) {
        Raw::Unsigned(raw) => raw as i64,
        Raw::Signed(raw) => raw,
        Raw::Real(raw) => raw as i64,
    };
    DecodeError::UnknownValue { role, found }
}
