//! What goes into a stack and comes out of it, in order: all that it takes to
//! let the same happen again.
//!
//! A [`crate::stack::Stack`] that was told to tells of it in its events. A log
//! keeps them, and [`crate::replay`] gives them to another stack.

use crate::frame::Frame;
use crate::safety::{Operator, Reason};
use crate::time::Instant;

/// One thing that went in or came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exchange {
    /// The stack was made, to wake up first at this moment.
    Begin(Instant),
    /// A frame that was arrived at this moment went in.
    Frame(Instant, Frame),
    /// This moment had come.
    Wakeup(Instant),
    /// The operator wanted something.
    Operate(Operator),
    /// The operator wanted the path of this event of the scenario followed.
    Follow(u16),
    /// Something outside went wrong.
    Trip(Reason),
    /// The stack was to say goodbye.
    Farewell,
    /// This frame came out.
    Sent(Frame),
}

impl Exchange {
    /// A word for logs.
    pub const fn word(&self) -> &'static str {
        match self {
            Self::Begin(_) => "begin",
            Self::Frame(..) => "frame",
            Self::Wakeup(_) => "wakeup",
            Self::Operate(_) => "operate",
            Self::Follow(_) => "follow",
            Self::Trip(_) => "trip",
            Self::Farewell => "farewell",
            Self::Sent(_) => "sent",
        }
    }
}
