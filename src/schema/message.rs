//! What drives and stack say to each other, apart from how a bus lays it out.

use super::conversation::{StateId, WordId};
use crate::wheels::Wheel;

/// One frame's meaning for one wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Message {
    /// Starts a period: drives latch their encoders and put the torque they
    /// were sent before into force.
    Sync {
        /// Counts periods and wraps at the signal's width.
        counter: u8,
    },
    /// From the stack to a drive.
    Command(Wheel, Command),
    /// From the stack to a drive: a remote request for a part of its feedback.
    Poll(Wheel, u8),
    /// From the stack to a drive: a word that has a message of its own.
    Word(Wheel, WordId),
    /// From a drive, once a period.
    Feedback(Wheel, Feedback),
    /// From a drive, at its own slow rate, synchronised or not.
    Heartbeat(Wheel, Heartbeat),
    /// From a drive, at the moment a fault is raised.
    Fault(Wheel, FaultCode),
}

/// What the stack asks of a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Command {
    /// Torque at the wheel, N m.
    pub torque_nm: f64,
    /// What else the command says, where a command has room for words.
    pub word: Option<WordId>,
    /// Counts commands and wraps at the signal's width; 0 without a counter.
    pub counter: u8,
}

/// What the stack wants of a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Request {
    /// No torque.
    #[default]
    Disable,
    /// Torque as commanded.
    Enable,
    /// Leave the fault state, to `Ready`; never to `Enabled`.
    ClearFault,
}

/// What one feedback message says; `None` is what it does not carry.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Feedback {
    /// Which of the profile's feedback messages, from 0.
    pub part: u8,
    /// Position in the unit of its signal, which wraps with it.
    pub position: Option<f64>,
    /// Speed of the wheel, rad/s.
    pub speed_rad_s: Option<f64>,
    /// Torque at the wheel that was really applied, N m.
    pub torque_applied_nm: Option<f64>,
    /// The drive's state.
    pub state: Option<StateId>,
    /// The fault that holds it in the fault state, if one does.
    pub fault: Option<FaultCode>,
    /// The mode of operation that the drive is in, as its maker numbers them.
    pub mode: Option<f64>,
    /// The low bits of the counter of the SYNC that this answers, or the
    /// drive's own count.
    pub counter: Option<u8>,
}

/// A sign of life.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Heartbeat {
    /// The drive's state, unless it is told elsewhere.
    pub state: Option<StateId>,
    /// The fault that holds it in the fault state, if one does.
    pub fault: FaultCode,
}

/// What a drive's own state means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DriveState {
    /// Starting up; takes no command.
    #[default]
    Boot,
    /// Power stage off, or on without torque.
    Ready,
    /// Power stage on, torque follows the command.
    Enabled,
    /// Power stage off until the fault is cleared.
    Fault,
}

/// Why a drive is in its fault state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FaultCode {
    /// No fault.
    #[default]
    None,
    /// No valid command for longer than the watchdog allows.
    CommandTimeout,
    /// A command whose CRC or counter was wrong.
    CommandCorrupt,
    /// Current above the power stage's limit.
    OverCurrent,
    /// Power stage too hot.
    OverTemperature,
    /// Motor too hot.
    MotorOverTemperature,
    /// Supply too low.
    UnderVoltage,
    /// Supply too high.
    OverVoltage,
    /// More load than the motor stands.
    Overload,
    /// Encoder lost.
    Encoder,
    /// Somebody asked for an emergency stop.
    EmergencyStop,
    /// One that the profile does not name.
    Other,
}
