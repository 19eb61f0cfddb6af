//! The bus between stack and drives: one frame at a time, the lowest
//! arbitration id first, as long as its bits take; with error frames and
//! retransmission, error counters and what follows from them, and the faults
//! that somebody lets happen.
//!
//! It has no clock: moments in, moments out. While nothing is wrong and
//! nothing is held against anybody it takes a short way through all this.

mod active;
mod arbitration;
mod chance;
mod confinement;
mod fault;
mod node;
mod outcome;
mod recovery;
mod station;
mod timing;
mod trouble;

use std::collections::VecDeque;

use canloop::bus::{BitRates, ControllerState};
use canloop::frame::Frame;
use canloop::time::{Duration, Instant};

use active::{Alteration, Faults};
use arbitration::Segment;
use station::{QUEUE_FRAMES, Queued, Station};

pub use chance::Chance;
pub use confinement::Confinement;
pub use fault::{BurstyLoss, Damage, Fault, FaultId, Pick};
pub use node::{Node, Nodes};
pub use station::{NodeStats, Recovery};

/// A CAN bus.
#[derive(Debug)]
pub struct Wire {
    rates: BitRates,
    recovery: [Recovery; 4],
    stations: [Station; 4],
    /// Who has something to send.
    waiting: Nodes,
    /// The parts of the bus; more than one only while it is cut.
    segments: [Segment; 4],
    segment_count: usize,
    /// The latest moment that it was told of or that came about.
    now: Instant,
    faults: Faults,
    /// Nodes that send nothing.
    silent: Nodes,
    /// Frames that reach their queue later, with the moment.
    delayed: Vec<(Instant, Node, Queued)>,
    /// Frames that let their sender's next one go first.
    overtaken: Vec<(Node, Queued)>,
    /// Whether the short way will do.
    is_quiet: bool,
    /// Frames that somebody waits for and that have yet to cross.
    awaited: u32,
    changes: VecDeque<StateChange>,
    stats: WireStats,
}

/// What has crossed the bus so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WireStats {
    /// Frames delivered.
    pub frames: u64,
    /// Frames dropped because a transmit queue was full.
    pub lost: u64,
    /// Time the bus was busy; of a bus that is cut, the part with the stack.
    pub busy: Duration,
    /// When the last frame to win the bus was over.
    pub until: Instant,
    /// Error frames: attempts to send that failed.
    pub error_frames: u64,
    /// Frames that faults took, or that were thrown away off the bus.
    pub discarded: u64,
    /// What stack, right and left drive can tell of themselves.
    pub nodes: [NodeStats; 3],
}

/// A frame that has crossed.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// The end of its inter-frame space.
    pub at: Instant,
    /// Who sent it.
    pub sender: Node,
    /// What was sent.
    pub frame: Frame,
    /// Who received it.
    pub heard_by: Nodes,
    altered: Option<(Nodes, Alteration)>,
}

/// A controller's state that has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateChange {
    /// When.
    pub at: Instant,
    /// Whose.
    pub node: Node,
    /// To what.
    pub state: ControllerState,
}

impl Wire {
    /// An idle bus. `seed` is that of all chance in its faults.
    pub fn new(rates: BitRates, seed: u64) -> Self {
        Self {
            rates,
            recovery: [Recovery::ByItself; 4],
            stations: std::array::from_fn(|_| Station::new()),
            waiting: Nodes::NONE,
            segments: [Segment::IDLE; 4],
            segment_count: 1,
            now: Instant::from_nanos(i64::MIN),
            faults: Faults::new(seed),
            silent: Nodes::NONE,
            delayed: Vec::new(),
            overtaken: Vec::new(),
            is_quiet: true,
            awaited: 0,
            changes: VecDeque::new(),
            stats: WireStats::default(),
        }
    }

    /// The same bus, on which `node` comes back in this way from being off.
    pub fn with_recovery(mut self, node: Node, recovery: Recovery) -> Self {
        self.recovery[node as usize] = recovery;
        self
    }

    /// Queues a frame of `node`'s; a full queue drops it and counts it.
    /// [`Self::awaited`] counts those that `is_awaited`.
    #[inline]
    pub fn send(&mut self, now: Instant, node: Node, frame: Frame, is_awaited: bool) {
        self.now = self.now.max(now);
        self.awaited += u32::from(is_awaited);
        let queued = Queued { since: now, frame, is_awaited };
        if self.is_quiet {
            self.enqueue(node, queued);
        } else {
            self.send_in_trouble(node, queued);
        }
    }

