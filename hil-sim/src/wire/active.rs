//! The faults that are in force, and what they do to a frame.

use canloop::frame::Frame;
use canloop::time::{Duration, Instant};

use super::chance::Chance;
use super::fault::{BurstyLoss, Damage, Fault, FaultId, Pick};
use super::node::{Node, Nodes};

/// Faults in force, in the order in which they began.
#[derive(Debug)]
pub(super) struct Faults {
    seed: u64,
    begun: u32,
    active: Vec<Active>,
}

#[derive(Debug)]
struct Active {
    id: FaultId,
    fault: Fault,
    chance: Chance,
    /// Frames that it was for so far.
    taken: u32,
    /// A bursty channel's state.
    is_bad: bool,
    /// When a node that babbles now and then does next.
    next: Instant,
}

/// What becomes of a frame that is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sending {
    pub is_lost: bool,
    pub delay: Duration,
    pub copies: u32,
    pub lets_next_go_first: bool,
}

/// What happens to a frame on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Disturbance {
    /// A bit is wrong for everybody.
    Bit(u32),
    /// These nodes see by the CRC that it is damaged.
    Caught(Nodes),
    /// These nodes take one byte for another.
    Uncaught(Nodes, Alteration),
    /// Nobody acknowledges it.
    NotAcknowledged,
}

/// A byte of the data that is taken for another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Alteration {
    pub byte: u8,
    pub flips: u8,
}

impl Faults {
    pub const fn new(seed: u64) -> Self {
        Self { seed, begun: 0, active: Vec::new() }
    }

    pub const fn is_empty(&self) -> bool {
        self.active.is_empty()
    }

    /// How many have ever begun.
    pub const fn begun(&self) -> u32 {
        self.begun
    }

    /// Each fault has a row of chance of its own: this one.
    pub fn begin(&mut self, now: Instant, fault: Fault, row: u64) -> FaultId {
        let id = FaultId(self.begun);
        self.begun += 1;
        let chance = Chance::new(self.seed, row);
        self.active.push(Active { id, fault, chance, taken: 0, is_bad: false, next: now });
        id
    }

    pub fn end(&mut self, id: FaultId) -> Option<Fault> {
        let at = self.active.iter().position(|active| active.id == id)?;
        Some(self.active.remove(at).fault)
    }

    pub fn all(&self) -> impl Iterator<Item = &Fault> {
        self.active.iter().map(|active| &active.fault)
    }

    /// What becomes of a frame that `sender` sends.
    pub fn sending(&mut self, sender: Node, frame: &Frame) -> Sending {
        let mut sending = Sending { is_lost: false, delay: Duration::ZERO, copies: 0, lets_next_go_first: false };
        for active in &mut self.active {
            let fault = active.fault;
            match fault {
                Fault::Drop(pick) => sending.is_lost |= active.picks(&pick, sender, frame),
                Fault::BurstyLoss(channel) => sending.is_lost |= active.is_lost_on(&channel),
                Fault::Delay(pick, by) if active.picks(&pick, sender, frame) => {
                    sending.delay = sending.delay + by.max(Duration::ZERO);
                }
                Fault::Duplicate(pick, copies) if active.picks(&pick, sender, frame) => {
                    sending.copies = sending.copies.saturating_add(copies);
                }
                Fault::Reorder(pick) => sending.lets_next_go_first |= active.picks(&pick, sender, frame),
                _ => {}
            }
        }
        sending
    }

    /// What happens to a frame of `bits` without its inter-frame space that `sender` has won the bus for:
    /// the doing of the fault that began first.
    pub fn on_the_wire(&mut self, sender: Node, frame: &Frame, bits: u32) -> Option<Disturbance> {
        self.active.iter_mut().find_map(|active| active.disturbs(sender, frame, bits))
    }

    /// When a node that babbles now and then does next.
    pub fn next_babble(&self) -> Option<Instant> {
        let cyclic = self.active.iter().filter(|active| matches!(active.fault, Fault::Babble(_, Some(_))));
        cyclic.map(|active| active.next).min()
    }

    /// What it sends at that moment.
    pub fn babble_at(&mut self, now: Instant, least: Duration) -> Option<Frame> {
        self.active.iter_mut().find_map(|active| match active.fault {
            Fault::Babble(frame, Some(every)) if active.next <= now => {
                active.next = now + every.max(least);
                Some(frame)
            }
            _ => None,
        })
    }
}

impl Active {
    /// Whether it is for this frame, which then counts.
    fn picks(&mut self, pick: &Pick, sender: Node, frame: &Frame) -> bool {
        let fits = pick.id.is_none_or(|id| id == frame.id)
            && pick.sender.is_none_or(|node| node == sender)
            && pick.count.is_none_or(|count| self.taken < count)
            && self.chance.happens(pick.probability);
        self.taken = self.taken.saturating_add(u32::from(fits));
        fits
    }

    fn is_lost_on(&mut self, channel: &BurstyLoss) -> bool {
        let turns = if self.is_bad { channel.turns_good } else { channel.turns_bad };
        self.is_bad ^= self.chance.happens(turns);
        self.chance.happens(if self.is_bad { channel.lost_when_bad } else { channel.lost_when_good })
    }

    fn disturbs(&mut self, sender: Node, frame: &Frame, bits: u32) -> Option<Disturbance> {
        match self.fault {
            Fault::Corrupt(pick, damage, at) => self.picks(&pick, sender, frame).then(|| match damage {
                Damage::Caught if at.contains(sender) => Disturbance::Bit(self.chance.below(bits)),
                Damage::Caught => Disturbance::Caught(at),
                Damage::Uncaught => Disturbance::Uncaught(at, self.altered(frame)),
            }),
            Fault::NoAcknowledge(pick) => self.picks(&pick, sender, frame).then_some(Disturbance::NotAcknowledged),
            Fault::BitErrors(per_bit) => {
                let probability = -libm::expm1(f64::from(bits) * libm::log1p(-per_bit.clamp(0.0, 1.0)));
                self.chance.happens(probability).then(|| Disturbance::Bit(self.chance.below(bits)))
            }
            _ => None,
        }
    }

    fn altered(&mut self, frame: &Frame) -> Alteration {
        let byte = self.chance.below(frame.len() as u32) as u8;
        Alteration { byte, flips: 1 + self.chance.below(255) as u8 }
    }
}

impl Alteration {
    /// The frame as it is taken. One without data has nothing to be altered.
    pub fn of(self, frame: &Frame) -> Frame {
        let mut altered = *frame;
        if let Some(byte) = altered.payload_mut().get_mut(usize::from(self.byte)) {
            *byte ^= self.flips;
        }
        altered
    }
}
