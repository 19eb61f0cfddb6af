//! Who wins the bus, and what will come of it.

use canloop::bus::frame_bits;
use canloop::frame::{Frame, FrameKind};
use canloop::time::{Duration, Instant};

use super::active::{Alteration, Disturbance};
use super::node::{Node, Nodes};
use super::timing::ErrorTiming as _;
use super::timing::INTER_FRAME_SPACE;
use super::{Wire, station::Queued};

/// A bus, or one of the parts that it is cut into.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// Whose frame has won the bus. It stays at the head of its queue until
    /// it is over.
    pub current: Option<Attempt>,
    pub free_at: Instant,
}

/// An attempt to send a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Attempt {
    pub sender: Node,
    pub start: Instant,
    /// When the inter-frame space after it is over.
    pub end: Instant,
    pub outcome: Outcome,
}

/// How an attempt will end.
#[derive(Clone, Copy, Debug)]
pub(super) enum Outcome {
    /// The frame crosses; error-passive nodes may have missed it.
    Crosses { heard_by: Nodes, missed_by: Nodes, altered: Option<(Nodes, Alteration)> },
    /// It ends in an error frame.
    Fails(Failure),
}

/// Why an attempt fails.
#[derive(Clone, Copy, Debug)]
pub(super) enum Failure {
    /// A bit was wrong for everybody.
    Bit,
    /// These were the first to see an error.
    Crc(Nodes),
    /// Nobody acknowledged it.
    NotAcknowledged,
    /// These sent another frame under the same id.
    Collision(Nodes),
}

/// Who would win the bus, and when.
struct Contest {
    start: Instant,
    winner: Node,
    order: u64,
    /// Who else would send under the same id.
    rivals: Nodes,
}

impl Segment {
    pub const IDLE: Self = Self { current: None, free_at: Instant::from_nanos(i64::MIN) };

    pub fn is_over_at(&self, at: Instant) -> bool {
        self.current.is_some_and(|attempt| attempt.end == at)
    }
}

impl Wire {
    /// When what is on a segment will be over, or somebody will begin. Who
    /// begins is decided when the moment has come, not before.
    pub(super) fn next_on(&mut self, segment: usize) -> Option<Instant> {
        if let Some(attempt) = self.segments[segment].current {
            return Some(attempt.end);
        }
        let contest = self.contest(segment)?;
        if contest.start > self.now {
            return Some(contest.start);
        }
        Some(self.begin_attempt(segment, &contest))
    }

    /// At the moment the bus is free and somebody has a frame ready, the
    /// lowest id among those ready then wins.
    fn contest(&self, segment: usize) -> Option<Contest> {
        let free_at = self.segments[segment].free_at;
        if let Some(winner) = self.waiting.single() {
            let (.., ready) = self.head(winner, segment)?;
            return Some(Contest { start: ready.max(free_at), winner, order: 0, rivals: Nodes::NONE });
        }
        let earliest = self.heads(segment).map(|(.., ready)| ready).min()?;
        let start = earliest.max(free_at);
        let mut contest = Contest { start, winner: Node::Stack, order: u64::MAX, rivals: Nodes::NONE };
        for (node, queued, ready) in self.heads(segment) {
            let order = arbitration_order(&queued.frame);
            if ready <= start && order < contest.order {
                (contest.winner, contest.order, contest.rivals) = (node, order, Nodes::NONE);
            } else if ready <= start && order == contest.order {
                contest.rivals = contest.rivals.and(Nodes::only(node));
            }
        }
        Some(contest)
    }

    /// The first frame of each queue, and from when on it may begin.
    fn heads(&self, segment: usize) -> impl Iterator<Item = (Node, &Queued, Instant)> {
        self.waiting.iter().filter_map(move |node| self.head(node, segment))
    }

    fn head(&self, node: Node, segment: usize) -> Option<(Node, &Queued, Instant)> {
        let station = &self.stations[node as usize];
        let queued = station.queue.front().filter(|_| station.segment == segment)?;
        Some((node, queued, queued.since.max(station.not_before)))
    }

