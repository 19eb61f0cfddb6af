//! The control stack: frames and moments in, frames and events out.
//!
//! It opens no socket, waits for nothing and reads no clock. A runtime drives
//! it: hand it what happens ([`Stack::handle_frame`], [`Stack::handle_wakeup`],
//! [`Stack::operate`]), then drain [`Stack::poll_transmit`] and
//! [`Stack::poll_event`], then wait for a frame or for [`Stack::next_wakeup`],
//! whichever comes first.
//!
//! Once a period T it sends SYNC. Drives latch their encoders at it and answer;
//! when both have, the control law runs and the torques for the next period
//! leave. Whatever the host's jitter, a torque acts exactly one period after
//! the positions it was made from.

use std::collections::VecDeque;

use crate::control::{Controller, Decision, Measured, Sampling};
use crate::event::{Event, Notice, SyncEvent, Tick};
use crate::frame::Frame;
use crate::odometry::Odometry;
use crate::safety::{Gate, Reason, State};
use crate::schema::{Command, DecodeError, DriveState, FaultCode, Feedback, Message, Profile, Request};
use crate::time::{Duration, Instant};
use crate::wheels::{Wheel, Wheels};

mod config;

pub use config::{DriveConfig, RobotFile, StackConfig};

/// The control stack of a two-wheeled robot.
pub struct Stack {
    period: Duration,
    profile: Profile,
    controller: Controller,
    odometry: Odometry,
    gate: Gate,
    drives: Wheels<DriveView>,
    /// Periods begun.
    ticks: u64,
    /// Those of them whose feedback was complete.
    ticks_answered: u64,
    next_sync: Instant,
    /// Whether the law has yet to answer the period that has begun.
    awaiting_feedback: bool,
    /// Odd frames that may still be noted in this period.
    oddities_left: u8,
    /// Periods since feedback from both drives was last complete.
    periods_since_feedback: u32,
    enable_wanted: bool,
    clear_fault_wanted: bool,
    sync_counter: u8,
    /// Counter of the last SYNC sent.
    sync_sent: u8,
    /// When that was.
    sync_at: Instant,
    /// When the SYNC was whose feedback was answered last.
    sampled_at: Option<Instant>,
    command_counters: Wheels<u8>,
    /// Wheel angles at which motion began, rad.
    origin_rad: Wheels<f64>,
    measured: Measured,
    decision: Decision,
    frames: VecDeque<Frame>,
    events: VecDeque<Event>,
}

/// What the operator can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operator {
    /// Enable the drives and run the path from its beginning.
    Enable,
    /// Zero torque, disable the drives.
    Stop,
    /// Acknowledge a trip; motion needs a new `Enable`.
    Reset,
}

/// What the stack knows of a drive.
#[derive(Clone, Copy, Debug, Default)]
struct DriveView {
    /// Feedback of this period, if it has come.
    fresh: Option<Feedback>,
    /// The last state it reported.
    state: Option<DriveState>,
    /// Earlier SYNCs that it has yet to answer.
    owed: u32,
}

/// Odd frames of which notice is given in a period: somebody may send them as
/// fast as the bus can.
const ODDITIES_A_PERIOD: u8 = 3;

impl DriveView {
    /// The same drive in the next period; if it `was_asked` in the one before
    /// and did not answer, it owes that.
    fn begin_period(self, was_asked: bool) -> Self {
        let unanswered = u32::from(was_asked && self.fresh.is_none());
        Self { fresh: None, owed: self.owed.saturating_add(unanswered), ..self }
    }
}

impl Stack {
    /// A stack that will send its first SYNC at `start`.
    pub fn new(config: &StackConfig, start: Instant) -> Self {
        let controller = &config.controller;
        Self {
            period: config.period,
            profile: config.profile.clone(),
            controller: controller.build(Sampling::OverBus),
            odometry: Odometry::new(controller.belief, config.drive.counts_per_turn, config.start),
            gate: Gate::new(config.safety, config.period.as_secs_f64()),
            drives: Wheels::default(),
            ticks: 0,
            ticks_answered: 0,
            next_sync: start,
            awaiting_feedback: false,
            oddities_left: ODDITIES_A_PERIOD,
            periods_since_feedback: 0,
            enable_wanted: false,
            clear_fault_wanted: false,
            sync_counter: 0,
            sync_sent: 0,
            sync_at: start,
            sampled_at: None,
            command_counters: Wheels::default(),
            origin_rad: Wheels::default(),
            measured: Measured::default(),
            decision: Decision::default(),
            // A period makes at most 5 frames and a handful of events.
            frames: VecDeque::with_capacity(16),
            events: VecDeque::with_capacity(16),
        }
    }

    /// Takes a frame that arrived at `at`. Those of others on the bus are
    /// ignored; so are corrupt ones, which is noted.
    pub fn handle_frame(&mut self, _at: Instant, frame: &Frame) {
        match self.profile.decode(frame) {
            Ok(Message::Feedback(wheel, feedback)) => self.take_feedback(wheel, feedback),
            Ok(Message::Heartbeat(wheel, heartbeat)) => self.take_state(wheel, heartbeat.state),
            Ok(Message::Fault(_, fault)) if fault != FaultCode::None => {
                self.enter(State::Tripped(Reason::DriveFault));
            }
            Ok(_) | Err(DecodeError::UnknownId) => {}
            Err(_) => self.note_oddity("frame-refused", "a frame could not be decoded and was ignored"),
        }
    }

