//! Lock-step: the stack's time goes on when the far side says that a step is
//! over, not when a clock does. So the host's speed does not matter, and
//! neither does the kind of bus between.

use crate::bus::{Arrival, Bus, BusError, ControllerState};
use crate::event::{BusFrame, Event, Sink};
use crate::frame::Frame;
use crate::run::outlet::Outlet;
use crate::run::{Clock, End, Ended, StopSwitch, StopWish};
use crate::safety::{Operator, Reason, State};
use crate::schema::{StepEnd, StepEndCodec};
use crate::stack::Stack;
use crate::time::{Duration, Instant};

/// Drives a stack in lock-step with whoever sends [`StepEnd`].
pub struct LockStep<'r, S> {
    stack: Stack,
    bus: &'r mut dyn Bus,
    sink: &'r mut S,
    clock: Clock,
    step_end: StepEndCodec,
    outlet: Outlet,
    /// The last marker's number: the next one's is one more.
    last_tick: Option<u32>,
    /// How long, by the wall clock, the other side may be silent.
    patience: Duration,
}

/// How often to look whether somebody wants to stop.
const LOOK_UP: Duration = Duration::from_millis(100);
/// How soon to try again when the transmit queue was full.
const SOON: Duration = Duration::from_micros(200);
/// How long to try to be heard at the end.
const GOODBYE: Duration = Duration::from_millis(100);

impl<'r, S: Sink> LockStep<'r, S> {
    /// A run of `stack`, which is to wake up first at [`Instant::ZERO`].
    pub fn new(stack: Stack, bus: &'r mut dyn Bus, sink: &'r mut S, clock: Clock, patience: Duration) -> Self {
        Self {
            stack,
            bus,
            sink,
            clock,
            step_end: StepEndCodec::builtin(),
            outlet: Outlet::default(),
            last_tick: None,
            patience,
        }
    }

    /// Runs until the other side has had enough, or somebody pressed `stop`. The
    /// last thing the drives hear is to let go.
    pub fn run(mut self, stop: &StopSwitch) -> Ended {
        let end = loop {
            if stop.wish().is_some() {
                self.stack.operate(Operator::Stop);
                if self.stack.state() != State::Stopping {
                    break End::Stopped;
                }
            }
            let now = self.stack.next_wakeup();
            self.stack.handle_wakeup(now);
            match self.step(now, stop) {
                Ok(StepEnd { last: false, .. }) => {}
                Ok(StepEnd { last: true, .. }) => break End::Over,
                Err(end) => break end,
            }
        };
        let state = self.stack.state();
        self.say_goodbye();
        Ended { end, state, bus: self.outlet.counts }
    }

    /// Whatever the state of the bus: there is nothing better left to try.
    ///
    /// What still comes is taken until the end: a network connection that is
    /// closed with something unread is reset, and takes the last words with it.
    fn say_goodbye(&mut self) {
        self.stack.farewell();
        let now = self.stack.next_wakeup();
        let deadline = self.clock.now() + GOODBYE;
        while self.drain(now).is_ok() && self.clock.now() < deadline {
            let pause = if self.outlet.is_blocked() { SOON } else { GOODBYE };
            if self.bus.receive(deadline.min(self.clock.now() + pause)).is_err() {
                return;
            }
        }
    }

    /// Sends what the stack has to say and hands it the answers, up to the
    /// marker.
    fn step(&mut self, now: Instant, stop: &StopSwitch) -> Result<StepEnd, End> {
        let deadline = self.clock.now() + self.patience;
        loop {
            let unsent = self.drain(now).err();
            // Who can brake goes on with the step first.
            let can_brake = self.stack.state().lets_torque_flow() && stop.wish() == Some(StopWish::Brake);
            if stop.wish().is_some() && !can_brake {
                return Err(End::Stopped);
            }
            // Whatever else there is to hear.
            if self.clock.now() >= deadline {
                return Err(End::Silent);
            }
            let pause = if self.outlet.is_blocked() { SOON } else { LOOK_UP };
            let look_again = deadline.min(self.clock.now() + pause);
            match (self.bus.receive(look_again), unsent) {
                (Ok(Some((_, Arrival::Frame(frame)))), _) => {
                    self.take(now, &frame);
                    if let Some(step_end) = self.step_end.decode(&frame).filter(|&found| self.follows(found)) {
                        if step_end.bus_off {
                            self.stack.trip(Reason::BusOff);
                        }
                        return Ok(step_end);
                    }
                }
                // A side that has gone may have said before that all is over.
                (_, Some(error)) | (Err(error), None) => return Err(End::Lost(error)),
                (Ok(Some((_, Arrival::Down))), None) => self.stack.trip(Reason::BusLost),
                (Ok(Some((_, Arrival::State(ControllerState::BusOff)))), None) => self.stack.trip(Reason::BusOff),
                (Ok(Some((_, Arrival::Lost(frames)))), None) => self.outlet.counts.lost += u64::from(frames),
                (Ok(_), None) => {}
            }
        }
    }

    /// Whether a marker is the one that this step waits for. Any other is an
    /// old one, or somebody else's.
    fn follows(&mut self, step_end: StepEnd) -> bool {
        let follows = self.last_tick.is_none_or(|last| step_end.tick == last.wrapping_add(1));
        if follows {
            self.last_tick = Some(step_end.tick);
        }
        follows
    }

    fn take(&mut self, now: Instant, frame: &Frame) {
        self.outlet.counts.received += 1;
        self.sink.event(now, &Event::Frame(BusFrame { bus: 0, sent_by_stack: false, frame: *frame }));
        self.stack.handle_frame(now, frame);
    }

    fn drain(&mut self, now: Instant) -> Result<(), BusError> {
        self.outlet.drain(&mut self.stack, self.bus, self.sink, now)
    }
}
