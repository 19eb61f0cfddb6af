//! How a node that went off the bus comes back: when 11 recessive bits in a
//! row have been seen 128 times (ISO 11898-1:2015, 12.1.4.3). An idle bus shows
//! them one after the other, a busy one once after each frame.

use canloop::time::Instant;

use super::Wire;
use super::fault::Fault;
use super::node::Node;
use super::station::{RECESSIVE_TIMES, Recovering, Recovery};
use super::timing::ErrorTiming as _;

impl Wire {
    /// Lets a node that is off the bus start to come back, as `ip link set
    /// can0 type can restart` does.
    pub fn restart(&mut self, now: Instant, node: Node) {
        self.now = self.now.max(now);
        if self.stations[node as usize].recovering == Recovering::Held && !self.is_held_off(node) {
            self.stations[node as usize].recovering = Recovering::Counting(RECESSIVE_TIMES, self.now);
        }
    }

    /// A node has gone off the bus, or what held it off has ended.
    pub(super) fn set_out(&mut self, node: Node, now: Instant) {
        self.stations[node as usize].recovering = match self.recovery[node as usize] {
            _ if self.is_held_off(node) => Recovering::Held,
            Recovery::ByItself => Recovering::Counting(RECESSIVE_TIMES, now),
            Recovery::After(wait) => Recovering::From(now + wait),
            Recovery::ByCommand => Recovering::Held,
        };
    }

    fn is_held_off(&self, node: Node) -> bool {
        self.faults.all().any(|fault| *fault == Fault::BusOff(node))
    }

    /// The next step of somebody's way back, if nothing is sent before.
    pub(super) fn next_recovery(&self) -> Option<(Instant, Node)> {
        let next = |node: Node| {
            let station = &self.stations[node as usize];
            let segment = &self.segments[station.segment];
            match station.recovering {
                Recovering::From(at) => Some((at, node)),
                Recovering::Counting(left, since) if segment.current.is_none() => {
                    Some((since.max(segment.free_at) + self.rates.recessive() * i64::from(left), node))
                }
                _ => None,
            }
        };
        Node::ALL.into_iter().filter_map(next).min_by_key(|&(at, _)| at)
    }

    /// Takes that step.
    pub(super) fn recover(&mut self, node: Node, at: Instant) {
        if let Recovering::From(_) = self.stations[node as usize].recovering {
            self.stations[node as usize].recovering = Recovering::Counting(RECESSIVE_TIMES, at);
            return;
        }
        self.stations[node as usize].recovering = Recovering::No;
        self.stations[node as usize].confinement.recover();
        self.tell_changes(at);
        if node == Node::Intruder {
            self.babble_on(at);
        }
    }

    /// The bus has been idle until somebody begins now.
    pub(super) fn count_recessive_until(&mut self, segment: usize, start: Instant) {
        let free_at = self.segments[segment].free_at;
        let each = self.rates.recessive().as_nanos().max(1);
        for station in self.stations.iter_mut().filter(|station| station.segment == segment) {
            if let Recovering::Counting(left, since) = station.recovering {
                let seen = (start - since.max(free_at)).as_nanos().max(0) / each;
                station.recovering = Recovering::Counting(left.saturating_sub(seen.min(128) as u32), start);
            }
        }
    }

    /// Delimiter, end of frame and inter-frame space are 11 recessive bits.
    pub(super) fn count_recessive_after(&mut self, segment: usize, end: Instant) {
        for node in Node::ALL {
            let station = &mut self.stations[node as usize];
            let Recovering::Counting(left, _) = station.recovering else { continue };
            if station.segment == segment {
                station.recovering = Recovering::Counting(left.saturating_sub(1), end);
                if left <= 1 {
                    self.recover(node, end);
                }
            }
        }
    }
}
