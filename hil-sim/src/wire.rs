//! The bus between stack and drives: one frame at a time, the lowest
//! arbitration id first, as long as its bits take.

use std::collections::VecDeque;

use canloop::bus::frame_bits;
use canloop::frame::Frame;
use canloop::time::{Duration, Instant};

/// Who is on the bus. Each has one transmit queue, first in, first out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Node {
    /// The control stack.
    Stack,
    /// The right wheel's drive.
    Right,
    /// The left wheel's drive.
    Left,
}

/// A CAN bus without errors.
#[derive(Debug)]
pub struct Wire {
    bitrate_bit_s: i64,
    queues: [VecDeque<Queued>; 3],
    /// Whose frame has won the bus, and when its last bit ends. It stays at
    /// the head of its queue until then.
    current: Option<(Instant, Node)>,
    free_at: Instant,
    stats: WireStats,
}

/// What has crossed the bus so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WireStats {
    /// Frames delivered.
    pub frames: u64,
    /// Frames dropped because a transmit queue was full.
    pub lost: u64,
    /// Time the bus was busy.
    pub busy: Duration,
    /// When the last frame to win the bus was over.
    pub until: Instant,
}

#[derive(Clone, Copy, Debug)]
struct Queued {
    since: Instant,
    frame: Frame,
}

/// Frames that a node can have waiting.
const QUEUE_FRAMES: usize = 64;

impl Wire {
    /// An idle bus.
    pub fn new(bitrate_bit_s: u32) -> Self {
        Self {
            bitrate_bit_s: i64::from(bitrate_bit_s),
            queues: std::array::from_fn(|_| VecDeque::with_capacity(QUEUE_FRAMES)),
            current: None,
            free_at: Instant::from_nanos(i64::MIN),
            stats: WireStats::default(),
        }
    }

    /// Queues a frame of `node`'s; a full queue drops it and counts it.
    pub fn send(&mut self, now: Instant, node: Node, frame: Frame) {
        let queue = &mut self.queues[node as usize];
        if queue.len() == QUEUE_FRAMES {
            self.stats.lost += 1;
        } else {
            queue.push_back(Queued { since: now, frame });
        }
    }

    /// When the next frame will have crossed, if nothing is sent before.
    pub fn next_arrival(&mut self) -> Option<Instant> {
        if self.current.is_none() {
            self.arbitrate();
        }
        self.current.map(|(end, _)| end)
    }

    /// Takes the frame that [`Self::next_arrival`] announced.
    pub fn deliver(&mut self) -> Option<(Instant, Node, Frame)> {
        let (end, node) = self.current.take()?;
        let Queued { frame, .. } = self.queues[node as usize].pop_front()?;
        self.stats.frames += 1;
        Some((end, node, frame))
    }

    /// Whether a frame of `node`'s has yet to cross.
    pub fn has_queued(&self, node: Node) -> bool {
        !self.queues[node as usize].is_empty()
    }

    /// What has crossed so far.
    pub const fn stats(&self) -> &WireStats {
        &self.stats
    }

    /// At the moment the bus is free and somebody has a frame ready, the
    /// lowest id among those ready then wins.
    fn arbitrate(&mut self) {
        let Some(earliest) = self.heads().map(|(_, queued)| queued.since).min() else { return };
        let start = earliest.max(self.free_at);
        let winner = self
            .heads()
            .filter(|(_, queued)| queued.since <= start)
            .min_by_key(|(_, queued)| queued.frame.id.arbitration_order());
        let Some((node, Queued { frame, .. })) = winner else { return };
        let length = Duration::from_nanos(i64::from(frame_bits(frame)) * 1_000_000_000 / self.bitrate_bit_s);
        self.free_at = start + length;
        self.stats.busy = self.stats.busy + length;
        self.stats.until = self.free_at;
        self.current = Some((self.free_at, node));
    }

    fn heads(&self) -> impl Iterator<Item = (Node, &Queued)> {
        let nodes = [Node::Stack, Node::Right, Node::Left];
        nodes.into_iter().filter_map(|node| self.queues[node as usize].front().map(|queued| (node, queued)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canloop::frame::CanId;

    fn frame(id: u16) -> Frame {
        Frame::classic(CanId::Standard(id), &[0x55; 8])
    }

    fn ids(wire: &mut Wire) -> Vec<u32> {
        std::iter::from_fn(|| {
            wire.next_arrival()?;
            wire.deliver().map(|(_, _, frame)| frame.id.raw())
        })
        .collect()
    }

    #[test]
    fn the_lowest_id_wins_but_never_interrupts() {
        let mut wire = Wire::new(500_000);
        wire.send(Instant::ZERO, Node::Left, frame(0x300));
        assert!(wire.next_arrival().is_some());
        wire.send(Instant::from_nanos(10), Node::Right, frame(0x200));
        wire.send(Instant::from_nanos(20), Node::Stack, frame(0x100));
        assert_eq!(ids(&mut wire), [0x300, 0x100, 0x200]);
    }

    #[test]
    fn a_node_s_own_frames_keep_their_order() {
        let mut wire = Wire::new(500_000);
        for id in [0x400, 0x100, 0x300] {
            wire.send(Instant::ZERO, Node::Stack, frame(id));
        }
        wire.send(Instant::ZERO, Node::Left, frame(0x200));
        assert_eq!(ids(&mut wire), [0x200, 0x400, 0x100, 0x300]);
    }

    #[test]
    fn a_frame_takes_as_long_as_its_bits() {
        let mut wire = Wire::new(1_000_000);
        wire.send(Instant::ZERO, Node::Stack, frame(0x100));
        let bits = i64::from(frame_bits(&frame(0x100)));
        assert_eq!(wire.next_arrival(), Some(Instant::from_nanos(bits * 1000)));
    }

    #[test]
    fn a_full_queue_is_counted() {
        let mut wire = Wire::new(500_000);
        for _ in 0..QUEUE_FRAMES + 3 {
            wire.send(Instant::ZERO, Node::Stack, frame(0x100));
        }
        assert_eq!(wire.stats().lost, 3);
    }
}
