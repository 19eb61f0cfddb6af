//! The far side on a bus, by the clock: the plant moves as time does, and the
//! bus itself is the wire. SYNC takes the plant to its own moment; without SYNC
//! whatever happens does.

use std::ops::ControlFlow;

use canloop::bus::{Arrival, BitRates, Bus, BusError, frame_bits};
use canloop::event::{BusFrame, Event, Sink};
use canloop::frame::Frame;
use canloop::run::Clock;
use canloop::time::{Duration, Instant};

use crate::bench::{End, Outcome, is_lost, truth};
use crate::route::Route;
use crate::scenario::Scenario;
use crate::serve::{ServeEnd, Served};
use crate::virtual_robot::VirtualRobot;
use crate::wire::WireStats;

/// Drives and plant, impersonated on a bus in real time.
pub struct WallServer<'r, S> {
    robot: VirtualRobot,
    bus: &'r mut dyn Bus,
    sink: &'r mut S,
    clock: Clock,
    route: Route,
    period: Duration,
    bit: Duration,
    /// The moment the plant stands at.
    plant_at: Instant,
    /// When the period began.
    begun_at: Instant,
    /// Whether anybody has spoken to the drives.
    is_heard: bool,
    /// What passed through the bus.
    wire: WireStats,
    ignored: u64,
    ticks: u64,
}

/// How often to look whether somebody wants to stop.
const LOOK_UP: Duration = Duration::from_millis(20);

impl<'r, S: Sink> WallServer<'r, S> {
    /// The far side of `scenario` on `bus`.
    pub fn new(scenario: &Scenario, rates: BitRates, bus: &'r mut dyn Bus, sink: &'r mut S, clock: Clock) -> Self {
        let now = clock.now();
        Self {
            robot: scenario.virtual_robot(now).by_clock(),
            bus,
            sink,
            clock,
            route: Route::new(scenario),
            period: scenario.stack.period,
            bit: rates.bits(1),
            plant_at: now,
            begun_at: now,
            is_heard: false,
            wire: WireStats::default(),
            ignored: 0,
            ticks: scenario.ticks(),
        }
    }

    /// Serves until the scenario's time is up. `patience` counts from the
    /// last frame on.
    pub fn run(mut self, patience: Duration, mut progress: impl FnMut(u64) -> ControlFlow<()>) -> Served {
        let mut heard = self.clock.now();
        let end = loop {
            if progress(self.robot.ticks()).is_break() {
                break ServeEnd::Run(End::Interrupted);
            }
            match self.step() {
                Ok(Happened::Frame) => heard = self.clock.now(),
                Ok(Happened::Over(end)) => break ServeEnd::Run(end),
                Ok(Happened::Nothing) if self.clock.now() - heard > patience => break ServeEnd::Silent,
                Ok(Happened::Nothing) => {}
                Err(error) => break ServeEnd::Lost(error),
            }
        };
        let outcome = Outcome {
            end: end.of_the_run(),
            ticks: self.robot.ticks().saturating_sub(1),
            wire: self.wire,
            state: None,
        };
        Served { end, outcome, ignored: self.ignored }
    }

    fn step(&mut self) -> Result<Happened, BusError> {
        let now = self.clock.now();
        let patience = if self.has_sync() { self.period * 2 } else { self.period };
        let deadline = self.robot.next_wakeup().min(self.begun_at + patience).min(now + LOOK_UP);
        let mut happened = Happened::Nothing;
        match self.bus.receive(deadline)? {
            Some((at, Arrival::Frame(frame))) if self.robot.is_addressed_by(&frame) => happened = self.take(at, &frame),
            Some((_, Arrival::Frame(_))) => self.ignored += 1,
            Some((_, Arrival::Lost(frames))) => self.wire.lost += u64::from(frames),
            _ => {}
        }
        let now = self.clock.now();
        if now >= self.robot.next_wakeup() {
            self.catch_up(now);
            self.robot.handle_wakeup(now);
        }
        if now >= self.begun_at + patience {
            self.begun_at += self.period;
            happened = self.go_on_without(now).or(happened);
        }
        self.send(now)?;
        Ok(happened)
    }

    fn take(&mut self, at: Instant, frame: &Frame) -> Happened {
        self.tell_frame(at, frame, true);
        self.is_heard = true;
        self.catch_up(at);
        let span = at - self.plant_at;
        if !self.robot.handle_frame(frame, span.as_secs_f64().max(0.0)) {
            return Happened::Frame;
        }
        (self.plant_at, self.begun_at) = (at, at);
        self.tell_truth(at).or(Happened::Frame)
    }

    /// A period's time has passed without the SYNC that was due, or where none
    /// ever is.
    fn go_on_without(&mut self, now: Instant) -> Happened {
        if self.has_sync() {
            self.plant_at += self.period;
            self.robot.go_without_sync(self.period.as_secs_f64());
            return Happened::Nothing;
        }
        self.catch_up(now);
        if !self.is_heard {
            return Happened::Nothing;
        }
        self.robot.begin_period(0.0);
        self.tell_truth(now)
    }

    /// Without SYNC, the plant is taken on to whatever happens.
    fn catch_up(&mut self, at: Instant) {
        if !self.has_sync() && at > self.plant_at {
            self.robot.advance((at - self.plant_at).as_secs_f64());
            self.plant_at = at;
        }
    }

    fn has_sync(&self) -> bool {
        self.robot.profile().has_sync()
    }

    /// Tells the truth at the beginning of a period, and whether the run is over.
    fn tell_truth(&mut self, at: Instant) -> Happened {
        let tick = self.robot.ticks() - 1;
        let reference = self.route.at(tick, self.robot.path_began());
        let truth = truth(tick, self.robot.state(), &reference, self.robot.torque_applied_nm());
        self.sink.event(at, &Event::Truth(truth));
        if is_lost(&truth) {
            return Happened::Over(End::Diverged);
        }
        if tick >= self.ticks { Happened::Over(End::Finished) } else { Happened::Nothing }
    }

    fn send(&mut self, now: Instant) -> Result<(), BusError> {
        while let Some((_, frame)) = self.robot.poll_transmit() {
            match self.bus.send(&frame) {
                Ok(()) => self.tell_frame(now, &frame, false),
                // A drive whose frame finds no room has the next one ready soon enough.
                Err(BusError::Full | BusError::Down) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    fn tell_frame(&mut self, at: Instant, frame: &Frame, sent_by_stack: bool) {
        self.wire.frames += 1;
        self.wire.busy = self.wire.busy + self.bit * i64::from(frame_bits(frame));
        self.sink.event(at, &Event::Frame(BusFrame { bus: 0, sent_by_stack, frame: *frame }));
    }
}

enum Happened {
    Frame,
    Nothing,
    Over(End),
}

impl Happened {
    /// This, or else that.
    fn or(self, other: Self) -> Self {
        if matches!(self, Self::Nothing) { other } else { self }
    }
}
