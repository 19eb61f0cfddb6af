//! What a runtime tells of a run that is over.

use serde::Serialize;

use crate::bus::BusError;
use crate::safety::State;

/// A run on a bus that is over.
#[derive(Debug)]
pub struct Ended {
    /// How it ended.
    pub end: End,
    /// What the stack was doing before it said goodbye.
    pub state: State,
    /// What passed through the bus.
    pub bus: BusCounts,
}

/// How a run on a bus ended.
#[derive(Debug)]
pub enum End {
    /// Somebody here wanted it to.
    Stopped,
    /// Its time was up, or the other side said that it was over.
    Over,
    /// The stack tripped, and has told the drives so.
    Tripped,
    /// The other side was silent for too long.
    Silent,
    /// The bus is gone.
    Lost(BusError),
}

/// Frames that passed between a stack and its bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct BusCounts {
    /// That the bus took.
    pub sent: u64,
    /// That came.
    pub received: u64,
    /// For which the transmit queue had no room at first.
    pub delayed: u64,
    /// That were given up because the queue had no room in their period.
    pub given_up: u64,
    /// That were lost on the way here, for want of room.
    pub lost: u64,
}
