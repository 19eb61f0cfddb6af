//! Real time: the stack's time is the clock's.
//!
//! One thread waits for a frame or for the stack's next wake-up, whichever
//! comes first. It takes no lock, no memory, and makes no text; what it has to
//! tell goes to a [`Sink`] that keeps to the same rules.

use crate::bus::{Arrival, Bus, BusError, ControllerState};
use crate::event::{BusFrame, Event, Notice, Sink, Timing};
use crate::frame::Frame;
use crate::run::outlet::Outlet;
use crate::run::{Clock, End, Ended, StopSwitch, StopWish};
use crate::safety::{Operator, Reason, State};
use crate::stack::Stack;
use crate::time::{Duration, Instant};

/// Drives a stack by the clock.
pub struct RealTime<'r, S> {
    stack: Stack,
    bus: &'r mut dyn Bus,
    sink: &'r mut S,
    clock: Clock,
    outlet: Outlet,
    /// Periods in a row that began with frames still waiting.
    blocked_periods: u32,
    timing: Timing,
    last_wakeup: Option<Instant>,
}

/// How often to look whether somebody wants to stop, when periods are long.
const LOOK_UP: Duration = Duration::from_millis(20);
/// How soon to try again when the transmit queue was full.
const SOON: Duration = Duration::from_micros(100);
/// A transmit queue that is full for so many periods is a bus that is lost:
/// most likely nobody acknowledges.
const BLOCKED_PERIODS: u32 = 2;
/// For how long a stack that has tripped goes on telling the drives to let go.
const FAREWELL: Duration = Duration::from_millis(200);

impl<'r, S: Sink> RealTime<'r, S> {
    /// A run of `stack` on `bus`.
    pub fn new(stack: Stack, bus: &'r mut dyn Bus, sink: &'r mut S, clock: Clock) -> Self {
        Self {
            stack,
            bus,
            sink,
            clock,
            outlet: Outlet::default(),
            blocked_periods: 0,
            timing: Timing::default(),
            last_wakeup: None,
        }
    }

    /// Runs until `until`, or until somebody pressed `stop`, and brakes to rest
    /// then; or until the stack has tripped. The last thing the drives hear is
    /// to let go, also when something in here panics.
    pub fn run(mut self, stop: &StopSwitch, until: Instant) -> Ended {
        let looped = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| self.go_on(stop, until)));
        let state = self.stack.state();
        self.outlet.give_up(&mut self.stack);
        self.stack.farewell();
        let now = self.clock.now();
        // Whatever the state of the bus: there is nothing better left to try.
        let _ = self.drain(now);
        let end = looped.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        Ended { end, state, bus: self.outlet.counts }
    }

    fn go_on(&mut self, stop: &StopSwitch, until: Instant) -> End {
        let (mut tripped_at, mut ending) = (None, None);
        loop {
            let now = self.clock.now();
            if let Err(error) = self.drain(now) {
                match error {
                    BusError::Gone(..) => return End::Lost(error),
                    BusError::Full | BusError::Down => self.stack.trip(Reason::BusLost),
                }
            }
            ending = ending.or_else(|| self.begin_to_end(stop, now >= until));
            match (self.stack.state(), ending.take()) {
                (_, Some(_)) if stop.wish() == Some(StopWish::LetGo) => return End::Stopped,
                (State::Tripped(_), _) if now - *tripped_at.get_or_insert(now) >= FAREWELL => return End::Tripped,
                (State::Tripped(_) | State::Stopping, wanted) => ending = wanted,
                (_, Some(end)) => return end,
                (_, None) => {}
            }
            if let Err(error) = self.wait(now) {
                return End::Lost(error);
            }
        }
    }

    /// Somebody wants the run to end, or its time is up: the stack brakes.
    fn begin_to_end(&mut self, stop: &StopSwitch, is_over: bool) -> Option<End> {
        let end = match stop.wish() {
            Some(_) => End::Stopped,
            None if is_over => End::Over,
            None => return None,
        };
        self.stack.operate(Operator::Stop);
        Some(end)
    }

    /// Waits for what comes next, and lets the stack have it.
    fn wait(&mut self, now: Instant) -> Result<(), BusError> {
        let wakeup = self.stack.next_wakeup();
        let pause = if self.outlet.is_blocked() { SOON } else { LOOK_UP };
        match self.bus.receive(wakeup.min(now + pause))? {
            Some((at, Arrival::Frame(frame))) => self.take(at, &frame),
            Some((_, Arrival::Down)) => self.stack.trip(Reason::BusLost),
            Some((_, Arrival::State(ControllerState::BusOff))) => self.stack.trip(Reason::BusOff),
            Some((at, Arrival::Lost(frames))) => {
                self.outlet.counts.lost += u64::from(frames);
                let text = "frames were lost on the way here, for want of room";
                self.sink.event(at, &Event::Notice(Notice { kind: "frames-lost", text }));
            }
            Some((_, Arrival::State(_) | Arrival::Up | Arrival::Heard(..))) | None => {}
        }
        let now = self.clock.now();
        if now >= wakeup {
            self.wake_up(now, wakeup);
        }
        Ok(())
    }

    fn take(&mut self, at: Instant, frame: &Frame) {
        self.outlet.counts.received += 1;
        self.sink.event(at, &Event::Frame(BusFrame { bus: 0, sent_by_stack: false, frame: *frame }));
        let before = self.clock.now();
        let ticks_answered = self.stack.ticks_answered();
        self.stack.handle_frame(at, frame);
        if self.stack.ticks_answered() != ticks_answered {
            self.timing.compute_s = (self.clock.now() - before).as_secs_f64();
            self.timing.round_trip_s = self.last_wakeup.map_or(f64::NAN, |sent| (at - sent).as_secs_f64());
        }
    }

    fn wake_up(&mut self, now: Instant, due: Instant) {
        self.timing.lateness_s = (now - due).as_secs_f64();
        if let Some(last) = self.last_wakeup.replace(now) {
            self.timing.period_s = (now - last).as_secs_f64();
            self.sink.event(now, &Event::Timing(self.timing));
            self.timing.tick += 1;
        }
        (self.timing.round_trip_s, self.timing.compute_s) = (f64::NAN, f64::NAN);
        self.give_up_what_waits();
        self.stack.handle_wakeup(now);
    }

    /// A command that could not leave in its period is worth nothing in the
    /// next.
    fn give_up_what_waits(&mut self) {
        if !self.outlet.give_up(&mut self.stack) {
            self.blocked_periods = 0;
            return;
        }
        self.blocked_periods += 1;
        if self.blocked_periods >= BLOCKED_PERIODS {
            self.stack.trip(Reason::BusLost);
        }
    }

    fn drain(&mut self, now: Instant) -> Result<(), BusError> {
        self.outlet.drain(&mut self.stack, self.bus, self.sink, now)
    }
}
