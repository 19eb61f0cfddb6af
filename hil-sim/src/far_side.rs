//! Everything on the far side of the stack's connector: the wire, the drives,
//! the plant. It goes on in steps, one a SYNC, in virtual time.
//!
//! A SYNC takes it to the next multiple of the period and lets it run until
//! both drives have answered. What the stack sends in between enters the wire
//! at the moment it stands at. So whoever hands it the same frames in the same
//! order gets the same answers at the same moments, whatever lies between: a
//! function call, a socket, a real bus.

use std::collections::VecDeque;

use canloop::event::BusFrame;
use canloop::frame::{CanId, Frame};
use canloop::time::{Duration, Instant};
use canloop::wheels::{Wheel, Wheels};

use crate::plant::State;
use crate::scenario::Scenario;
use crate::virtual_robot::VirtualRobot;
use crate::wire::{Node, Wire, WireStats};

/// Wire, drives and plant.
pub struct FarSide {
    wire: Wire,
    robot: VirtualRobot,
    period: Duration,
    sync_id: CanId,
    feedback_ids: Wheels<CanId>,
    now: Instant,
    /// When the next SYNC is due.
    next_tick: Instant,
    /// Feedback that drives have sent and the wire has yet to deliver.
    unanswered: u32,
    happenings: VecDeque<(Instant, Happening)>,
}

/// Something that happened on the far side.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant, reason = "they live in a reused queue; a box would allocate every frame")]
pub enum Happening {
    /// A frame crossed the wire. What the stack did not send itself is now
    /// its to take.
    Frame(BusFrame),
    /// A SYNC reached the drives: a period began.
    Synced(Synced),
}

/// The robot at the beginning of a period.
#[derive(Clone, Copy, Debug)]
pub struct Synced {
    /// Periods since the first SYNC.
    pub tick: u64,
    /// The plant's state.
    pub state: State,
    /// Mean torque at the wheels over the period that has ended, N m.
    pub torque_nm: Wheels<f64>,
    /// Whether both drives are enabled.
    pub enabled: bool,
}

impl FarSide {
    /// The far side of `scenario`, on a bus of this bit rate, before the
    /// first SYNC, which is due at `start`.
    pub fn new(scenario: &Scenario, bitrate_bit_s: u32, start: Instant) -> Self {
        let profile = scenario.stack.profile.clone();
        Self {
            sync_id: profile.sync_id(),
            feedback_ids: Wheels::from_fn(|wheel| profile.feedback_id(wheel)),
            robot: VirtualRobot::new(profile, scenario.plant(), scenario.drive_spec(), start),
            wire: Wire::new(bitrate_bit_s),
            period: scenario.stack.period,
            now: start,
            next_tick: start,
            unanswered: 0,
            happenings: VecDeque::with_capacity(32),
        }
    }

    /// Takes a frame that the stack sends. A SYNC makes a step.
    pub fn take(&mut self, frame: Frame) {
        if frame.id != self.sync_id {
            return self.wire.send(self.now, Node::Stack, frame);
        }
        let tick = self.next_tick;
        self.next_tick += self.period;
        while self.happen_until(tick) {}
        self.now = self.now.max(tick);
        self.wire.send(self.now, Node::Stack, frame);
        let mut synced = false;
        while !(synced && self.unanswered == 0) && self.happen_until(self.next_tick) {
            synced |= self.unanswered > 0;
        }
    }

    /// Lets what is on the wire cross it, up to the moment at which the next
    /// SYNC is due: for the end of a run.
    pub fn settle(&mut self) {
        while self.happen_until(self.next_tick) {}
    }

    /// The next thing that happened, in order of time.
    pub fn poll(&mut self) -> Option<(Instant, Happening)> {
        self.happenings.pop_front()
    }

    /// When the next thing to be polled happened.
    pub fn peek(&self) -> Option<Instant> {
        self.happenings.front().map(|&(at, _)| at)
    }

    /// What has crossed the wire so far.
    pub const fn wire_stats(&self) -> &WireStats {
        self.wire.stats()
    }

    /// Lets the next thing happen that happens before `limit` or at it. At
    /// one instant frames arrive before a drive wakes up.
    fn happen_until(&mut self, limit: Instant) -> bool {
        let wakeup = self.robot.next_wakeup();
        let arrival = self.wire.next_arrival().filter(|&arrival| arrival <= wakeup);
        let next = arrival.unwrap_or(wakeup);
        if next > limit {
            return false;
        }
        self.now = self.now.max(next);
        if arrival.is_some() {
            self.deliver();
        } else {
            self.robot.handle_wakeup(wakeup);
        }
        self.send_what_drives_say();
        true
    }

    fn deliver(&mut self) {
        let Some((at, sender, frame)) = self.wire.deliver() else { return };
        let sent_by_stack = sender == Node::Stack;
        self.happenings.push_back((at, Happening::Frame(BusFrame { bus: 0, sent_by_stack, frame })));
        if !sent_by_stack {
            self.unanswered -= u32::from(self.is_feedback(&frame));
        } else if self.robot.handle_frame(&frame, self.period.as_secs_f64()) {
            let synced = Synced {
                tick: self.robot.ticks() - 1,
                state: *self.robot.state(),
                torque_nm: self.robot.torque_applied_nm(),
                enabled: self.robot.is_enabled(),
            };
            self.happenings.push_back((at, Happening::Synced(synced)));
        }
    }

    fn send_what_drives_say(&mut self) {
        while let Some((wheel, frame)) = self.robot.poll_transmit() {
            let node = match wheel {
                Wheel::Right => Node::Right,
                Wheel::Left => Node::Left,
            };
            self.unanswered += u32::from(self.is_feedback(&frame));
            self.wire.send(self.now, node, frame);
        }
    }

    fn is_feedback(&self, frame: &Frame) -> bool {
        self.feedback_ids.any(|&id| id == frame.id)
    }
}
