//! Runtimes: what holds the stack's hands. Small, and the only places that
//! read a clock or wait.

mod clock;
#[cfg(target_os = "linux")]
pub mod doctor;
mod ended;
mod lockstep;
mod outlet;
mod priority;
mod punctuality;
mod realtime;
mod stop_switch;
mod tap;

pub use clock::{Clock, RealtimeStamps};
pub use ended::{BusCounts, End, Ended};
pub use lockstep::LockStep;
pub use priority::{DEGRADED, Degraded, raise};
pub use punctuality::{LoopFigures, Punctuality, Spread};
pub use realtime::RealTime;
pub use stop_switch::{StopSwitch, StopWish};
pub use tap::{Drain, Tap, tap};
