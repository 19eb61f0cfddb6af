//! Everything on the far side of the stack's connector: the wire, the drives,
//! the plant. It goes on in steps, one a period of the stack's, in virtual time.
//!
//! The frame that begins the stack's period, a SYNC or the first of those that
//! stand in for one, takes it to the next multiple of the period. It runs until
//! all frames of that beginning have crossed or are lost, and so has all that
//! the drives have to say of it, but never past the next multiple. What the
//! stack sends enters the wire at the moment it stands at. So whoever hands it
//! the same frames in the same order gets the same answers at the same moments,
//! whatever lies between: a function call, a socket, a real bus.
//!
//! The plant moves on by one period in each step, whatever becomes of frames:
//! when the first of those that begin a period arrives, or else at the end.

use canloop::bus::{BitRates, ControllerState};
use canloop::event::{BusFrame, Mark, Notice};
use canloop::fifo::Fifo;
use canloop::frame::Frame;
use canloop::time::{Duration, Instant};
use canloop::wheels::{Wheel, Wheels};

use crate::plant::State;
use crate::scenario::Scenario;
use crate::timeline::{Stage, Timeline};
use crate::virtual_robot::VirtualRobot;
use crate::wire::{Crossing, Fault, FaultId, Node, Nodes, Pick, Recovery, Wire, WireStats};

/// Wire, drives and plant.
pub struct FarSide {
    wire: Wire,
    robot: VirtualRobot,
    period: Duration,
    now: Instant,
    /// When the next period is due to begin.
    next_tick: Instant,
    /// Whether a step goes on.
    is_in_step: bool,
    /// Frames of this step's beginning that the stack has yet to send.
    to_come: u32,
    /// Whether the plant has moved on in this step.
    has_moved_on: bool,
    happenings: Fifo<(Instant, Happening)>,
    timeline: Timeline,
}

/// Something that happened on the far side.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant, reason = "they live in a reused queue; a box would allocate every frame")]
pub enum Happening {
    /// A frame crossed the wire. What the stack did not send itself is now
    /// its to take.
    Frame(BusFrame),
    /// A frame crossed the wire where the stack could not hear it.
    Unheard(BusFrame),
    /// A period began for the plant, and for those drives that know of it.
    Synced(Synced),
    /// The state of the stack's own controller changed.
    Controller(ControllerState),
    /// The step is over: nothing more comes before the next period. The stack
    /// is to be told the state of its controller.
    Answered(ControllerState),
    /// An event of the scenario began or ended.
    Marked(Mark),
}

/// The robot at the beginning of a period.
#[derive(Clone, Copy, Debug)]
pub struct Synced {
    /// Periods since the first.
    pub tick: u64,
    /// Whether a frame said so, or the period went by without.
    pub is_heard: bool,
    /// The plant's state.
    pub state: State,
    /// Mean torque at the wheels over the period that has ended, N m.
    pub torque_nm: Wheels<f64>,
    /// The period in which the path began, if it has, as far as drives know.
    pub path_began: Option<u64>,
}

/// For how long the stack's controller stays off the bus at least, as `canloop
/// doctor` wants it set up (`restart-ms 100`).
const RESTART: Duration = Duration::from_millis(100);

impl FarSide {
    /// The far side of `scenario`, on a bus of these bit rates, before the
    /// first SYNC, which is due at `start`.
    pub fn new(scenario: &Scenario, rates: BitRates, start: Instant) -> Self {
        let mut wire = Wire::new(rates, scenario.seed);
        if scenario.bus_delay > Duration::ZERO {
            wire.begin(start, Fault::Delay(Pick::ALL, scenario.bus_delay));
        }
        let robot = scenario.virtual_robot(start);
        Self {
            timeline: Timeline::new(&scenario.events, &robot),
            robot,
            wire: wire.with_recovery(Node::Stack, Recovery::After(RESTART)),
            period: scenario.stack.period,
            now: start,
            next_tick: start,
            is_in_step: false,
            to_come: 0,
            has_moved_on: true,
            happenings: Fifo::with_capacity(32),
        }
    }

