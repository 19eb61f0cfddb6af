//! The schema: DBC files, drive profiles, and the codec compiled from them.
//! Nothing outside this module knows a bit position.

mod message;

pub use message::{Command, DriveState, FaultCode, Feedback, Heartbeat, Message, Request};
