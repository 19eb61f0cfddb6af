//! The robot as a controller sees it: two drives on a bus, with the plant
//! behind them.
//!
//! Like the stack it has no hands and no watch: frames and moments in, frames
//! out. In lock-step the plant advances when the stack's period begins, by as
//! much as it is told, so nothing depends on when exactly the frames of a
//! period crossed. By the clock it is moved on whenever something happens.

use canloop::fifo::Fifo;
use canloop::frame::Frame;
use canloop::schema::{Acts, Asks, DriveState, FaultCode, Feedback, Message, Profile};
use canloop::time::{Duration, Instant};
use canloop::wheels::{Wheel, Wheels};

use crate::drive::{Drive, DriveSpec, Trouble};
use crate::plant::{Plant, State};

/// Two drives and the plant that they move.
pub struct VirtualRobot {
    profile: Profile,
    plant: Plant,
    drives: Wheels<Drive>,
    /// Whether periods without SYNC begin by the clock, not by a command.
    is_by_clock: bool,
    /// Periods begun.
    ticks: u64,
    /// Which drives a SYNC has reached in this period of a lock-step run.
    is_synced: Wheels<bool>,
    /// Whether this period's beginning has been closed without a frame: the
    /// next of those that stand in for SYNC begins another.
    awaits_beginning: bool,
    /// The period in which the path began.
    path_began: Option<u64>,
    /// Whether a torque has been asked of an enabled drive.
    is_driven: bool,
    /// Count of feedback that counts by itself.
    own_count: u8,
    next_heartbeat: Instant,
    /// When feedback is due that nobody asks for.
    next_feedback: Instant,
    /// By what share the drives' own clocks run too slow.
    clock_drift: f64,
    frames: Fifo<(Wheel, Frame)>,
}

impl VirtualRobot {
    /// Drives that are switched on at `start` in front of `plant`.
    pub fn new(profile: Profile, plant: Plant, spec: DriveSpec, start: Instant) -> Self {
        let is_asked = profile.asks != Asks::Nothing;
        let cycle = profile.feedback_period.filter(|_| !is_asked);
        Self {
            plant,
            drives: Wheels::from_fn(|_| Drive::new(spec, &profile)),
            is_by_clock: false,
            ticks: 0,
            is_synced: Wheels::default(),
            awaits_beginning: false,
            path_began: None,
            is_driven: false,
            own_count: 0,
            next_heartbeat: profile.heartbeat_period.map_or(Instant::MAX, |_| start),
            next_feedback: cycle.map_or(Instant::MAX, |cycle| start + Duration::from_nanos(cycle.as_nanos() / 4)),
            clock_drift: 0.0,
            profile,
            frames: Fifo::with_capacity(64),
        }
    }

    /// The same robot where time goes by the clock: without SYNC, a period
    /// begins when [`Self::begin_period`] is called.
    pub fn by_clock(self) -> Self {
        Self { is_by_clock: true, ..self }
    }

    /// The profile that the drives keep to.
    pub const fn profile(&self) -> &Profile {
        &self.profile
    }

    /// Takes a frame from the bus; says whether it began a period, which takes
    /// the plant on by `span_s`. What is no drive's business, or corrupt, is
    /// ignored, as a drive would.
    pub fn handle_frame(&mut self, frame: &Frame, span_s: f64) -> bool {
        self.handle_frame_at(frame, Wheels { right: true, left: true }, Some(span_s))
    }

    /// The same for a frame that reaches only some drives; `span_s` is nothing
    /// where the period has begun already.
    pub fn handle_frame_at(&mut self, frame: &Frame, reaches: Wheels<bool>, span_s: Option<f64>) -> bool {
        if let Some(each) = self.profile.broadcast(frame) {
            let began = each.map(|frame| self.handle_frame_at(&frame, reaches, span_s));
            return began.right || began.left;
        }
        let Ok(message) = self.profile.decode(frame) else { return false };
        for wheel in Wheel::BOTH.into_iter().filter(|&wheel| reaches[wheel]) {
            self.profile.mode_said(wheel, frame).into_iter().for_each(|mode| self.drives[wheel].take_mode(mode));
        }
        let span_s = span_s.filter(|_| self.begins_period(&message));
        if let Some(span_s) = span_s {
            self.begin_period(span_s);
        }
        self.take(message, reaches);
        if let Some(other) = self.profile.decode_other(frame) {
            self.take(other, reaches);
        }
        if self.ticks > 0 && self.path_began.is_none() {
            self.look_whether_the_path_begins();
        }
        span_s.is_some()
    }

    /// Whether a frame is valid and meant for the drives.
    pub fn is_addressed_by(&self, frame: &Frame) -> bool {
        self.profile.is_for_drives(frame)
    }

    /// Takes the plant on by `span_s`, within a period.
    pub fn advance(&mut self, span_s: f64) {
        if span_s > 0.0 {
            self.plant.advance(span_s, self.drives.as_ref().map(Drive::torque));
            for wheel in Wheel::BOTH {
                self.drives[wheel].elapse(span_s);
                self.tell_fault(wheel);
            }
        }
    }

