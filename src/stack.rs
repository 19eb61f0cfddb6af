//! The control stack: frames and moments in, frames and events out.
//!
//! It opens no socket, waits for nothing and reads no clock. A runtime drives
//! it: hand it what happens ([`Stack::handle_frame`], [`Stack::handle_wakeup`],
//! [`Stack::operate`]), then drain [`Stack::poll_transmit`] and
//! [`Stack::poll_event`], then wait for a frame or for [`Stack::next_wakeup`],
//! whichever comes first.
//!
//! Once a period T it makes the drives answer, as their profile says: by SYNC,
//! at which they latch their encoders, or by asking each. When both have
//! answered, the control law runs. The torque acts at the next SYNC; where
//! drives put a torque into force when it arrives, it is held back and is the
//! first thing that leaves in the next period. So a torque acts exactly one
//! period after the positions it was made from, whatever the host's jitter.

use crate::control::{Controller, Decision, Measured, Sampling};
use crate::estimator::{Estimator, Sample};
use crate::event::{Event, Notice, SyncEvent, Tick};
use crate::exchange::Exchange;
use crate::fifo::Fifo;
use crate::frame::Frame;
use crate::odometry::Odometry;
use crate::path::Path;
use crate::safety::{Chain, Operator, Reason, State};
use crate::schema::{Acts, Applied, DecodeError, DriveState, Message, Profile};
use crate::time::{Duration, Instant};
use crate::wheels::{Wheel, Wheels};

mod config;
mod drives;
mod exchange;
mod hearing;
mod remainder;

use drives::DriveView;
use remainder::Remainder;

pub use config::{DriveConfig, RobotFile, StackConfig};

/// The control stack of a two-wheeled robot.
pub struct Stack {
    period: Duration,
    profile: Profile,
    /// Whether the torque applied is made from what was asked for.
    believes_commands: bool,
    controller: Controller,
    /// The path that the next enable begins, if it is another.
    next_path: Option<Path>,
    odometry: Odometry,
    chain: Chain,
    /// The state that was told last.
    told: State,
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
    sync_counter: u8,
    /// Counter of the last SYNC sent.
    sync_sent: u8,
    /// When that was.
    sync_at: Instant,
    /// When that was whose feedback was answered last, by wheel.
    sampled_at: Wheels<Option<Instant>>,
    /// The torque that the last commands asked for, N m.
    commanded_nm: Wheels<f64>,
    /// The torque in force since this period began, and in the one before it,
    /// as far as the stack knows, N m.
    in_force_nm: [Wheels<f64>; 2],
    /// The torque for drives that act when it arrives, N m: it waits for the
    /// next period.
    held_nm: Wheels<f64>,
    /// What the last commands could not say.
    remainder: Remainder,
    command_counters: Wheels<u8>,
    /// Wheel angles at which motion began, rad.
    origin_rad: Wheels<f64>,
    measured: Measured,
    decision: Decision,
    frames: Fifo<Frame>,
    events: Fifo<Event>,
    /// Whether to tell what goes in and comes out.
    tells_exchange: bool,
}

/// Odd frames of which notice is given in a period: somebody may send them as
/// fast as the bus can.
const ODDITIES_A_PERIOD: u8 = 3;

impl Stack {
    /// A stack that will send its first SYNC at `start`.
    pub fn new(config: &StackConfig, start: Instant) -> Self {
        let controller = &config.controller;
        Self {
            period: config.period,
            believes_commands: Wheel::BOTH.iter().any(|&wheel| believes_commands(&config.profile, wheel)),
            profile: config.profile.clone(),
            controller: controller.build(Sampling::OverBus),
            next_path: None,
            odometry: Odometry::new(controller.belief, estimators(config), config.start),
            chain: Chain::new(config.safety, config.period.as_secs_f64()),
            told: State::Boot,
            drives: Wheels::both(DriveView::new()),
            ticks: 0,
            ticks_answered: 0,
            next_sync: start,
            awaiting_feedback: false,
            oddities_left: ODDITIES_A_PERIOD,
            sync_counter: 0,
            sync_sent: 0,
            sync_at: start,
            sampled_at: Wheels::default(),
            commanded_nm: Wheels::default(),
            in_force_nm: [Wheels::default(); 2],
            held_nm: Wheels::default(),
            remainder: Remainder::default(),
            command_counters: Wheels::default(),
            origin_rad: Wheels::default(),
            measured: Measured::default(),
            decision: Decision::default(),
            // A period makes a handful of frames and of events.
            frames: Fifo::with_capacity(64),
            events: Fifo::with_capacity(32),
            tells_exchange: false,
        }
    }

