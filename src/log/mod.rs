//! Logs of a run: everything that crossed the buses and everything the stack
//! made of it, in one MCAP file (<https://mcap.dev>) that Foxglove,
//! PlotJuggler, Rerun and the MCAP libraries open as it is.
//!
//! A loop gives its events to a [`McapLog`], which is a queue; a thread of its
//! own encodes, compresses and writes them. The messages go into their chunk
//! in the layout they have in the file: the `mcap` crate's own writer takes
//! several times as long, too long for simulations that run hundreds of times
//! faster than real time.

mod batch;
mod bus;
mod cdr;
mod channels;
mod chunk;
mod chunk_queue;
mod descriptor;
mod exchange;
mod file;
mod filling;
mod frame_log;
mod mcap_log;
mod medium;
mod messages;
mod protobuf;
mod repair;
mod writer;

pub use bus::LoggedFrame;
pub(crate) use cdr::FRAME_NAME;
pub use exchange::exchange_from;
pub use frame_log::FrameLog;
pub use mcap_log::{LogContents, LogError, LogReport, LoggedBus, McapLog, WhenFull};
#[cfg(feature = "foxglove")]
pub(crate) use medium::{Catalogue, Medium};
#[cfg(feature = "foxglove")]
pub(crate) use messages::Messages;
pub(crate) use protobuf::{Value, read_fields};
pub use repair::{Repaired, examine, repair};

/// The topic of the stack's own state.
pub const STACK_TOPIC: &str = "/canloop/stack";

/// The topic of how punctual a loop was.
pub const LOOP_TOPIC: &str = "/canloop/loop";

/// The topic of lines for people.
pub const NOTICES_TOPIC: &str = "/canloop/notices";

/// The topic of what went into the stack and came out of it.
pub const EXCHANGE_TOPIC: &str = "/canloop/exchange";
