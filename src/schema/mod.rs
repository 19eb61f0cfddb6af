//! The schema: DBC files, drive profiles, and the codec compiled from them.
//! Nothing outside this module knows a bit position.

mod bits;
mod checksum;
mod codec;
mod dbc;
mod decode_error;
mod encoding;
mod linker;
mod markdown;
mod message;
mod profile;
mod profile_check;
mod profile_reader;
mod roles;
mod signal;
mod slot;
mod step_end;
mod value_names;

pub use bits::ByteOrder;
pub use checksum::Crc8;
pub use codec::Absence;
pub use dbc::{Dbc, MessageLayout};
pub use decode_error::DecodeError;
pub use encoding::{EncodeError, Encoding, OutOfRange, Rounding, Value, Within};
pub use message::{Command, DriveState, FaultCode, Feedback, Heartbeat, Message, Request};
pub use profile::Profile;
pub use roles::TorqueScale;
pub use signal::{Raw, RawKind, Selector, Signal};
pub use step_end::{StepEnd, StepEndCodec};