    /// Gives the moment at which it will be over.
    fn begin_attempt(&mut self, segment: usize, contest: &Contest) -> Instant {
        let Contest { start, winner: sender, .. } = *contest;
        let Some(Queued { frame, .. }) = self.stations[sender as usize].queue.front() else { return start };
        let (outcome, length) = if self.is_quiet && contest.rivals.is_empty() {
            let heard_by = Nodes::ALL.without(Nodes::only(sender));
            (Outcome::Crosses { heard_by, missed_by: Nodes::NONE, altered: None }, self.rates.frame(frame))
        } else {
            let frame = *frame;
            self.count_recessive_until(segment, start);
            self.foresee(segment, sender, &frame, contest.rivals)
        };
        let end = start + length;
        if self.stations[Node::Stack as usize].segment == segment {
            self.stats.busy = self.stats.busy + length;
            self.stats.until = end;
        }
        self.segments[segment] = Segment { current: Some(Attempt { sender, start, end, outcome }), free_at: end };
        end
    }

    /// What will come of a frame that wins a bus on which something is wrong,
    /// and how long it takes.
    fn foresee(&mut self, segment: usize, sender: Node, frame: &Frame, rivals: Nodes) -> (Outcome, Duration) {
        if let Some(bit) = self.collides(frame, rivals) {
            return (Outcome::Fails(Failure::Collision(rivals)), self.rates.broken_off(frame, bit));
        }
        let peers = self.on_the_bus(segment).without(Nodes::only(sender));
        let mut heard_by = peers;
        let mut acknowledge = peers.without(self.silent);
        let mut altered = None;
        match self.faults.on_the_wire(sender, frame, frame_bits(frame) - INTER_FRAME_SPACE) {
            Some(Disturbance::Bit(bit)) => {
                return (Outcome::Fails(Failure::Bit), self.rates.broken_off(frame, bit));
            }
            Some(Disturbance::Caught(at)) => {
                let seen_by = at.among(peers);
                let is_active = |&node: &Node| !self.confinement(node).is_passive();
                if seen_by.among(acknowledge).iter().any(|node| is_active(&node)) {
                    return (Outcome::Fails(Failure::Crc(seen_by)), self.rates.failed_crc(frame));
                }
                heard_by = peers.without(seen_by);
                acknowledge = acknowledge.without(seen_by);
            }
            Some(Disturbance::Uncaught(at, alteration)) => altered = Some((at.among(peers), alteration)),
            Some(Disturbance::NotAcknowledged) => acknowledge = Nodes::NONE,
            None => {}
        }
        if acknowledge.is_empty() {
            return (Outcome::Fails(Failure::NotAcknowledged), self.rates.not_acknowledged(frame));
        }
        let missed_by = peers.without(heard_by);
        (Outcome::Crosses { heard_by, missed_by, altered }, self.rates.frame(frame))
    }

    /// The first bit in which frames under one id differ. The same frame from
    /// two nodes is no collision: they do not notice each other.
    fn collides(&self, frame: &Frame, rivals: Nodes) -> Option<u32> {
        let header = if frame.id.is_extended() { 39 } else { 19 };
        let differs = |node: Node| {
            let other = self.stations[node as usize].queue.front()?.frame;
            let byte = frame.payload().iter().zip(other.payload()).position(|(one, another)| one != another);
            let is_other = byte.is_some() || frame.len() != other.len() || frame.kind != other.kind;
            is_other.then(|| byte.map_or(header, |byte| header + 8 * byte as u32))
        };
        rivals.iter().filter_map(differs).min()
    }
}

/// The lowest wins; a data frame goes before the request for it.
fn arbitration_order(frame: &Frame) -> u64 {
    u64::from(frame.id.arbitration_order()) << 1 | u64::from(frame.kind == FrameKind::Remote)
}
