//! Logging buses as they are.
//!
//! ```text
//! bus -> Hearing (a thread each) -> queue -> Recorder (one thread) -> FrameLog -> file
//! ```
//!
//! Who hears never waits for who writes: what finds no room in the queue is
//! counted, and the log says where it is missing.

mod filter;
mod hearing;
mod recorder;
mod rotation;
mod statistics;

pub use filter::Filter;
pub use hearing::{Heard, Hearing, hear};
pub use recorder::{LoggedTraffic, Recorder};
pub use rotation::Rotation;
pub use statistics::BusStatistics;