    /// When something will happen next, if nothing is sent before: most often
    /// a frame will have crossed then.
    #[inline]
    pub fn next_event(&mut self) -> Option<Instant> {
        if self.is_quiet { self.next_on(0) } else { self.next_in_trouble() }
    }

    /// Lets happen what [`Self::next_event`] announced, and gives the frame
    /// that has crossed, if one has.
    #[inline]
    pub fn advance(&mut self) -> Option<Crossing> {
        if let Some(attempt) = self.segments[0].current.filter(|_| self.is_quiet) {
            self.now = self.now.max(attempt.end);
            return self.finish(0);
        }
        let at = self.next_event()?;
        self.now = self.now.max(at);
        if !self.is_quiet && self.lets_happen_beside_frames(at) {
            return None;
        }
        let over = (0..self.segment_count).find(|&segment| self.segments[segment].is_over_at(at))?;
        self.finish(over)
    }

    /// Lets a fault begin. Its chance is that of its number.
    pub fn begin(&mut self, now: Instant, fault: Fault) -> FaultId {
        self.begin_in_row(now, fault, u64::from(self.faults.begun()))
    }

    /// Lets a fault begin whose chance is this row of it, whatever other faults
    /// there are.
    pub fn begin_in_row(&mut self, now: Instant, fault: Fault, row: u64) -> FaultId {
        self.now = self.now.max(now);
        self.is_quiet = false;
        let id = self.faults.begin(self.now, fault, row);
        self.take_up(&fault, true);
        id
    }

    /// Lets a fault end; says whether it was in force.
    pub fn end(&mut self, now: Instant, id: FaultId) -> bool {
        self.now = self.now.max(now);
        let ended = self.faults.end(id);
        if let Some(fault) = ended {
            self.take_up(&fault, false);
        }
        ended.is_some()
    }

    /// Whether a frame of `node`'s has yet to cross.
    pub const fn has_queued(&self, node: Node) -> bool {
        self.waiting.contains(node)
    }

    /// Frames sent as awaited that have neither crossed yet nor been lost.
    pub const fn awaited(&self) -> u32 {
        self.awaited
    }

    /// Whether no fault has ever begun.
    pub const fn is_untouched(&self) -> bool {
        self.faults.begun() == 0
    }

    /// What has crossed so far.
    pub fn stats(&self) -> WireStats {
        WireStats { nodes: [Node::Stack, Node::Right, Node::Left].map(|node| self.node_stats(node)), ..self.stats }
    }

    /// What a node can tell of itself.
    pub const fn node_stats(&self, node: Node) -> NodeStats {
        let Station { stats, confinement, .. } = &self.stations[node as usize];
        NodeStats {
            transmit_errors: confinement.transmit_errors(),
            receive_errors: confinement.receive_errors(),
            ..*stats
        }
    }

    /// A node's error counters and state.
    pub const fn confinement(&self, node: Node) -> &Confinement {
        &self.stations[node as usize].confinement
    }

    /// The next change of a controller's state.
    pub fn poll_change(&mut self) -> Option<StateChange> {
        self.changes.pop_front()
    }

    #[inline]
    fn enqueue(&mut self, node: Node, queued: Queued) {
        let station = &mut self.stations[node as usize];
        if station.queue.len() < QUEUE_FRAMES {
            station.queue.push(queued);
            self.waiting = self.waiting.and(Nodes::only(node));
        } else {
            station.stats.lost += 1;
            self.stats.lost += 1;
            self.awaited -= u32::from(queued.is_awaited);
        }
    }

    /// Takes the first frame out of a node's queue.
    #[inline]
    fn dequeue(&mut self, node: Node) -> Option<Queued> {
        let queue = &mut self.stations[node as usize].queue;
        let queued = queue.pop();
        if queue.is_empty() {
            self.waiting = self.waiting.without(Nodes::only(node));
        }
        queued
    }
}

impl Crossing {
    /// Who received something else than was sent, and what.
    pub fn altered(&self) -> Option<(Nodes, Frame)> {
        self.altered.map(|(nodes, alteration)| (nodes, alteration.of(&self.frame)))
    }

    /// The frame as a node received it, if it did.
    pub fn as_heard_by(&self, node: Node) -> Option<Frame> {
        let altered = self.altered.filter(|(nodes, _)| nodes.contains(node));
        self.heard_by.contains(node).then(|| altered.map_or(self.frame, |(_, alteration)| alteration.of(&self.frame)))
    }
}
