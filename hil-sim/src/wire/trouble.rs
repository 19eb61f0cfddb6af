//! What a bus does beside carrying frames while something is wrong with it.

use canloop::time::{Duration, Instant};

use super::Wire;
use super::arbitration::{Failure, Segment};
use super::fault::Fault;
use super::node::{Node, Nodes};
use super::station::{QUEUE_FRAMES, Queued, Recovering, Station};
use super::timing::ErrorTiming as _;

impl Wire {
    pub(super) fn send_in_trouble(&mut self, node: Node, queued: Queued) {
        if self.takes_nothing_from(node) {
            return self.discard(node, &queued);
        }
        let sending = self.faults.sending(node, &queued.frame);
        if sending.is_lost {
            return self.discard(node, &queued);
        }
        // More would find no room.
        let copies = sending.copies.min(QUEUE_FRAMES as u32);
        let copy = Queued { is_awaited: false, ..queued };
        if sending.delay > Duration::ZERO {
            let at = queued.since + sending.delay;
            self.delayed.push((at, node, queued));
            self.delayed.extend((0..copies).map(|_| (at, node, copy)));
        } else if sending.lets_next_go_first {
            self.overtaken.push((node, queued));
            self.overtaken.extend((0..copies).map(|_| (node, copy)));
        } else {
            self.enqueue(node, queued);
            (0..copies).for_each(|_| self.enqueue(node, copy));
            self.release_overtaken(|sender| sender == node, queued.since);
        }
    }

    pub(super) fn next_in_trouble(&mut self) -> Option<Instant> {
        let beside = self.next_beside_frames();
        // What is due now may make somebody else begin.
        if beside.is_some_and(|at| at <= self.now) {
            return beside;
        }
        (0..self.segment_count).filter_map(|segment| self.next_on(segment)).chain(beside).min()
    }

    fn next_beside_frames(&self) -> Option<Instant> {
        let delayed = self.delayed.iter().map(|&(at, ..)| at);
        let recovery = self.next_recovery().map(|(at, _)| at);
        delayed.chain(recovery).chain(self.faults.next_babble()).min()
    }

    /// Lets one thing happen that is due then and is no frame; says whether
    /// there was one.
    pub(super) fn lets_happen_beside_frames(&mut self, at: Instant) -> bool {
        if let Some(index) = self.delayed.iter().position(|&(due, ..)| due <= at) {
            let (_, node, queued) = self.delayed.remove(index);
            self.enqueue_late(node, queued, at);
        } else if let Some(frame) = self.faults.babble_at(at, self.rates.bits(1)) {
            self.babble(Queued { since: at, frame, is_awaited: false });
        } else if let Some((_, node)) = self.next_recovery().filter(|&(due, _)| due <= at) {
            self.recover(node, at);
        } else {
            return false;
        }
        true
    }

    /// A fault has begun, or has ended.
    pub(super) fn take_up(&mut self, fault: &Fault, begins: bool) {
        match *fault {
            Fault::Silence(node) => {
                self.silent = self.faults.all().filter_map(Fault::silenced).collect();
                if begins {
                    self.destroy_what_is_crossing(Nodes::only(node));
                    self.discard_queue(node);
                }
            }
            Fault::BusOff(node) if begins => {
                self.destroy_what_is_crossing(Nodes::only(node));
                self.stations[node as usize].confinement.go_off();
                self.tell_changes(self.now);
                // It may have been off before.
                self.set_out(node, self.now);
            }
            Fault::BusOff(node) if self.confinement(node).is_off() => self.set_out(node, self.now),
            Fault::Cut(_) => {
                self.destroy_what_is_crossing(Nodes::ALL);
                self.cut();
            }
            Fault::Reorder(_) if !begins => self.release_overtaken(|_| true, self.now),
            Fault::Babble(..) if begins => self.babble_on(self.now),
            Fault::Babble(..) if !self.has_intruder() => {
                self.destroy_what_is_crossing(Nodes::only(Node::Intruder));
                self.discard_queue(Node::Intruder);
                let intruder = &mut self.stations[Node::Intruder as usize];
                *intruder = Station { segment: intruder.segment, ..Station::new() };
            }
            _ => {}
        }
        self.is_quiet = self.is_in_order();
    }

    /// Who is on a segment and not off the bus.
    pub(super) fn on_the_bus(&self, segment: usize) -> Nodes {
        let is_on = |&node: &Node| {
            let station = &self.stations[node as usize];
            let is_there = node != Node::Intruder || self.has_intruder();
            is_there && station.segment == segment && !station.confinement.is_off()
        };
        Node::ALL.into_iter().filter(is_on).collect()
    }