    /// Takes a frame that the stack sends. The one that begins its period makes
    /// a step.
    pub fn take(&mut self, frame: Frame) {
        let begins = self.robot.profile().begins_period(&frame);
        if begins {
            self.begin_step();
        }
        let is_of_beginning = begins || self.is_of_beginning(&frame);
        self.to_come -= u32::from(is_of_beginning && self.to_come > 0);
        self.wire.send(self.now, Node::Stack, frame, is_of_beginning);
        if self.is_in_step {
            self.go_on();
        }
    }

    fn begin_step(&mut self) {
        if self.is_in_step {
            self.end_step();
        }
        let tick = self.next_tick;
        self.next_tick += self.period;
        while self.happen_until(tick) {}
        self.now = self.now.max(tick);
        self.is_in_step = true;
        self.has_moved_on = false;
        self.to_come = self.robot.profile().frames_at_beginning();
    }

    /// Whether a frame is one of those that a step still waits for.
    fn is_of_beginning(&self, frame: &Frame) -> bool {
        let profile = self.robot.profile();
        self.to_come > 0 && profile.decode(frame).is_ok_and(|message| profile.is_at_beginning(&message))
    }

    /// Goes on with a step that has begun: to its end, or until the stack must
    /// send more.
    fn go_on(&mut self) {
        while !self.has_been_answered() {
            if self.waits_for_more() || !self.happen_until(self.next_tick) {
                break;
            }
        }
        if !self.waits_for_more() {
            self.end_step();
        }
    }

    fn waits_for_more(&self) -> bool {
        self.to_come > 0 && !self.wire.has_queued(Node::Stack)
    }

    fn has_been_answered(&self) -> bool {
        self.to_come == 0 && self.wire.awaited() == 0 && self.robot.next_feedback() >= self.next_tick
    }

    /// What has not come until now comes too late for this step.
    fn end_step(&mut self) {
        self.is_in_step = false;
        if !std::mem::replace(&mut self.has_moved_on, true) {
            self.robot.begin_period(self.period.as_secs_f64());
            self.tell_period(self.now, false);
        }
        self.robot.end_period();
        self.send_what_drives_say();
        self.tell_changes();
        let state = self.wire.confinement(Node::Stack).state();
        self.happenings.push((self.now, Happening::Answered(state)));
    }

    /// Lets what is on the wire cross it, up to the moment at which the next
    /// period is due: for the end of a run.
    pub fn settle(&mut self) {
        while self.happen_until(self.next_tick) {}
    }

    /// The next thing that happened, in order of time.
    pub fn poll(&mut self) -> Option<(Instant, Happening)> {
        self.happenings.pop()
    }

    /// When the next thing to be polled happened.
    pub fn peek(&self) -> Option<Instant> {
        self.happenings.front().map(|&(at, _)| at)
    }

    /// The robot, for something to go wrong with it.
    pub const fn robot_mut(&mut self) -> &mut VirtualRobot {
        &mut self.robot
    }

    /// The wire.
    pub const fn wire(&self) -> &Wire {
        &self.wire
    }

    /// Lets something go wrong with the wire, from the moment on that it
    /// stands at.
    pub fn begin_fault(&mut self, fault: Fault) -> FaultId {
        self.wire.begin(self.now, fault)
    }

    /// Lets it end; says whether it was going on.
    pub fn end_fault(&mut self, id: FaultId) -> bool {
        self.wire.end(self.now, id)
    }

    /// What has crossed the wire so far.
    pub fn wire_stats(&self) -> WireStats {
        self.wire.stats()
    }

