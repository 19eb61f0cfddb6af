//! The keys of a profile's roles, and the words that stand for something.

use super::{Acts, Applied, Asks};
use crate::schema::encoding::Rounding;
use crate::schema::message::FaultCode;

pub(in crate::schema) const FAULTS: [(&str, FaultCode); 12] = [
    ("none", FaultCode::None),
    ("command_timeout", FaultCode::CommandTimeout),
    ("command_corrupt", FaultCode::CommandCorrupt),
    ("over_current", FaultCode::OverCurrent),
    ("over_temperature", FaultCode::OverTemperature),
    ("motor_over_temperature", FaultCode::MotorOverTemperature),
    ("under_voltage", FaultCode::UnderVoltage),
    ("over_voltage", FaultCode::OverVoltage),
    ("overload", FaultCode::Overload),
    ("encoder", FaultCode::Encoder),
    ("emergency_stop", FaultCode::EmergencyStop),
    ("other", FaultCode::Other),
];

pub(in crate::schema) const ASKS: [(&str, Asks); 4] =
    [("sync", Asks::BySync), ("poll", Asks::ByPoll), ("command", Asks::ByCommand), ("nothing", Asks::Nothing)];

pub(in crate::schema) const ACTS: [(&str, Acts); 2] = [("at sync", Acts::AtSync), ("on arrival", Acts::OnArrival)];

pub(in crate::schema) const APPLIED: [(&str, Applied); 3] =
    [("the last", Applied::TheLast), ("the mean", Applied::TheMean), ("coarse", Applied::Coarse)];

pub(in crate::schema) const ROUNDINGS: [(&str, Rounding); 2] =
    [("nearest", Rounding::Nearest), ("truncate", Rounding::TowardsZero)];

pub(in crate::schema) const SYNC_KEYS: [&str; 3] = ["message", "counter", "crc"];
pub(in crate::schema) const COMMAND_KEYS: [&str; 11] = [
    "shortest",
    "remainder",
    "message",
    "acts",
    "torque",
    "torque_unit",
    "torque_at",
    "constants",
    "mode",
    "counter",
    "crc",
];
pub(in crate::schema) const FEEDBACK_KEYS: [&str; 19] = [
    "message",
    "shortest",
    "constants",
    "position",
    "position_unit",
    "position_at",
    "speed",
    "speed_unit",
    "speed_at",
    "torque_applied",
    "torque_applied_unit",
    "torque_applied_at",
    "torque_applied_is",
    "state",
    "shown_as",
    "fault",
    "mode",
    "counter",
    "crc",
];
pub(in crate::schema) const HEARTBEAT_KEYS: [&str; 6] =
    ["message", "state", "shown_as", "state_elsewhere", "fault", "crc"];
pub(in crate::schema) const FAULT_KEYS: [&str; 3] = ["message", "fault", "crc"];
