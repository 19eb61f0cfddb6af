//! The far side on a bus, by the clock: the plant moves as time does, and the
//! bus itself is the wire.

use std::ops::ControlFlow;

use canloop::bus::{Arrival, Bus, BusError, frame_bits};
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
    /// The moment the plant stands at, once a first SYNC has come.
    plant_at: Option<Instant>,
    /// What passed through the bus.
    wire: WireStats,
    ignored: u64,
    ticks: u64,
}

/// How often to look whether somebody wants to stop.
const LOOK_UP: Duration = Duration::from_millis(20);

impl<'r, S: Sink> WallServer<'r, S> {
    /// The far side of `scenario` on `bus`.
    pub fn new(scenario: &Scenario, bitrate_bit_s: u32, bus: &'r mut dyn Bus, sink: &'r mut S, clock: Clock) -> Self {
        Self {
            robot: scenario.virtual_robot(clock.now()),
            bus,
            sink,
            clock,
            route: Route::new(scenario),
            period: scenario.stack.period,
            bit: Duration::from_nanos(1_000_000_000 / i64::from(bitrate_bit_s)),
            plant_at: None,
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
        let missed = self.plant_at.map_or(Instant::MAX, |at| at + self.period * 2);
        let deadline = self.robot.next_wakeup().min(missed).min(now + LOOK_UP);
        let mut happened = Happened::Nothing;
        match self.bus.receive(deadline)? {
            Some((at, Arrival::Frame(frame))) if self.robot.is_addressed_by(&frame) => happened = self.take(at, &frame),
            Some((_, Arrival::Frame(_))) => self.ignored += 1,
            Some((_, Arrival::Lost(frames))) => self.wire.lost += u64::from(frames),
            _ => {}
        }
        let now = self.clock.now();
        if now >= self.robot.next_wakeup() {
            self.robot.handle_wakeup(now);
        }
        if let Some(at) = self.plant_at.as_mut().filter(|at| now >= **at + self.period * 2) {
            *at += self.period;
            self.robot.go_without_sync(self.period.as_secs_f64());
        }
        self.send(now)?;
        Ok(happened)
    }

    fn take(&mut self, at: Instant, frame: &Frame) -> Happened {
        self.tell_frame(at, frame, true);
        let span = self.plant_at.map_or(Duration::ZERO, |last| at - last);
        if !self.robot.handle_frame(frame, span.as_secs_f64().max(0.0)) {
            return Happened::Frame;
        }
        self.plant_at = Some(at);
        let tick = self.robot.ticks() - 1;
        let reference = self.route.at(tick, self.robot.path_began());
        let truth = truth(tick, self.robot.state(), &reference, self.robot.torque_applied_nm());
        self.sink.event(at, &Event::Truth(truth));
        if is_lost(&truth) {
            return Happened::Over(End::Diverged);
        }
        if tick >= self.ticks { Happened::Over(End::Finished) } else { Happened::Frame }
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
