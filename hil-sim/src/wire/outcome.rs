//! What an attempt to send a frame leaves behind: a frame that has crossed, or
//! an error frame, and what the nodes count.

use canloop::bus::ControllerState;
use canloop::time::Instant;

use super::arbitration::{Attempt, Failure, Outcome};
use super::node::{Node, Nodes};
use super::timing::ErrorTiming as _;
use super::{Crossing, StateChange, Wire};

impl Wire {
    /// The attempt on a segment is over.
    #[inline]
    pub(super) fn finish(&mut self, segment: usize) -> Option<Crossing> {
        let Attempt { sender, end, outcome, .. } = self.segments[segment].current.take()?;
        match outcome {
            Outcome::Crosses { heard_by, missed_by, altered } => {
                let queued = self.dequeue(sender)?;
                self.stations[sender as usize].stats.sent += 1;
                self.stats.frames += 1;
                self.awaited -= u32::from(queued.is_awaited);
                if !self.is_quiet {
                    self.count_success(sender, heard_by, missed_by);
                    self.settle_after(segment, Nodes::only(sender), end);
                }
                Some(Crossing { at: end, sender, frame: queued.frame, heard_by, altered })
            }
            Outcome::Fails(failure) => {
                self.is_quiet = false;
                let senders = self.count_failure(segment, sender, failure);
                self.settle_after(segment, senders, end);
                None
            }
        }
    }

    fn count_success(&mut self, sender: Node, heard_by: Nodes, missed_by: Nodes) {
        self.stations[sender as usize].confinement.sent();
        for node in heard_by.iter() {
            self.stations[node as usize].confinement.received();
        }
        for node in missed_by.iter() {
            self.stations[node as usize].confinement.saw_error(false);
        }
    }

    /// Gives those who were sending.
    pub(super) fn count_failure(&mut self, segment: usize, sender: Node, failure: Failure) -> Nodes {
        let was_passive = self.confinement(sender).is_passive();
        let (others, first) = match failure {
            Failure::Bit | Failure::NotAcknowledged => (Nodes::NONE, Nodes::NONE),
            Failure::Crc(first) => (Nodes::NONE, first),
            Failure::Collision(rivals) => (rivals, Nodes::NONE),
        };
        let senders = others.and(Nodes::only(sender));
        for node in senders.iter() {
            let station = &mut self.stations[node as usize];
            station.stats.failed += 1;
            match failure {
                Failure::NotAcknowledged => station.confinement.was_not_acknowledged(),
                _ => station.confinement.failed_to_send(),
            }
        }
        self.stats.error_frames += 1;
        // Nobody notices the flag of a passive node that sees what others do not.
        if !was_passive || !matches!(failure, Failure::NotAcknowledged) {
            for node in self.on_the_bus(segment).without(senders).without(self.silent).iter() {
                self.stations[node as usize].confinement.saw_error(first.contains(node));
            }
        }
        senders
    }

    /// What follows from what was counted.
    fn settle_after(&mut self, segment: usize, senders: Nodes, end: Instant) {
        for node in senders.iter().filter(|&node| self.confinement(node).is_passive()).collect::<Nodes>().iter() {
            self.stations[node as usize].not_before = end + self.rates.suspend();
        }
        self.count_recessive_after(segment, end);
        self.tell_changes(end);
        if senders.contains(Node::Intruder) {
            self.babble_on(end);
        }
        self.is_quiet = self.is_in_order();
    }

    /// Tells of states that have changed; who is off the bus loses what it had
    /// to send.
    pub(super) fn tell_changes(&mut self, at: Instant) {
        for node in Node::ALL {
            let state = self.confinement(node).state();
            if self.stations[node as usize].told == state {
                continue;
            }
            self.stations[node as usize].told = state;
            self.changes.push_back(StateChange { at, node, state });
            if state == ControllerState::BusOff {
                self.stations[node as usize].stats.bus_off += 1;
                self.discard_queue(node);
                self.set_out(node, at);
            }
        }
    }
}
