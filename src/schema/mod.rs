//! The schema: DBC files, drive profiles, and the codec compiled from them.
//! Nothing outside this module knows a bit position.

mod bits;
mod dbc;
mod dbc_notes;
mod dbc_parser;
mod dbc_syntax;
mod message;
mod signal;
mod statements;

pub use bits::ByteOrder;
pub use dbc::{Dbc, MessageLayout};
pub use message::{Command, DriveState, FaultCode, Feedback, Heartbeat, Message, Request};
pub use signal::{Raw, RawKind, Signal};
