//! Node numbers in arbitration ids.

use crate::frame::CanId;

/// Where an arbitration id holds the node's number.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Addressing {
    pub mask: u32,
    /// The number that means all nodes.
    pub broadcast: Option<u8>,
}

impl Addressing {
    /// The greatest number of a node.
    pub const fn most(self) -> u32 {
        match self.mask.checked_shr(self.mask.trailing_zeros()) {
            Some(most) => most,
            None => 0,
        }
    }

    /// The number of the node that an id carries; 0 where ids carry none.
    pub fn node_in(self, id: CanId) -> u32 {
        (id.raw() & self.mask).checked_shr(self.mask.trailing_zeros()).unwrap_or(0)
    }

    /// The id with another node's number in it, if the bits for it suffice.
    pub fn readdressed(self, id: CanId, node: u8) -> Option<CanId> {
        let bits = u32::from(node).checked_shl(self.mask.trailing_zeros()).filter(|bits| bits & !self.mask == 0)?;
        let raw = id.raw() & !self.mask | bits;
        match id {
            CanId::Standard(_) => u16::try_from(raw).ok().filter(|raw| *raw <= 0x7FF).map(CanId::Standard),
            CanId::Extended(_) => Some(CanId::Extended(raw)),
        }
    }
}