    /// Takes the plant on by a period of `span_s` in which no SYNC came.
    pub fn go_without_sync(&mut self, span_s: f64) {
        self.advance(span_s);
        for wheel in Wheel::BOTH {
            self.drives[wheel].go_without_sync();
            self.tell_fault(wheel);
        }
    }

    /// Ends a period of a lock-step run: drives that no SYNC has reached go on
    /// without.
    pub fn end_period(&mut self) {
        self.awaits_beginning = true;
        let synced = std::mem::take(&mut self.is_synced);
        if !self.profile.has_sync() {
            return;
        }
        for wheel in Wheel::BOTH.into_iter().filter(|&wheel| !synced[wheel]) {
            self.drives[wheel].go_without_sync();
            self.tell_fault(wheel);
        }
    }

    /// Takes note that `at` has come: heartbeats may be due, and feedback.
    pub fn handle_wakeup(&mut self, at: Instant) {
        if let Some(period) = self.profile.heartbeat_period.filter(|_| at >= self.next_heartbeat) {
            self.next_heartbeat += self.by_own_clock(period);
            self.tell_of_life();
        }
        if let Some(period) = self.profile.feedback_period.filter(|_| at >= self.next_feedback) {
            self.next_feedback += self.by_own_clock(period);
            self.report_all(0);
        }
    }

    /// When it next wants [`Self::handle_wakeup`].
    pub fn next_wakeup(&self) -> Instant {
        self.next_heartbeat.min(self.next_feedback)
    }

    /// When feedback is due that nobody asks for.
    pub const fn next_feedback(&self) -> Instant {
        self.next_feedback
    }

    /// The next frame a drive sends.
    pub fn poll_transmit(&mut self) -> Option<(Wheel, Frame)> {
        self.frames.pop()
    }

    /// Periods begun.
    pub const fn ticks(&self) -> u64 {
        self.ticks
    }

    /// The plant's state.
    pub fn state(&self) -> &State {
        self.plant.state()
    }

    /// A drive.
    pub fn drive(&self, wheel: Wheel) -> &Drive {
        &self.drives[wheel]
    }

    /// The period in which the path began, as far as drives can know: that in
    /// which both were enabled, or, where that shows late, the one before that
    /// in which a first torque came.
    pub const fn path_began(&self) -> Option<u64> {
        self.path_began
    }

    /// Mean torque at the wheels over the period that has ended, N m.
    pub fn torque_applied_nm(&self) -> Wheels<f64> {
        self.drives.as_ref().map(Drive::period_mean_nm)
    }

    /// Something else is wrong with a drive from now on, or nothing any more.
    pub fn get_into(&mut self, wheel: Wheel, trouble: Trouble) {
        self.drives[wheel].get_into(trouble);
    }

    /// What the encoders count now, by wheel.
    pub fn encoder_counts(&self) -> Wheels<i64> {
        let angle_rad = self.plant.state().angle_rad;
        Wheels::from_fn(|wheel| self.drives[wheel].counts(angle_rad[wheel]))
    }

    /// The drives' own clocks run by this share too slow from now on.
    pub const fn set_clock_drift(&mut self, drift: f64) {
        self.clock_drift = drift;
    }

    /// What the drives do by their own clocks comes this much later from now on.
    pub fn set_back_clock(&mut self, by: Duration) {
        for next in [&mut self.next_heartbeat, &mut self.next_feedback] {
            if *next != Instant::MAX {
                *next += by;
            }
        }
    }

    /// The plant.
    pub const fn plant(&self) -> &Plant {
        &self.plant
    }

    /// The plant, for something to happen to it.
    pub const fn plant_mut(&mut self) -> &mut Plant {
        &mut self.plant
    }

    /// Something in a drive fails.
    pub fn raise_fault(&mut self, wheel: Wheel, fault: FaultCode) {
        self.drives[wheel].raise(fault);
        self.tell_fault(wheel);
    }

    /// Switches a drive off and on again.
    pub fn power_cycle(&mut self, wheel: Wheel) {
        self.drives[wheel].power_cycle();
    }

    /// Ends the period so far, `span_s` after what happened before, and begins
    /// another.
    pub fn begin_period(&mut self, span_s: f64) {
        // Nothing has moved before the first period: it marks time zero.
        if self.ticks > 0 {
            self.advance(span_s);
        }
        self.ticks += 1;
        self.awaits_beginning = false;
        for wheel in Wheel::BOTH {
            self.drives[wheel].begin_period();
        }
    }

    /// How long what a drive takes for `period` really is.
    fn by_own_clock(&self, period: Duration) -> Duration {
        if self.clock_drift == 0.0 {
            return period;
        }
        Duration::from_secs_f64(period.as_secs_f64() * (1.0 + self.clock_drift))
    }

