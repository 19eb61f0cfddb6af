//! The safety chain: what the stack is doing, what takes the torque away, and
//! the last gate before a torque leaves.
//!
//! ```text
//!             enable      enabled       stop        at rest
//!   Boot -> Stopped -> Enabling -> Running -> Stopping -> Stopped
//!              ^           |          |           |
//!        reset |           +----------+-----------+  a watch finds something
//!              |                      v
//!              +--------------- Tripped(reason)      torque zero, latched
//! ```
//!
//! A trip is latched. Only a reset leaves it, for `Stopped` and never for
//! motion, which takes another enable. Time is counted in the stack's own
//! periods: a loop that was held up trips for that ([`Reason::LoopOverrun`])
//! and does not take its own lateness for a drive's silence.

mod chain;
mod gate;
mod limits;
mod state;
mod watch;

pub use chain::Chain;
pub use limits::{Grounds, Limits};
pub use state::{Operator, Reason, State};
