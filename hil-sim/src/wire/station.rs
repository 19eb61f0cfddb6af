//! A node as the wire keeps it: its transmit queue, its error counters, and
//! what becomes of it off the bus.

use canloop::bus::ControllerState;
use canloop::fifo::Fifo;
use canloop::frame::Frame;
use canloop::time::{Duration, Instant};
use serde::Serialize;

use super::confinement::Confinement;

/// A node of the bus.
#[derive(Debug)]
pub(super) struct Station {
    /// First in, first out.
    pub queue: Fifo<Queued>,
    pub confinement: Confinement,
    /// The state that was told last.
    pub told: ControllerState,
    /// An error-passive transmitter leaves the bus to others until then.
    pub not_before: Instant,
    /// The part of a cut bus that it is on.
    pub segment: usize,
    pub recovering: Recovering,
    pub stats: NodeStats,
}

/// A frame that waits for the bus.
#[derive(Clone, Copy, Debug)]
pub(super) struct Queued {
    pub since: Instant,
    pub frame: Frame,
    /// Whether somebody waits for it to cross.
    pub is_awaited: bool,
}

/// What a node can tell of itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct NodeStats {
    /// Frames that others received.
    pub sent: u64,
    /// Attempts to send a frame that ended in an error frame. Each but those
    /// that took it off the bus was followed by another.
    pub failed: u64,
    /// Frames that found its queue full.
    pub lost: u64,
    /// Frames that a fault took before they reached the bus, or that were
    /// thrown away because it was off the bus.
    pub discarded: u64,
    /// How often it went off the bus.
    pub bus_off: u64,
    /// Its transmit error counter.
    pub transmit_errors: u16,
    /// Its receive error counter.
    pub receive_errors: u16,
}

/// How a node comes back that went off the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Recovery {
    /// After 128 times 11 recessive bits, by itself.
    #[default]
    ByItself,
    /// After this time and then those bits, as a kernel's `restart-ms` does.
    After(Duration),
    /// After those bits, but only when told by [`super::Wire::restart`].
    ByCommand,
}

/// How far a node is on its way back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Recovering {
    /// It is on the bus.
    No,
    /// It has not set out.
    Held,
    /// It sets out then.
    From(Instant),
    /// So many times 11 recessive bits are left; the bus was seen busy last
    /// at that moment.
    Counting(u32, Instant),
}

/// Frames that a node can have waiting.
pub(super) const QUEUE_FRAMES: usize = 64;
/// How many times a node off the bus waits for 11 recessive bits.
pub(super) const RECESSIVE_TIMES: u32 = 128;

impl Station {
    pub fn new() -> Self {
        Self {
            queue: Fifo::with_capacity(QUEUE_FRAMES),
            confinement: Confinement::default(),
            told: ControllerState::ErrorActive,
            not_before: Instant::from_nanos(i64::MIN),
            segment: 0,
            recovering: Recovering::No,
            stats: NodeStats::default(),
        }
    }

    /// Whether nothing is out of the ordinary with it.
    pub fn is_clean(&self) -> bool {
        self.confinement.is_clean() && self.recovering == Recovering::No
    }
}
