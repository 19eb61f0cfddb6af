//! Why a frame has no meaning.

use thiserror::Error;

/// Why a frame is not a message of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum DecodeError {
    /// No message of the profile has this id.
    #[error("no message of the drive has this id")]
    UnknownId,
    /// A remote request carries nothing.
    #[error("a remote request, expected a data frame")]
    RemoteRequest,
    /// Longer or shorter than its message.
    #[error("{found} bytes long, expected {expected}")]
    WrongLength {
        /// Bytes of the frame.
        found: usize,
        /// Bytes of the message.
        expected: usize,
    },
    /// Damaged, or meant for another id.
    #[error("CRC {found:#04X}, expected {expected:#04X}")]
    WrongCrc {
        /// What the frame carries.
        found: u8,
        /// What its id and its bytes make.
        expected: u8,
    },
    /// A floating-point signal without a finite number in it.
    #[error("{role} is not a finite number")]
    NotFinite {
        /// `torque`.
        role: &'static str,
    },
    /// None of the words that this message can say.
    #[error("none of the words that the profile gives this message")]
    UnknownWord,
    /// A number that the value table does not name, or not for the profile.
    #[error("{role} {found}, which the profile does not name")]
    UnknownValue {
        /// `request`, `state` or `fault`.
        role: &'static str,
        /// The raw value.
        found: i64,
    },
}
