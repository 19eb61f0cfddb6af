//! What can go wrong on a bus, as data. Whoever runs a scenario lets a fault
//! begin and end with [`super::Wire::begin`] and [`super::Wire::end`].

use canloop::frame::{CanId, Frame};
use canloop::time::Duration;

use super::node::{Node, Nodes};

/// A fault of the bus or of somebody on it.
///
/// What concerns single frames decides when a frame is sent or when it wins
/// the bus; one that is on its way already crosses as it began. What changes
/// who is on the bus destroys what is just crossing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// Frames are lost before they reach the bus.
    Drop(Pick),
    /// Frames reach their queue this much later; others overtake them.
    Delay(Pick, Duration),
    /// Frames are sent so many times more.
    Duplicate(Pick, u32),
    /// Frames let the next one of their sender's go first.
    Reorder(Pick),
    /// Frames are damaged as these nodes see them. A sender among them sees a
    /// wrong bit itself; if only receivers see the damage, it is the CRC that
    /// tells them.
    Corrupt(Pick, Damage, Nodes),
    /// A node hears but sends nothing, not even an acknowledgement.
    Silence(Node),
    /// Somebody who does not belong here sends this frame, this often, or as
    /// fast as it can.
    Babble(Frame, Option<Duration>),
    /// A node's controller goes off the bus, and recovers when this ends.
    BusOff(Node),
    /// Nobody acknowledges these frames, nor takes them.
    NoAcknowledge(Pick),
    /// These nodes are cut off from the others. Each side goes on as a bus of
    /// its own.
    Cut(Nodes),
    /// Each bit on the wire is wrong with this probability, for everybody.
    BitErrors(f64),
    /// Frames are lost as with [`Self::Drop`], in bursts.
    BurstyLoss(BurstyLoss),
}

/// Which frames a fault is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// Those with this id; without one, with any.
    pub id: Option<CanId>,
    /// Those of this node's; without one, of any.
    pub sender: Option<Node>,
    /// Of those, each with this probability.
    pub probability: f64,
    /// Of those, so many; without a number, all.
    pub count: Option<u32>,
}

/// Damage to a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// It is noticed: an error frame, and the frame is sent again.
    Caught,
    /// The CRC fits by chance: receivers take one byte of the data for another.
    Uncaught,
}

/// The channel of Gilbert ("Capacity of a burst-noise channel", 1960) and
/// Elliott (1963): good or bad, with a chance to change from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BurstyLoss {
    /// Probability that it turns bad with a frame while it is good.
    pub turns_bad: f64,
    /// Probability that it turns good with a frame while it is bad.
    pub turns_good: f64,
    /// Probability that a frame is lost while it is good.
    pub lost_when_good: f64,
    /// Probability that a frame is lost while it is bad.
    pub lost_when_bad: f64,
}

/// A fault that has begun.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FaultId(pub(super) u32);

impl Pick {
    /// Every frame.
    pub const ALL: Self = Self { id: None, sender: None, probability: 1.0, count: None };

    /// Every frame with this id.
    pub const fn id(id: CanId) -> Self {
        Self { id: Some(id), ..Self::ALL }
    }

    /// Every frame of this node's.
    pub const fn sender(node: Node) -> Self {
        Self { sender: Some(node), ..Self::ALL }
    }

    /// Only so many of them.
    pub const fn times(self, count: u32) -> Self {
        Self { count: Some(count), ..self }
    }

    /// Each of them with this probability.
    pub const fn with_probability(self, probability: f64) -> Self {
        Self { probability, ..self }
    }
}