    /// From now on all that goes in and comes out is told as
    /// [`Event::Exchange`]. To be asked for before anything else happens.
    pub fn tell_exchange(&mut self) {
        self.tells_exchange = true;
        self.told_exchange(Exchange::Begin(self.next_sync));
    }

    /// Takes a frame that arrived at `at`. Those of others on the bus are
    /// ignored; so are corrupt ones, which is noted.
    pub fn handle_frame(&mut self, at: Instant, frame: &Frame) {
        let decoded = self.profile.decode(frame);
        if decoded != Err(DecodeError::UnknownId) {
            self.told_exchange(Exchange::Frame(at, *frame));
        }
        match decoded {
            Ok(message) => {
                self.take(at, message);
                if let Some(other) = self.profile.decode_other(frame) {
                    self.take(at, other);
                }
            }
            Err(DecodeError::UnknownId) => {}
            Err(error) => {
                self.note_oddity("frame-refused", "a frame could not be decoded and was ignored");
                if error != DecodeError::RemoteRequest && self.profile.is_sent_by_drives(frame.id) {
                    self.chain.take_damaged_frame();
                }
            }
        }
        self.tell_state();
    }

    /// Takes note that `at` has come. Waking up later than the limit of overrun
    /// allows trips a stack in motion; periods that were missed are not made
    /// up for.
    pub fn handle_wakeup(&mut self, at: Instant) {
        self.told_exchange(Exchange::Wakeup(at));
        if at < self.next_sync {
            return;
        }
        if at > self.next_sync + self.period {
            if at > self.next_sync + self.period * i64::from(self.chain.limits().overrun_periods) {
                self.chain.trip(Reason::LoopOverrun, None);
            }
            self.next_sync = at;
        }
        if self.awaiting_feedback {
            self.go_without_feedback();
        } else if self.ticks > 0 {
            self.chain.take_feedback(true, None);
        }
        self.chain.begin_period();
        self.tell_state();
        self.next_sync += self.period;
        self.sync_at = at;
        self.begin_period();
        self.awaiting_feedback = true;
        self.oddities_left = ODDITIES_A_PERIOD;
        let reference = self.controller.reference().pose;
        self.events.push(Event::Sync(SyncEvent { tick: self.ticks, reference }));
        self.ticks += 1;
    }

    /// Takes an operator's wish.
    pub fn operate(&mut self, wish: Operator) {
        self.told_exchange(Exchange::Operate(wish));
        self.chain.operate(wish);
        self.tell_state();
    }

    /// Takes another path for the robot to follow, from the next time on that
    /// it is enabled: a robot in motion stops first. A replay finds it by the
    /// number of its event in the scenario.
    pub fn follow(&mut self, path: Path, event: u16) {
        self.told_exchange(Exchange::Follow(event));
        self.next_path = Some(path);
        self.notice("new-path", "there is a new path, for the next time that the robot is enabled");
        self.chain.operate(Operator::Stop);
        self.tell_state();
    }

    /// Takes note that something outside went wrong: a stack that is in motion
    /// or about to be trips.
    pub fn trip(&mut self, reason: Reason) {
        self.told_exchange(Exchange::Trip(reason));
        self.chain.trip(reason, None);
        self.tell_state();
    }

    /// Says goodbye: both drives are told at once to let go, whatever the
    /// state, and a last SYNC puts that into force. What a runtime sends last.
    pub fn farewell(&mut self) {
        self.told_exchange(Exchange::Farewell);
        self.chain.let_go();
        self.tell_state();
        self.speak(Wheels::default());
        self.send_sync();
    }

    /// The next frame to send.
    pub fn poll_transmit(&mut self) -> Option<Frame> {
        let frame = self.frames.pop()?;
        self.told_exchange(Exchange::Sent(frame));
        Some(frame)
    }

