//! Everything on the far side of the stack's connector: the wire, the drives,
//! the plant. It goes on in steps, one a period of the stack's, in virtual time.
//!
//! The frame that begins the stack's period, a SYNC or the first of those that
//! stand in for one, takes it to the next multiple of the period. It runs until
//! all frames of that beginning have come and both drives have answered. What
//! the stack sends enters the wire at the moment it stands at. So whoever hands it the same frames in the same
//! order gets the same answers at the same moments, whatever lies between: a
//! function call, a socket, a real bus.

use std::collections::VecDeque;

use canloop::event::{BusFrame, Mark};
use canloop::frame::Frame;
use canloop::time::{Duration, Instant};
use canloop::wheels::{Wheel, Wheels};

use crate::plant::State;
use crate::scenario::Scenario;
use crate::timeline::Timeline;
use crate::virtual_robot::VirtualRobot;
use crate::wire::{Node, Wire, WireStats};

/// Wire, drives and plant.
pub struct FarSide {
    wire: Wire,
    robot: VirtualRobot,
    period: Duration,
    now: Instant,
    /// When the next period is due to begin.
    next_tick: Instant,
    step: Step,
    /// Feedback that drives have sent and the wire has yet to deliver.
    unanswered: u32,
    happenings: VecDeque<(Instant, Happening)>,
    timeline: Timeline,
}

/// Something that happened on the far side.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant, reason = "they live in a reused queue; a box would allocate every frame")]
pub enum Happening {
    /// A frame crossed the wire. What the stack did not send itself is now
    /// its to take.
    Frame(BusFrame),
    /// A period began for the drives.
    Synced(Synced),
    /// The drives have answered: nothing more comes before the next period.
    Answered,
    /// An event of the scenario began or ended.
    Marked(Mark),
}

/// How far a step has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// The frame that begins it is on its way.
    Awaited,
    /// It has begun.
    Begun,
    /// It is over.
    Over,
}

/// The robot at the beginning of a period.
#[derive(Clone, Copy, Debug)]
pub struct Synced {
    /// Periods since the first.
    pub tick: u64,
    /// The plant's state.
    pub state: State,
    /// Mean torque at the wheels over the period that has ended, N m.
    pub torque_nm: Wheels<f64>,
    /// The period in which the path began, if it has, as far as drives know.
    pub path_began: Option<u64>,
}

impl FarSide {
    /// The far side of `scenario`, on a bus of this bit rate, before the
    /// first SYNC, which is due at `start`.
    pub fn new(scenario: &Scenario, bitrate_bit_s: u32, start: Instant) -> Self {
        let robot = scenario.virtual_robot(start);
        Self {
            timeline: Timeline::new(&scenario.events, &robot),
            robot,
            wire: Wire::new(bitrate_bit_s),
            period: scenario.stack.period,
            now: start,
            next_tick: start,
            step: Step::Over,
            unanswered: 0,
            happenings: VecDeque::with_capacity(32),
        }
    }

    /// Takes a frame that the stack sends. The one that begins its period makes
    /// a step.
    pub fn take(&mut self, frame: Frame) {
        if self.robot.profile().begins_period(&frame) {
            let tick = self.next_tick;
            self.next_tick += self.period;
            while self.happen_until(tick) {}
            self.now = self.now.max(tick);
            self.step = Step::Awaited;
        }
        self.wire.send(self.now, Node::Stack, frame);
        if self.step != Step::Over {
            self.go_on();
        }
    }

    /// What is planned for the period that has begun; the plant stands at its
    /// beginning.
    fn let_events_happen(&mut self, at: Instant) {
        let Self { timeline, robot, happenings, period, .. } = self;
        let t_s = (robot.ticks() - 1) as f64 * period.as_secs_f64();
        timeline.go_on(t_s, robot, |mark| happenings.push_back((at, Happening::Marked(mark))));
    }

    /// Goes on with a step that has begun: to its end, or until the stack must
    /// send more.
    fn go_on(&mut self) {
        while !self.has_been_answered() {
            let waits_for_more = self.robot.awaited() > 0 && !self.wire.has_queued(Node::Stack);
            if (self.step == Step::Begun && waits_for_more) || !self.happen_until(self.next_tick) {
                break;
            }
        }
        if self.step == Step::Begun && self.robot.awaited() == 0 {
            self.step = Step::Over;
            self.happenings.push_back((self.now, Happening::Answered));
        }
    }

    fn has_been_answered(&self) -> bool {
        self.step == Step::Begun
            && self.robot.awaited() == 0
            && self.unanswered == 0
            && self.robot.next_feedback() >= self.next_tick
    }

    /// Lets what is on the wire cross it, up to the moment at which the next
    /// period is due: for the end of a run.
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

    /// The robot, for something to go wrong with it.
    pub const fn robot_mut(&mut self) -> &mut VirtualRobot {
        &mut self.robot
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
            self.unanswered -= u32::from(self.robot.profile().is_feedback(frame.id));
        } else if self.robot.handle_frame(&frame, self.period.as_secs_f64()) {
            let synced = Synced {
                tick: self.robot.ticks() - 1,
                state: *self.robot.state(),
                torque_nm: self.robot.torque_applied_nm(),
                path_began: self.robot.path_began(),
            };
            self.step = Step::Begun;
            self.happenings.push_back((at, Happening::Synced(synced)));
            self.let_events_happen(at);
        }
    }

    fn send_what_drives_say(&mut self) {
        while let Some((wheel, frame)) = self.robot.poll_transmit() {
            let node = match wheel {
                Wheel::Right => Node::Right,
                Wheel::Left => Node::Left,
            };
            self.unanswered += u32::from(self.robot.profile().is_feedback(frame.id));
            self.wire.send(self.now, node, frame);
        }
    }
}
