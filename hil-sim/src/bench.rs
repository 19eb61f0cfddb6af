//! The test bench: stack, bus and virtual robot in one process, in virtual
//! time.
//!
//! What happens at the same instant happens in a fixed order: frames arrive
//! before anybody wakes up, and drives wake up before the stack. With the bus's
//! own arbitration this makes a run a function of its scenario alone.

use std::ops::ControlFlow;

use canloop::event::{BusFrame, Event, Sink, Truth};
use canloop::robot::{Pose, wrap_angle_rad};
use canloop::stack::{Operator, Stack};
use canloop::time::Instant;
use canloop::wheels::{Wheel, Wheels};

use crate::ideal;
use crate::plant::State;
use crate::scenario::{Link, Scenario};
use crate::virtual_robot::VirtualRobot;
use crate::wire::{Node, Wire, WireStats};

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Why it ended.
    pub end: End,
    /// Periods simulated.
    pub ticks: u64,
    /// What crossed the bus; nothing on an ideal link.
    pub wire: WireStats,
    /// The stack's last state; none on an ideal link.
    pub state: Option<canloop::safety::State>,
}

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Its time was up.
    Finished,
    /// The robot was further from its path than any robot comes back from.
    Diverged,
    /// The bus was so slow that no SYNC came through any more.
    Blocked,
    /// Somebody wanted it to.
    Interrupted,
}

/// Position error beyond which there is nothing left to see, m.
pub const DIVERGED_M: f64 = 1000.0;

/// Torque beyond which no law comes back, N m; only an ideal link has no limit
/// that would stop it earlier.
pub const DIVERGED_NM: f64 = 1e9;

/// SYNCs that may be on their way before the bus is said to be blocked: more
/// than its queues hold, by far.
const BLOCKED_PERIODS: u64 = 1000;

/// Runs a scenario to its end. `progress` is called once a period and may
/// break the run off.
pub fn run(scenario: &Scenario, sink: &mut impl Sink, progress: impl FnMut(u64) -> ControlFlow<()>) -> Outcome {
    match scenario.link {
        Link::Ideal => ideal::run(scenario, sink, progress),
        Link::Can { bitrate_bit_s } => Bench::new(scenario, bitrate_bit_s, sink).run(scenario.ticks(), progress),
    }
}

/// The truth at the beginning of a period.
pub(crate) fn truth(tick: u64, state: &State, reference: &Pose, torque_nm: Wheels<f64>) -> Truth {
    Truth {
        tick,
        pose: state.pose,
        position_error_m: state.pose.distance_m(reference),
        heading_error_rad: wrap_angle_rad(state.pose.heading_rad - reference.heading_rad),
        angle_rad: state.angle_rad,
        speed_rad_s: state.speed_rad_s,
        torque_nm,
    }
}

/// Whether a robot is lost for good.
pub(crate) fn is_lost(truth: &Truth) -> bool {
    truth.position_error_m.is_nan() || truth.position_error_m > DIVERGED_M
}

struct Bench<'s, S> {
    stack: Stack,
    robot: VirtualRobot,
    wire: Wire,
    sink: &'s mut S,
    now: Instant,
    /// The last SYNC sent.
    last_sync: u64,
    /// Where the path wanted the robot then.
    reference: Pose,
    /// The truth at the last SYNC that arrived.
    truth: Option<Truth>,
}

impl<'s, S: Sink> Bench<'s, S> {
    fn new(scenario: &Scenario, bitrate_bit_s: u32, sink: &'s mut S) -> Self {
        let start = Instant::ZERO;
        let mut stack = Stack::new(&scenario.stack, start);
        stack.operate(Operator::Enable);
        let profile = scenario.stack.profile.clone();
        let (plant, spec) = (scenario.plant(), scenario.drive_spec());
        Self {
            stack,
            robot: VirtualRobot::new(profile, plant, spec, scenario.period_s(), start),
            wire: Wire::new(bitrate_bit_s),
            sink,
            now: start,
            last_sync: 0,
            reference: scenario.stack.controller.path.start(),
            truth: None,
        }
    }

    fn run(mut self, ticks: u64, mut progress: impl FnMut(u64) -> ControlFlow<()>) -> Outcome {
        let end = loop {
            self.drain();
            self.step();
            if self.last_sync > self.robot.ticks() + BLOCKED_PERIODS {
                break End::Blocked;
            }
            let Some(truth) = self.truth.take() else { continue };
            if is_lost(&truth) {
                break End::Diverged;
            }
            if truth.tick >= ticks {
                break End::Finished;
            }
            if progress(truth.tick).is_break() {
                break End::Interrupted;
            }
        };
        let ticks = self.robot.ticks().saturating_sub(1);
        Outcome { end, ticks, wire: *self.wire.stats(), state: Some(self.stack.state()) }
    }

    /// Takes everything that the last step made.
    fn drain(&mut self) {
        while let Some(event) = self.stack.poll_event() {
            if let Event::Sync(sync) = &event {
                self.last_sync = sync.tick;
                self.reference = sync.reference;
            }
            self.sink.event(self.now, &event);
        }
        while let Some(frame) = self.stack.poll_transmit() {
            self.wire.send(self.now, Node::Stack, frame);
        }
        while let Some((wheel, frame)) = self.robot.poll_transmit() {
            let node = match wheel {
                Wheel::Right => Node::Right,
                Wheel::Left => Node::Left,
            };
            self.wire.send(self.now, node, frame);
        }
    }

    /// Goes on to the next instant at which something happens, and lets it.
    fn step(&mut self) {
        let wakeup = self.stack.next_wakeup().min(self.robot.next_wakeup());
        if self.wire.next_arrival().is_some_and(|arrival| arrival <= wakeup) {
            return self.deliver();
        }
        self.now = wakeup;
        if self.robot.next_wakeup() == wakeup {
            self.robot.handle_wakeup(wakeup);
        } else {
            self.stack.handle_wakeup(wakeup);
        }
    }

    fn deliver(&mut self) {
        let Some((at, sender, frame)) = self.wire.deliver() else { return };
        self.now = at;
        let sent_by_stack = sender == Node::Stack;
        self.sink.event(at, &Event::Frame(BusFrame { bus: 0, sent_by_stack, frame }));
        if !sent_by_stack {
            self.stack.handle_frame(at, &frame);
        } else if self.robot.handle_frame(&frame) {
            let tick = self.robot.ticks() - 1;
            let truth = truth(tick, self.robot.state(), &self.reference, self.robot.torque_applied_nm());
            self.sink.event(at, &Event::Truth(truth));
            self.truth = Some(truth);
        }
    }
}