    /// Drives with power do; one message for both comes while either has any.
    fn tell_of_life(&mut self) {
        let is_powered = self.drives.as_ref().map(|drive| drive.trouble().is_powered);
        let messages = Wheels::from_fn(|wheel| Message::Heartbeat(wheel, self.drives[wheel].heartbeat()));
        if self.profile.shares_heartbeat() {
            if is_powered.any(|&is_powered| is_powered) {
                self.send_both(messages, true);
            }
            return;
        }
        for wheel in Wheel::BOTH.into_iter().filter(|&wheel| is_powered[wheel]) {
            self.send(wheel, messages[wheel]);
        }
    }

    fn begins_period(&self, message: &Message) -> bool {
        let stands_in = match message {
            Message::Sync { .. } => return true,
            // The left wheel's may be the first to arrive where another is lost.
            Message::Command(wheel, _) => *wheel == Wheel::Right || self.awaits_beginning,
            Message::Poll(..) => self.awaits_beginning,
            _ => false,
        };
        stands_in && !self.profile.has_sync() && !self.is_by_clock
    }

    fn take(&mut self, message: Message, reaches: Wheels<bool>) {
        match message {
            Message::Sync { counter } => self.sync(counter, reaches),
            Message::Command(wheel, _) | Message::Word(wheel, _) | Message::Poll(wheel, _) if !reaches[wheel] => {}
            Message::Command(wheel, command) => {
                self.drives[wheel].take_command(command, self.profile.command_has_counter());
                self.is_driven |= command.torque_nm != 0.0 && self.drives[wheel].state() == DriveState::Enabled;
                self.answer(wheel);
            }
            Message::Word(wheel, word) => {
                self.drives[wheel].hear(word);
                if self.profile.is_said_in_place_of_a_command(wheel, word) {
                    self.answer(wheel);
                }
            }
            Message::Poll(wheel, part) => self.report(wheel, part, 0),
            _ => {}
        }
    }

    fn sync(&mut self, sync_counter: u8, reaches: Wheels<bool>) {
        for wheel in Wheel::BOTH.into_iter().filter(|&wheel| reaches[wheel]) {
            self.is_synced[wheel] = true;
            self.drives[wheel].sync();
            self.tell_fault(wheel);
            if self.profile.asks == Asks::BySync {
                (0..self.profile.parts()).for_each(|part| self.report(wheel, part, sync_counter));
            }
        }
    }

    /// Drives that answer every command do so.
    fn answer(&mut self, wheel: Wheel) {
        if self.profile.asks == Asks::ByCommand {
            (0..self.profile.parts()).for_each(|part| self.report(wheel, part, 0));
        }
    }

    fn report_all(&mut self, sync_counter: u8) {
        self.own_count = self.own_count.wrapping_add(1);
        for part in 0..self.profile.parts() {
            Wheel::BOTH.into_iter().for_each(|wheel| self.report(wheel, part, sync_counter));
        }
    }

    /// Sends a part of a drive's feedback; one that both wheels share goes with
    /// the right wheel's.
    fn report(&mut self, wheel: Wheel, part: u8, sync_counter: u8) {
        if self.profile.shares_feedback(part) {
            if wheel == Wheel::Right && !self.drives.all(Drive::is_silent) {
                let both = Wheels::from_fn(|wheel| self.feedback(wheel, part, sync_counter));
                self.send_both(both, true);
            }
        } else if !self.drives[wheel].is_silent() {
            let message = self.feedback(wheel, part, sync_counter);
            self.send(wheel, message);
        }
    }

    fn feedback(&self, wheel: Wheel, part: u8, sync_counter: u8) -> Message {
        let state = self.plant.state();
        let position = |count| self.profile.position_at_count(wheel, count);
        let said = self.drives[wheel].feedback(state.angle_rad[wheel], state.speed_rad_s[wheel], position);
        let count = if self.profile.counter_echoes_sync { sync_counter } else { self.own_count };
        let counter = self.profile.feedback_counter(wheel, count);
        Message::Feedback(wheel, Feedback { part, counter, ..said })
    }

    fn look_whether_the_path_begins(&mut self) {
        let tick = self.ticks - 1;
        if self.drives.all(|drive| drive.state() == DriveState::Enabled) {
            if self.profile.acts == Acts::AtSync {
                self.path_began = Some(tick);
            } else if self.is_driven {
                self.path_began = Some(tick.saturating_sub(1));
            }
        }
    }

    fn tell_fault(&mut self, wheel: Wheel) {
        let raised = self.drives[wheel].take_raised_fault();
        if let Some(fault) = raised.filter(|_| self.profile.tells_faults()) {
            self.send(wheel, Message::Fault(wheel, fault));
        }
    }

    fn send_both(&mut self, messages: Wheels<Message>, is_shared: bool) {
        if is_shared {
            self.frames.push((Wheel::Right, self.profile.encode_shared(&messages)));
        } else {
            Wheel::BOTH.into_iter().for_each(|wheel| self.send(wheel, messages[wheel]));
        }
    }

    fn send(&mut self, wheel: Wheel, message: Message) {
        self.frames.push((wheel, self.profile.encode(&message)));
    }
}
