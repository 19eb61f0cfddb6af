//! What drives and stack say to each other, apart from how a bus lays it out.

use crate::wheels::Wheel;

/// One frame's meaning.
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
    /// Torque at the wheel for the period that begins with the next SYNC, N m.
    pub torque_nm: f64,
    /// What state the drive should be in.
    pub request: Request,
    /// Counts commands and wraps at the signal's width.
    pub counter: u8,
}

/// The state that the stack wants a drive to be in.
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

/// What a drive reports of the period that has just ended.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Feedback {
    /// Encoder position latched at SYNC, in counts at the motor shaft; wraps
    /// at 32 bits.
    pub position_counts: i32,
    /// Mean torque at the wheel that was really applied in the period that
    /// ended with this SYNC, N m.
    pub torque_applied_nm: f64,
    /// The drive's state.
    pub state: DriveState,
    /// The low bits of the counter of the SYNC that this answers, as many as
    /// the signal has.
    pub counter: u8,
}

/// A sign of life.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Heartbeat {
    /// The drive's state.
    pub state: DriveState,
    /// The fault that holds it in the fault state, if one does.
    pub fault: FaultCode,
}

/// State machine of a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DriveState {
    /// Starting up; takes no command.
    #[default]
    Boot,
    /// Power stage off.
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
    /// Supply too low.
    UnderVoltage,
    /// Encoder lost.
    Encoder,
}
