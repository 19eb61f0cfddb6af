//! The outside: buses, and how long a frame occupies one.
//!
//! A runtime sends and receives through [`Bus`]; what stands behind it is a
//! kernel socket, a network connection, or another bus wrapped in something.
//! Nothing branches on the kind of bus.

mod address;
mod bit_rates;
#[cfg(target_os = "linux")]
mod can_link;
mod frame_bits;
#[cfg(target_os = "linux")]
mod socketcan;
pub mod socketcand;
mod worst_case;

use std::fmt;

pub use address::{Address, OpenOptions, USUAL_BIT_RATE_BIT_S, bus_name, open, read_bit_rate};
pub use bit_rates::BitRates;
#[cfg(target_os = "linux")]
pub use can_link::{CanLink, LinkError};
pub use frame_bits::{data_phase_bits, frame_bits};
#[cfg(target_os = "linux")]
pub use socketcan::{SocketCan, SocketCanCounts};
pub use socketcand::Socketcand;
pub use worst_case::worst_case_frame_bits;

use crate::frame::Frame;
use crate::time::Instant;
use crate::traffic::{Content, Direction};

/// A CAN bus that a runtime drives. All moments are those of
/// [`crate::run::Clock`].
pub trait Bus {
    /// Hands a frame to the bus, without waiting.
    ///
    /// # Errors
    /// [`BusError::Full`] when the transmit queue has no room: try again after
    /// the next [`Self::receive`]. Anything else is for good until
    /// [`Arrival::Up`].
    fn send(&mut self, frame: &Frame) -> Result<(), BusError>;

    /// Waits for what the bus brings, until `deadline` at the latest; nothing
    /// comes back then. A deadline that has passed only looks.
    fn receive(&mut self, deadline: Instant) -> Result<Option<(Instant, Arrival)>, BusError>;
}

/// What a bus brings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrival {
    /// A frame that somebody else sent; the moment is that of its reception.
    Frame(Frame),
    /// Whatever was on the bus, with all that is known of it: on a bus that was
    /// opened to listen ([`OpenOptions::listens`]), in place of frames.
    Heard(Direction, Content),
    /// This many frames were lost on the way to us, for want of room.
    Lost(u32),
    /// The controller's state changed.
    State(ControllerState),
    /// The interface went down or away.
    Down,
    /// The interface is back and frames flow again.
    Up,
}

/// The error state of a CAN controller (ISO 11898-1, 12.1.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ControllerState {
    /// Takes part in error signalling.
    #[default]
    ErrorActive,
    /// An error counter is above 96.
    ErrorWarning,
    /// An error counter is above 127: most likely nobody acknowledges.
    ErrorPassive,
    /// Off the bus: the transmit error counter passed 255.
    BusOff,
}

impl ControllerState {
    /// A word for logs.
    pub const fn word(self) -> &'static str {
        match self {
            Self::ErrorActive => "error_active",
            Self::ErrorWarning => "error_warning",
            Self::ErrorPassive => "error_passive",
            Self::BusOff => "bus_off",
        }
    }
}

/// Why a bus did not do what it was asked.
#[derive(Debug)]
pub enum BusError {
    /// The transmit queue has no room.
    Full,
    /// The interface is down or gone; it may come back.
    Down,
    /// The bus is gone for good: what it was, and what the system said.
    Gone(String, std::io::Error),
}

impl fmt::Display for BusError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full => write!(out, "the transmit queue is full"),
            Self::Down => write!(out, "the interface is down"),
            Self::Gone(bus, error) => write!(out, "{bus} is gone: {error}"),
        }
    }
}

impl std::error::Error for BusError {}
