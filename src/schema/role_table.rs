//! What the messages of a profile are for, by arbitration id.

use crate::frame::CanId;
use crate::wheels::Wheel;

/// What a message is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Sync,
    Command,
    Feedback(u8),
    Heartbeat,
    Fault,
    Word,
}

/// Whose it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Of {
    One(Wheel),
    Both,
}

/// Roles by arbitration id.
#[derive(Clone, Debug)]
pub(super) struct RoleTable {
    /// One for each of the 2048 standard ids.
    standard: Vec<Option<(Role, Of)>>,
    extended: Vec<(u32, (Role, Of))>,
    /// Whether a message besides SYNC is both wheels'.
    has_shared: bool,
}

impl RoleTable {
    pub fn new() -> Self {
        Self { standard: vec![None; 1 << 11], extended: Vec::new(), has_shared: false }
    }

    /// Gives `id` a role; false when it has another already. Words may share
    /// their message, with each other and with commands.
    pub fn insert(&mut self, id: CanId, role: Role, of: Of) -> bool {
        if let Some((taken, by)) = self.get(id) {
            return role == Role::Word && by == of && matches!(taken, Role::Word | Role::Command);
        }
        self.has_shared |= of == Of::Both && role != Role::Sync;
        match id {
            CanId::Standard(id) => self.standard[usize::from(id)] = Some((role, of)),
            CanId::Extended(id) => self.extended.push((id, (role, of))),
        }
        true
    }

    #[inline]
    pub const fn has_shared(&self) -> bool {
        self.has_shared
    }

    #[inline]
    pub fn get(&self, id: CanId) -> Option<(Role, Of)> {
        match id {
            CanId::Standard(id) => self.standard.get(usize::from(id)).copied().flatten(),
            CanId::Extended(id) => self.extended.iter().find(|(known, _)| *known == id).map(|&(_, entry)| entry),
        }
    }
}
