//! The test bench: the stack and its far side in one process, in lock-step.

use std::ops::ControlFlow;

use canloop::bus::{BitRates, ControllerState};
use canloop::event::{Event, Mark, Sink, Truth};
use canloop::robot::{Pose, wrap_angle_rad};
use canloop::safety::{Operator, Reason};
use canloop::stack::Stack;
use canloop::time::Instant;
use canloop::wheels::Wheels;

use crate::far_side::{FarSide, Happening, controller_notice};
use crate::ideal;
use crate::plant::State;
use crate::scenario::{Link, Scenario};
use crate::wire::WireStats;

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
    /// The controller on the bus was silent for too long.
    Silent,
    /// Somebody wanted it to, or the bus was lost.
    Interrupted,
}

/// Position error beyond which there is nothing left to see, m.
pub const DIVERGED_M: f64 = 1000.0;

/// Torque beyond which no law comes back, N m; only an ideal link has no limit
/// that would stop it earlier.
pub const DIVERGED_NM: f64 = 1e9;

/// Periods without a SYNC after which a bus on which nothing is wrong is said
/// to be blocked: more than its queues hold, by far.
const BLOCKED_PERIODS: u64 = 1000;

/// Runs a scenario to its end. `progress` is called once a period and may
/// break the run off.
pub fn run(scenario: &Scenario, sink: &mut impl Sink, progress: impl FnMut(u64) -> ControlFlow<()>) -> Outcome {
    match scenario.link {
        Link::Ideal => ideal::run(scenario, sink, progress),
        Link::Can(rates) => Bench::new(scenario, rates, sink).run(scenario.ticks(), progress),
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
    scenario: &'s Scenario,
    stack: Stack,
    far_side: FarSide,
    sink: &'s mut S,
    /// The stack's time: that of the period which it began last.
    now: Instant,
    /// Where the path wanted the robot at the last SYNC sent.
    reference: Pose,
    /// The truth at the beginning of the last period.
    truth: Option<Truth>,
    /// The last period whose SYNC arrived.
    heard_tick: u64,
}

impl<'s, S: Sink> Bench<'s, S> {
    fn new(scenario: &'s Scenario, rates: BitRates, sink: &'s mut S) -> Self {
        let start = Instant::ZERO;
        let mut stack = Stack::new(&scenario.stack, start);
        if sink.wants_exchange() {
            stack.tell_exchange();
        }
        stack.operate(Operator::Enable);
        Self {
            scenario,
            stack,
            far_side: FarSide::new(scenario, rates, start),
            sink,
            now: start,
            reference: scenario.stack.controller.path.start(),
            truth: None,
            heard_tick: 0,
        }
    }

    fn run(mut self, ticks: u64, mut progress: impl FnMut(u64) -> ControlFlow<()>) -> Outcome {
        let mut tick = 0;
        let end = loop {
            self.step();
            if self.truth.as_ref().is_some_and(is_lost) {
                break End::Diverged;
            }
            if tick > BLOCKED_PERIODS + self.heard_tick && self.far_side.wire().is_untouched() {
                break End::Blocked;
            }
            if tick >= ticks {
                break End::Finished;
            }
            if progress(tick).is_break() {
                break End::Interrupted;
            }
            tick += 1;
        };
        Outcome { end, ticks: tick, wire: self.far_side.wire_stats(), state: Some(self.stack.state()) }
    }

    /// One period: the stack wakes up, the far side makes a step, the stack
    /// takes what came of it. What it has to say waits until what happened
    /// before is told.
    fn step(&mut self) {
        let now = self.stack.next_wakeup();
        self.now = now;
        self.stack.handle_wakeup(now);
        self.hand_over();
        while self.far_side.peek().is_some_and(|at| at < now) {
            self.take_happening();
        }
        self.tell(now);
        while self.far_side.peek().is_some() {
            self.take_happening();
        }
    }

    fn take_happening(&mut self) {
        match self.far_side.poll() {
            Some((at, Happening::Frame(crossed))) => {
                self.sink.event(at, &Event::Frame(crossed));
                if !crossed.sent_by_stack {
                    // In lock-step nothing moves between two beginnings.
                    self.stack.handle_frame(self.now, &crossed.frame);
                    self.hand_over();
                    self.tell(at);
                }
            }
            Some((at, Happening::Synced(synced))) => {
                let truth = truth(synced.tick, &synced.state, &self.reference, synced.torque_nm);
                self.sink.event(at, &Event::Truth(truth));
                self.truth = Some(truth);
                if synced.is_heard {
                    self.heard_tick = synced.tick;
                }
            }
            Some((at, Happening::Unheard(crossed))) => self.sink.event(at, &Event::Frame(crossed)),
            Some((at, Happening::Controller(state))) => self.sink.event(at, &Event::Notice(controller_notice(state))),
            Some((at, Happening::Answered(state))) => self.end_step(at, state),
            Some((at, Happening::Marked(mark))) => self.take_mark(at, mark),
            None => {}
        }
    }

    /// The stack hears how its controller is when the step is over; what it has
    /// to say to that goes with the next one.
    fn end_step(&mut self, at: Instant, state: ControllerState) {
        if state == ControllerState::BusOff {
            self.stack.trip(Reason::BusOff);
            self.tell(at);
        }
    }

    /// Something planned began or ended; where it is the operator's doing, the
    /// stack is told.
    fn take_mark(&mut self, at: Instant, mark: Mark) {
        self.sink.event(at, &Event::Mark(mark));
        let planned = &self.scenario.events[usize::from(mark.event)];
        if mark.has_begun {
            planned.operator().into_iter().for_each(|wish| self.stack.operate(wish));
            planned.new_path().into_iter().for_each(|path| self.stack.follow(path.clone(), mark.event));
        }
    }

    /// Gives the far side what the stack has sent.
    fn hand_over(&mut self) {
        while let Some(frame) = self.stack.poll_transmit() {
            self.far_side.take(frame);
        }
    }

    fn tell(&mut self, at: Instant) {
        while let Some(event) = self.stack.poll_event() {
            if let Event::Sync(sync) = &event {
                self.reference = sync.reference;
            }
            self.sink.event(at, &event);
        }
    }
}