    /// Takes note that `at` has come. Waking up later than the limit of overrun
    /// allows trips a stack in motion; periods that were missed are not made
    /// up for.
    pub fn handle_wakeup(&mut self, at: Instant) {
        if at < self.next_sync {
            return;
        }
        if at > self.next_sync + self.period {
            if at > self.next_sync + self.period * i64::from(self.gate.limits().overrun_periods) {
                self.trip(Reason::LoopOverrun);
            }
            self.next_sync = at;
        }
        if self.awaiting_feedback {
            self.go_without_feedback();
        } else if self.ticks > 0 {
            self.periods_since_feedback = 0;
        }
        self.next_sync += self.period;
        self.sync_at = at;
        self.send_sync();
        self.drives = self.drives.map(|drive| drive.begin_period(self.ticks > 0));
        self.awaiting_feedback = true;
        self.oddities_left = ODDITIES_A_PERIOD;
        let reference = self.controller.reference().pose;
        self.events.push_back(Event::Sync(SyncEvent { tick: self.ticks, reference }));
        self.ticks += 1;
    }

    /// Takes an operator's wish.
    pub fn operate(&mut self, wish: Operator) {
        match wish {
            Operator::Enable => self.enable_wanted = true,
            Operator::Stop => self.stop(),
            Operator::Reset => {
                self.enable_wanted = false;
                self.clear_fault_wanted = true;
                self.gate.reset();
                self.tell_state();
            }
        }
    }

    /// Takes note that something outside went wrong: a stack that is in motion
    /// or about to be trips.
    pub fn trip(&mut self, reason: Reason) {
        if matches!(self.gate.state(), State::Enabling | State::Running) {
            self.enter(State::Tripped(reason));
        }
    }

    /// Says goodbye: both drives are told at once to let go, whatever the
    /// state, and a last SYNC puts that into force. What a runtime sends last.
    pub fn farewell(&mut self) {
        self.stop();
        self.command(Wheels::default());
        self.send_sync();
    }

    /// The next frame to send.
    pub fn poll_transmit(&mut self) -> Option<Frame> {
        self.frames.pop_front()
    }

    /// The next thing that happened.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// When it next wants [`Self::handle_wakeup`].
    pub const fn next_wakeup(&self) -> Instant {
        self.next_sync
    }

    /// Periods whose feedback was complete and has been answered.
    pub const fn ticks_answered(&self) -> u64 {
        self.ticks_answered
    }

    /// What it is doing.
    pub const fn state(&self) -> State {
        self.gate.state()
    }

    fn stop(&mut self) {
        self.enable_wanted = false;
        if matches!(self.gate.state(), State::Enabling | State::Running) {
            self.enter(State::Stopped);
        }
    }

    fn take_feedback(&mut self, wheel: Wheel, feedback: Feedback) {
        if feedback.counter != self.profile.feedback_counter(wheel, self.sync_sent) {
            return self.take_odd_feedback(wheel);
        }
        if self.drives[wheel].fresh.is_some() {
            return self.note_oddity("feedback-repeated", "feedback that had come already was ignored");
        }
        self.take_state(wheel, feedback.state);
        self.drives[wheel].fresh = Some(feedback);
        // A drive's frames keep their order: what it owed until now is lost.
        self.drives[wheel].owed = 0;
        if let (true, Some(right), Some(left)) =
            (self.awaiting_feedback, self.drives.right.fresh, self.drives.left.fresh)
        {
            self.answer(Wheels { right, left });
        }
    }

    /// Feedback that answers another SYNC than the last: one that is still owed
    /// is late and worth nothing any more; any other nobody asked for.
    fn take_odd_feedback(&mut self, wheel: Wheel) {
        let owed = &mut self.drives[wheel].owed;
        if *owed == 0 {
            return self.trip(Reason::CounterJump);
        }
        *owed -= 1;
        self.note_oddity("feedback-late", "feedback came after the next SYNC had left and was ignored");
    }

    fn take_state(&mut self, wheel: Wheel, state: DriveState) {
        let before = self.drives[wheel].state.replace(state);
        if state == DriveState::Fault && before != Some(state) {
            self.notice("drive-in-fault", "a drive is in its fault state, and stays there until it is cleared");
        }
        match (self.gate.state(), state) {
            (_, DriveState::Fault) => self.trip(Reason::DriveFault),
            (State::Running, DriveState::Ready | DriveState::Boot) => {
                self.enter(State::Tripped(Reason::DriveDisabled));
            }
            _ => {}
        }
    }