    /// Lets the next thing happen that happens before `limit` or at it. At
    /// one instant frames arrive before a drive wakes up.
    fn happen_until(&mut self, limit: Instant) -> bool {
        let wakeup = self.robot.next_wakeup();
        let on_the_wire = self.wire.next_event().filter(|&event| event <= wakeup);
        let next = on_the_wire.unwrap_or(wakeup);
        if next > limit {
            return false;
        }
        self.now = self.now.max(next);
        if on_the_wire.is_some() {
            match self.wire.advance() {
                Some(crossing) => self.deliver(&crossing),
                None => self.tell_changes(),
            }
        } else {
            self.robot.handle_wakeup(wakeup);
        }
        self.send_what_drives_say();
        true
    }

    fn deliver(&mut self, crossing: &Crossing) {
        let Crossing { at, sender, heard_by, .. } = *crossing;
        let sent_by_stack = sender == Node::Stack;
        let is_heard = sent_by_stack || heard_by.contains(Node::Stack);
        let frame = crossing.as_heard_by(Node::Stack).unwrap_or(crossing.frame);
        let crossed = BusFrame { bus: 0, sent_by_stack, frame };
        self.happenings.push((at, if is_heard { Happening::Frame(crossed) } else { Happening::Unheard(crossed) }));
        self.tell_changes();
        // Drives do not listen to each other.
        if sent_by_stack || sender == Node::Intruder {
            match crossing.altered() {
                None => self.reach_drives(at, &crossing.frame, heard_by),
                Some((nodes, altered)) => {
                    self.reach_drives(at, &crossing.frame, heard_by.without(nodes));
                    self.reach_drives(at, &altered, heard_by.among(nodes));
                }
            }
        }
    }

    fn reach_drives(&mut self, at: Instant, frame: &Frame, nodes: Nodes) {
        if nodes.among(Nodes::DRIVES).is_empty() {
            return;
        }
        let reaches = Wheels { right: nodes.contains(Node::Right), left: nodes.contains(Node::Left) };
        let span_s = (!self.has_moved_on).then(|| self.period.as_secs_f64());
        if self.robot.handle_frame_at(frame, reaches, span_s) {
            self.has_moved_on = true;
            self.tell_period(at, true);
        }
    }

    fn tell_period(&mut self, at: Instant, is_heard: bool) {
        let synced = Synced {
            tick: self.robot.ticks() - 1,
            is_heard,
            state: *self.robot.state(),
            torque_nm: self.robot.torque_applied_nm(),
            path_began: self.robot.path_began(),
        };
        self.happenings.push((at, Happening::Synced(synced)));
        self.let_events_happen(at);
    }

    /// What is planned for the period that has begun; the plant stands at its
    /// beginning.
    fn let_events_happen(&mut self, at: Instant) {
        let Self { timeline, robot, wire, happenings, now, .. } = self;
        let t_s = (robot.ticks() - 1) as f64 * self.period.as_secs_f64();
        let tell = |mark| happenings.push((at, Happening::Marked(mark)));
        timeline.go_on(t_s, &mut Stage { robot, wire, now: *now }, tell);
    }

    fn tell_changes(&mut self) {
        while let Some(change) = self.wire.poll_change() {
            if change.node == Node::Stack {
                self.happenings.push((self.now, Happening::Controller(change.state)));
            }
        }
    }

    fn send_what_drives_say(&mut self) {
        while let Some((wheel, frame)) = self.robot.poll_transmit() {
            let node = match wheel {
                Wheel::Right => Node::Right,
                Wheel::Left => Node::Left,
            };
            let is_awaited = self.robot.profile().is_feedback(frame.id);
            self.wire.send(self.now, node, frame, is_awaited);
        }
    }
}

/// What is said of a change of the stack's own controller.
pub fn controller_notice(state: ControllerState) -> Notice {
    let text = match state {
        ControllerState::ErrorActive => "the stack's CAN controller takes part as usual again",
        ControllerState::ErrorWarning => "the stack's CAN controller has counted many errors",
        ControllerState::ErrorPassive => "the stack's CAN controller is error-passive",
        ControllerState::BusOff => "the stack's CAN controller went off the bus",
    };
    Notice { kind: state.word(), text }
}
