//! The schema: DBC files, drive profiles, and the codec compiled from them.
//! Nothing outside this module knows a bit position.

mod bits;
mod checksum;
mod dbc;
mod dbc_notes;
mod dbc_parser;
mod dbc_syntax;
mod decode_error;
mod linker;
mod markdown;
mod message;
mod profile;
mod profile_reader;
mod roles;
mod signal;
mod statements;
mod step_end;
mod value_names;

pub use bits::ByteOrder;
pub use checksum::Crc8;
pub use dbc::{Dbc, MessageLayout};
pub use decode_error::DecodeError;
pub use message::{Command, DriveState, FaultCode, Feedback, Heartbeat, Message, Request};
pub use profile::Profile;
pub use roles::TorqueScale;
pub use signal::{Raw, RawKind, Signal};
pub use step_end::{StepEnd, StepEndCodec};