    /// Both drives have answered: the law runs, the torques leave.
    fn answer(&mut self, feedback: Wheels<Feedback>) {
        self.awaiting_feedback = false;
        self.ticks_answered += 1;
        let last = self.sampled_at.replace(self.sync_at);
        let span = last.map_or(self.period, |last| self.sync_at - last);
        let positions = feedback.map(|feedback| feedback.position_counts);
        let applied = feedback.map(|feedback| feedback.torque_applied_nm);
        self.measured = self.odometry.update(positions, applied, span);
        self.step_state();
        let mut wanted = Wheels::default();
        if self.gate.state() == State::Running {
            let mut measured = self.measured;
            measured.angle_rad = measured.angle_rad - self.origin_rad;
            self.decision = self.controller.decide(&self.odometry.pose(), &measured);
            self.check_following_error(measured.angle_rad);
            wanted = self.decision.torque_nm;
        }
        self.finish_period(wanted);
    }

    /// A drive did not answer in time. The last torque is held, until that has
    /// lasted too long.
    fn go_without_feedback(&mut self) {
        self.periods_since_feedback += 1;
        let timeout = self.gate.limits().feedback_timeout_periods;
        if self.periods_since_feedback >= timeout {
            self.trip(Reason::StaleFeedback);
        }
        self.finish_period(self.decision.torque_nm);
    }

    /// Lets through what the gate lets through, and goes on to the next tick.
    fn finish_period(&mut self, wanted_nm: Wheels<f64>) {
        let before = self.gate.state();
        let torque_sent_nm = self.gate.pass(wanted_nm);
        if self.gate.state() != before {
            self.tell_state();
        }
        self.command(torque_sent_nm);
        self.clear_fault_wanted = false;
        self.tell_tick(wanted_nm, torque_sent_nm);
        if self.gate.state() == State::Running {
            self.controller.advance();
        }
    }

    fn send_sync(&mut self) {
        self.sync_sent = self.sync_counter;
        self.send(&Message::Sync { counter: self.sync_counter });
        self.sync_counter = self.profile.next_sync_counter(self.sync_counter);
    }

    /// Sends both drives a torque, N m, and what state to be in.
    fn command(&mut self, torque_nm: Wheels<f64>) {
        let request = self.request();
        for wheel in Wheel::BOTH {
            let counter = self.command_counters[wheel];
            self.command_counters[wheel] = self.profile.next_command_counter(wheel, counter);
            self.send(&Message::Command(wheel, Command { torque_nm: torque_nm[wheel], request, counter }));
        }
    }

    /// The transitions that wait for the drives or the operator.
    fn step_state(&mut self) {
        let both = |wanted: DriveState| self.drives.all(|drive| drive.state == Some(wanted));
        match self.gate.state() {
            State::Boot => self.enter(State::Stopped),
            State::Stopped if self.enable_wanted && both(DriveState::Ready) => self.enter(State::Enabling),
            State::Enabling if both(DriveState::Enabled) => {
                self.controller.reset();
                self.decision = Decision::default();
                self.origin_rad = self.measured.angle_rad;
                self.enter(State::Running);
            }
            _ => {}
        }
    }

    fn check_following_error(&mut self, angle_rad: Wheels<f64>) {
        let error_rad = self.decision.target.angle_rad - angle_rad;
        let limit_rad = self.gate.limits().following_error_rad;
        if error_rad.any(|error| error.abs() > limit_rad) {
            self.enter(State::Tripped(Reason::FollowingError));
        }
    }

    fn request(&self) -> Request {
        match self.gate.state() {
            State::Enabling | State::Running => Request::Enable,
            _ if self.clear_fault_wanted => Request::ClearFault,
            _ => Request::Disable,
        }
    }

    /// Changes state and says so. A trip withdraws the wish to move.
    fn enter(&mut self, state: State) {
        let before = self.gate.state();
        self.gate.enter(state);
        if self.gate.state() != before {
            if matches!(state, State::Tripped(_)) {
                self.enable_wanted = false;
            }
            self.tell_state();
        }
    }

    fn tell_state(&mut self) {
        let state = self.gate.state();
        self.notice(state.name(), state.text());
    }

    fn notice(&mut self, kind: &'static str, text: &'static str) {
        self.events.push_back(Event::Notice(Notice { kind, text }));
    }

    fn note_oddity(&mut self, kind: &'static str, text: &'static str) {
        if self.oddities_left > 0 {
            self.oddities_left -= 1;
            self.notice(kind, text);
        }
    }

    fn send(&mut self, message: &Message) {
        self.frames.push_back(self.profile.encode(message));
    }

    fn tell_tick(&mut self, torque_wanted_nm: Wheels<f64>, torque_sent_nm: Wheels<f64>) {
        let reference = self.controller.reference();
        let target = &self.decision.target;
        self.events.push_back(Event::Tick(Tick {
            tick: self.ticks - 1,
            state: self.gate.state().code(),
            reference: reference.pose,
            reference_twist: reference.twist,
            odometry: self.odometry.pose(),
            target_angle_rad: target.angle_rad,
            target_speed_rad_s: target.speed_rad_s,
            angle_rad: self.measured.angle_rad - self.origin_rad,
            speed_rad_s: self.measured.speed_rad_s,
            acceleration_rad_s2: self.measured.acceleration_rad_s2,
            torque_applied_nm: self.measured.torque_nm,
            torque_wanted_nm,
            torque_sent_nm,
        }));
    }
}