    /// The next thing that happened.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
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
        self.chain.state()
    }

    fn told_exchange(&mut self, exchange: Exchange) {
        if self.tells_exchange {
            self.events.push(Event::Exchange(exchange));
        }
    }

    /// Both drives have answered: the law runs, the torques leave.
    fn answer(&mut self, samples: Wheels<Sample>) {
        self.awaiting_feedback = false;
        self.ticks_answered += 1;
        let samples = self.with_torque(samples);
        let span_s = self.spans_s();
        self.measured = self.odometry.update(samples, span_s);
        let moved_rad = self.measured.speed_rad_s.zip_with(span_s, |speed, span| speed * span);
        self.chain.take_motion(moved_rad, span_s);
        self.believe_silent_drives();
        self.step_state();
        let wanted_nm = if self.chain.state().lets_torque_flow() { self.decide() } else { Wheels::default() };
        self.finish_period(wanted_nm);
    }

    /// Asks the law for a torque, N m.
    fn decide(&mut self) -> Wheels<f64> {
        let mut measured = self.measured;
        measured.angle_rad = measured.angle_rad - self.origin_rad;
        if self.chain.state() == State::Stopping && !self.controller.is_braking() {
            self.controller.brake(&measured, self.chain.limits().stop_deceleration_rad_s2);
        }
        self.decision = self.controller.decide(&self.odometry.pose(), &measured);
        self.chain.take_error(self.decision.target.angle_rad - measured.angle_rad);
        self.decision.torque_nm
    }

    /// A drive did not answer in time. The last torque is held, until that has
    /// lasted too long.
    fn go_without_feedback(&mut self) {
        let is_missing = |wheel: &Wheel| !self.drives[*wheel].is_complete(&self.profile);
        let missing = Wheel::BOTH.into_iter().find(is_missing).filter(|wheel| !is_missing(&wheel.other()));
        self.chain.take_feedback(false, missing);
        self.finish_period(self.decision.torque_nm);
    }

    /// Lets through what the chain lets through, and goes on to the next tick.
    fn finish_period(&mut self, wanted_nm: Wheels<f64>) {
        let torque_sent_nm = self.pass(wanted_nm);
        self.tell_state();
        match self.profile.acts {
            Acts::AtSync => self.speak(torque_sent_nm),
            Acts::OnArrival => self.held_nm = torque_sent_nm,
        }
        self.tell_tick(wanted_nm, torque_sent_nm);
        if self.chain.state() == State::Running {
            self.controller.advance();
        }
    }

    /// The transitions that wait for the drives or the operator.
    fn step_state(&mut self) {
        let before = self.chain.state();
        let conversation = &self.profile.conversation;
        let all_mean = |wanted: DriveState| {
            self.drives.all(|drive| drive.state.is_some_and(|state| conversation.meaning(state) == wanted))
        };
        let are_slow = self.measured.speed_rad_s.all(|&speed_rad_s| self.chain.is_at_rest(speed_rad_s));
        self.chain.step(all_mean, are_slow && self.controller.is_braked());
        if self.chain.state() == State::Running && before != State::Running {
            match self.next_path.take() {
                Some(path) => self.controller.follow(path),
                None => self.controller.reset(),
            }
            self.decision = Decision::default();
            self.origin_rad = self.measured.angle_rad;
        }
        self.tell_state();
    }

    /// Gives notice of another state than before, and of whose doing a trip is.
    fn tell_state(&mut self) {
        let state = self.chain.state();
        if std::mem::replace(&mut self.told, state) == state {
            return;
        }
        self.notice(state.name(), state.text());
        match self.chain.culprit() {
            Some(Wheel::Right) => self.notice("culprit", "it is the right wheel's drive"),
            Some(Wheel::Left) => self.notice("culprit", "it is the left wheel's drive"),
            None => {}
        }
    }

    fn notice(&mut self, kind: &'static str, text: &'static str) {
        self.events.push(Event::Notice(Notice { kind, text }));
    }

    fn note_oddity(&mut self, kind: &'static str, text: &'static str) {
        if self.oddities_left > 0 {
            self.oddities_left -= 1;
            self.notice(kind, text);
        }
    }

    fn send(&mut self, message: &Message) {
        self.frames.push(self.profile.encode(message));
    }

    fn tell_tick(&mut self, torque_wanted_nm: Wheels<f64>, torque_sent_nm: Wheels<f64>) {
        let reference = self.controller.reference();
        let target = &self.decision.target;
        self.events.push(Event::Tick(Tick {
            tick: self.ticks - 1,
            state: self.chain.state().code(),
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

/// What follows each wheel.
fn estimators(config: &StackConfig) -> Wheels<Estimator> {
    let profile = &config.profile;
    Wheels::from_fn(|wheel| {
        let speed_step_rad_s = profile.speed_resolution_rad_s(wheel);
        Estimator::new(profile.position_scale(wheel), speed_step_rad_s, config.period.as_secs_f64())
    })
}

/// Whether this wheel's drive does not say well what torque it applied.
fn believes_commands(profile: &Profile, wheel: Wheel) -> bool {
    profile.applied_torque(wheel).is_none() || profile.applied == Applied::Coarse
}
