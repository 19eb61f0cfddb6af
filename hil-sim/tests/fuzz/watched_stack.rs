//! A stack that is watched: whatever it is given, some things always hold.

use std::collections::{BTreeSet, VecDeque};

use canloop::event::{Event, Tick};
use canloop::frame::Frame;
use canloop::safety::{Operator, State};
use canloop::schema::{Command, Message, Profile};
use canloop::stack::{Stack, StackConfig};
use canloop::time::Instant;
use canloop::wheels::{Wheel, Wheels};

/// More than the stack says to one thing that happens, by far.
const MOST_FRAMES: usize = 32;
const MOST_EVENTS: usize = 16;

/// A stack, and what is known of it from outside.
pub struct WatchedStack<'c> {
    /// Frames that have left it.
    pub sent: VecDeque<Frame>,
    /// What it went through: state before, state after, what it gave notice of.
    pub seen: BTreeSet<(u8, u8, &'static str)>,
    stack: Stack,
    config: &'c StackConfig,
    /// Whether the operator has asked for motion, and nothing has withdrawn that.
    is_wanted: bool,
}

/// Whether torque may leave in this state.
const fn may_move(state: State) -> bool {
    matches!(state, State::Running | State::Stopping)
}

impl<'c> WatchedStack<'c> {
    /// A stack that begins at the origin of time.
    pub fn new(config: &'c StackConfig) -> Self {
        Self {
            sent: VecDeque::new(),
            seen: BTreeSet::new(),
            stack: Stack::new(config, Instant::ZERO),
            config,
            is_wanted: false,
        }
    }

    pub const fn next_wakeup(&self) -> Instant {
        self.stack.next_wakeup()
    }

    pub fn handle_frame(&mut self, at: Instant, frame: &Frame) {
        self.watch(|stack| stack.handle_frame(at, frame));
    }

    pub fn handle_wakeup(&mut self, at: Instant) {
        self.watch(|stack| stack.handle_wakeup(at));
        assert!(self.stack.next_wakeup() >= at, "wants to be woken up in the past");
    }

    pub fn operate(&mut self, wish: Operator) {
        let is_tripped = matches!(self.stack.state(), State::Tripped(_));
        self.is_wanted = match wish {
            Operator::Enable => self.is_wanted || !is_tripped,
            Operator::Stop | Operator::EmergencyStop => false,
            // It acknowledges a trip, which has withdrawn the wish already.
            Operator::Reset => self.is_wanted,
        };
        self.watch(|stack| stack.operate(wish));
        if is_tripped {
            let is_still = matches!(self.stack.state(), State::Tripped(_));
            assert!(is_still || wish == Operator::Reset, "{wish:?} left a trip");
            assert!(!may_move(self.stack.state()), "{wish:?} led from a trip to motion");
        }
    }

    pub fn say_farewell(&mut self) {
        self.is_wanted = false;
        let before = self.sent.len();
        self.watch(Stack::farewell);
        self.sent.range(before..).for_each(|frame| self.check_frame(frame, false));
    }

    /// Lets something happen and looks at what comes of it.
    fn watch(&mut self, happen: impl FnOnce(&mut Stack)) {
        let (state, next_wakeup) = (self.stack.state(), self.stack.next_wakeup());
        happen(&mut self.stack);
        assert!(self.stack.next_wakeup() >= next_wakeup, "the next wake-up went backwards");
        self.check_step(state, self.stack.state());
        self.check_frames();
        self.check_events(state);
    }

    /// Motion begins only if it is wanted, and a trip ends that.
    fn check_step(&mut self, before: State, after: State) {
        if matches!(after, State::Tripped(_)) {
            self.is_wanted = false;
        }
        let has_begun = after == State::Running && before != State::Running;
        assert!(!has_begun || self.is_wanted, "motion began unasked, from {before:?}");
        assert!(may_move(before) || !may_move(after) || has_begun, "{before:?} led to {after:?}");
    }

    fn check_frames(&mut self) {
        let before = self.sent.len();
        while let Some(frame) = self.stack.poll_transmit() {
            self.check_frame(&frame, may_move(self.stack.state()));
            self.sent.push_back(frame);
        }
        assert!(self.sent.len() - before <= MOST_FRAMES, "{} frames at once", self.sent.len() - before);
    }

    fn check_frame(&self, frame: &Frame, may_move: bool) {
        let profile = &self.config.profile;
        let message = profile.decode(frame).unwrap_or_else(|error| panic!("sends {frame}, which is {error:?}"));
        for message in [Some(message), profile.decode_other(frame)].into_iter().flatten() {
            if let Message::Command(wheel, Command { torque_nm, .. }) = message {
                let limit_nm = if may_move { self.config.safety.torque_limit_nm } else { 0.0 };
                let most_nm = as_said_nm(profile, wheel, limit_nm);
                assert!(torque_nm.abs() <= most_nm, "sends {torque_nm} N m in {:?}", self.stack.state());
            }
        }
    }

    fn check_events(&mut self, before: State) {
        let (before, after) = (before.code(), self.stack.state());
        let mut events = 0;
        while let Some(event) = self.stack.poll_event() {
            events += 1;
            match event {
                Event::Tick(tick) => self.check_tick(&tick),
                Event::Notice(notice) => drop(self.seen.insert((before, after.code(), notice.kind))),
                _ => {}
            }
        }
        assert!(events <= MOST_EVENTS, "{events} events at once");
    }

    fn check_tick(&self, tick: &Tick) {
        let limit_nm = if may_move(self.stack.state()) { self.config.safety.torque_limit_nm } else { 0.0 };
        let Wheels { right, left } = tick.torque_sent_nm;
        assert!(right.abs() <= limit_nm && left.abs() <= limit_nm, "lets {right} and {left} N m through");
    }
}

/// The most that a frame says of a torque of this size either way, N m: some
/// formats know no zero.
fn as_said_nm(profile: &Profile, wheel: Wheel, size_nm: f64) -> f64 {
    [size_nm, -size_nm].map(|torque_nm| profile.torque_as_said(wheel, torque_nm).abs()).into_iter().fold(0.0, f64::max)
}
