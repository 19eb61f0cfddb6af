//! The schema: DBC files, drive profiles, and the codec compiled from them.
//! Nothing outside this module knows a bit position.

mod addressing;
mod bits;
mod checksum;
mod codec;
mod conversation;
mod conversation_reader;
mod dbc;
mod decode_error;
mod encoding;
mod envelope;
mod linker;
mod markdown;
mod message;
mod pattern;
mod profile;
mod quantities;
mod role_signals;
mod role_table;
mod roles;
mod signal;
mod slot;
mod step_end;
mod units;

pub use bits::ByteOrder;
pub use checksum::Crc8;
pub use codec::Absence;
pub use conversation::{Conversation, Patience, StateId, Watchdog, WordId};
pub use dbc::{Dbc, MessageLayout};
pub use decode_error::DecodeError;
pub use encoding::{EncodeError, Encoding, OutOfRange, Rounding, Value, Within};
pub use message::{Command, DriveState, FaultCode, Feedback, Heartbeat, Message, Request};
pub use profile::{Acts, Applied, Asks, Cause, Profile, Recurring};
pub use quantities::{PositionScale, TorqueScale};
pub use signal::{Raw, RawKind, Selector, Signal};
pub use step_end::{StepEnd, StepEndCodec};
pub use units::{Motor, Nameplate};
