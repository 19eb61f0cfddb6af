//! What crosses the bus again and again while a robot is in motion.

use super::{Acts, Asks, Profile};
use crate::frame::{CanId, FrameKind};
use crate::schema::role_table::Role;
use crate::time::Duration;

/// A message that is sent again and again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Recurring {
    /// Arbitration id.
    pub id: CanId,
    /// Data frame or remote request.
    pub kind: FrameKind,
    /// How often it is sent.
    pub cycle: Duration,
    /// What makes its sender send it.
    pub cause: Cause,
}

/// What makes a sender send.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The stack's period begins.
    Beginning,
    /// The stack asked: it is a drive's answer.
    Asked,
    /// All drives have answered: it is the stack's.
    Answered,
    /// A drive's own clock.
    OwnClock,
}

impl Profile {
    /// What crosses the bus again and again, when the stack's period is
    /// `period`, with the stack's messages in the order in which it sends them.
    /// Each part of feedback that is asked for by a remote request has that of
    /// the same id before it. What is said once, such as a fault or a word
    /// that enables a drive, is left out.
    pub fn traffic(&self, period: Duration) -> Vec<Recurring> {
        let mut traffic = Vec::new();
        let mut add = |id, kind, cycle, cause| traffic.push(Recurring { id, kind, cycle, cause });
        let of_command = if self.acts == Acts::OnArrival { Cause::Beginning } else { Cause::Answered };
        self.list_roles(|id, role, _| match role {
            Role::Sync => add(id, FrameKind::Classic, period, Cause::Beginning),
            Role::Command => add(id, FrameKind::Classic, period, of_command),
            Role::Feedback(_) if self.asks == Asks::Nothing => {
                add(id, FrameKind::Classic, self.feedback_period.unwrap_or(period), Cause::OwnClock);
            }
            Role::Feedback(_) => {
                if self.asks == Asks::ByPoll {
                    add(id, FrameKind::Remote, period, Cause::Beginning);
                }
                add(id, FrameKind::Classic, period, Cause::Asked);
            }
            Role::Heartbeat => {
                self.heartbeat_period.into_iter().for_each(|cycle| add(id, FrameKind::Classic, cycle, Cause::OwnClock));
            }
            Role::Fault | Role::Word => {}
        });
        traffic
    }
}