    /// Whether nothing is wrong any more.
    pub(super) fn is_in_order(&self) -> bool {
        self.faults.is_empty()
            && self.delayed.is_empty()
            && self.overtaken.is_empty()
            && self.stations.iter().all(Station::is_clean)
    }

    /// Who babbles as fast as it can has the next frame ready at once.
    pub(super) fn babble_on(&mut self, now: Instant) {
        if self.has_queued(Node::Intruder) {
            return;
        }
        let ceaseless: Vec<_> = self.faults.all().filter_map(Fault::babbled_without_end).collect();
        ceaseless.into_iter().for_each(|frame| self.babble(Queued { since: now, frame, is_awaited: false }));
    }

    pub(super) fn discard_queue(&mut self, node: Node) {
        while let Some(queued) = self.dequeue(node) {
            self.discard(node, &queued);
        }
    }

    fn babble(&mut self, queued: Queued) {
        let station = &self.stations[Node::Intruder as usize];
        // What it cannot say is nobody's loss.
        if !station.confinement.is_off() && station.queue.len() < QUEUE_FRAMES {
            self.enqueue(Node::Intruder, queued);
        }
    }

    fn has_intruder(&self) -> bool {
        self.faults.all().any(|fault| matches!(fault, Fault::Babble(..)))
    }

    fn takes_nothing_from(&self, node: Node) -> bool {
        self.silent.contains(node) || self.confinement(node).is_off()
    }

    fn discard(&mut self, node: Node, queued: &Queued) {
        self.stations[node as usize].stats.discarded += 1;
        self.stats.discarded += 1;
        self.awaited -= u32::from(queued.is_awaited);
    }

    fn enqueue_late(&mut self, node: Node, queued: Queued, now: Instant) {
        if self.takes_nothing_from(node) {
            self.discard(node, &queued);
        } else {
            self.enqueue(node, Queued { since: now, ..queued });
        }
    }

    fn release_overtaken(&mut self, of: impl Fn(Node) -> bool, now: Instant) {
        while let Some(index) = self.overtaken.iter().position(|&(node, _)| of(node)) {
            let (node, queued) = self.overtaken.remove(index);
            self.enqueue_late(node, queued, now);
        }
    }

    /// What these nodes have on the wire ends in an error frame.
    fn destroy_what_is_crossing(&mut self, senders: Nodes) {
        for segment in 0..self.segment_count {
            let Some(attempt) = self.segments[segment].current.filter(|attempt| senders.contains(attempt.sender))
            else {
                continue;
            };
            let free_at = self.now.max(attempt.start) + self.rates.error_frame();
            if self.stations[Node::Stack as usize].segment == segment {
                self.stats.busy = self.stats.busy + (free_at - attempt.end);
                self.stats.until = free_at;
            }
            self.segments[segment] = Segment { current: None, free_at };
            self.count_failure(segment, attempt.sender, Failure::Bit);
        }
        self.tell_changes(self.now);
    }

    /// Sorts the nodes by the side of each cut that they are on.
    fn cut(&mut self) {
        let sides = Node::ALL.map(|node| {
            // Who does not belong here is next to the stack.
            let place = if node == Node::Intruder { Node::Stack } else { node };
            let side = |fault: &Fault| fault.cut_off().map(|cut_off| cut_off.contains(place));
            self.faults.all().filter_map(side).collect::<Vec<_>>()
        });
        let free_at = self.segments.iter().map(|segment| segment.free_at).max();
        self.segments = [Segment { current: None, free_at: free_at.unwrap_or(self.now) }; 4];
        self.segment_count = 0;
        for node in Node::ALL {
            let index = node as usize;
            let joined = (0..index).find(|&other| sides[other] == sides[index]);
            self.stations[index].segment = joined.map_or(self.segment_count, |other| self.stations[other].segment);
            self.segment_count += usize::from(joined.is_none());
            if let Recovering::Counting(left, _) = self.stations[index].recovering {
                self.stations[index].recovering = Recovering::Counting(left, self.now);
            }
        }
    }
}

impl Fault {
    const fn silenced(&self) -> Option<Node> {
        if let Self::Silence(node) = self { Some(*node) } else { None }
    }

    const fn cut_off(&self) -> Option<Nodes> {
        if let Self::Cut(nodes) = self { Some(*nodes) } else { None }
    }

    const fn babbled_without_end(&self) -> Option<canloop::frame::Frame> {
        if let Self::Babble(frame, None) = self { Some(*frame) } else { None }
    }
}
