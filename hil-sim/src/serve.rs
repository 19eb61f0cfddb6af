//! The far side on a bus, for whatever controller is at the other end of it,
//! in lock-step: each SYNC makes a step, each step ends with the marker.

use std::ops::ControlFlow;

use canloop::bus::{Arrival, Bus, BusError};
use canloop::event::{Event, Sink};
use canloop::frame::Frame;
use canloop::run::Clock;
use canloop::schema::{StepEnd, StepEndCodec};
use canloop::time::{Duration, Instant};

use crate::bench::{End, Outcome, is_lost, truth};
use crate::far_side::{FarSide, Happening, Synced};
use crate::route::Route;
use crate::scenario::Scenario;

/// Drives, plant and wire, impersonated on a bus.
pub struct Server<'r, S> {
    far_side: FarSide,
    bus: &'r mut dyn Bus,
    sink: &'r mut S,
    clock: Clock,
    step_end: StepEndCodec,
    route: Route,
    ticks: u64,
}

/// How a run on a bus ended.
#[derive(Debug)]
pub enum ServeEnd {
    /// As a run in one process does.
    Run(End),
    /// The controller was silent for too long.
    Silent,
    /// The bus is gone.
    Lost(BusError),
}

impl ServeEnd {
    /// What it means for the run's figures.
    pub(crate) const fn of_the_run(&self) -> End {
        match self {
            Self::Run(end) => *end,
            Self::Silent => End::Silent,
            Self::Lost(_) => End::Interrupted,
        }
    }
}

/// How often to look whether somebody wants to stop.
const LOOK_UP: Duration = Duration::from_millis(100);

impl<'r, S: Sink> Server<'r, S> {
    /// The far side of `scenario` on `bus`.
    pub fn new(scenario: &Scenario, bitrate_bit_s: u32, bus: &'r mut dyn Bus, sink: &'r mut S, clock: Clock) -> Self {
        Self {
            far_side: FarSide::new(scenario, bitrate_bit_s, Instant::ZERO),
            bus,
            sink,
            clock,
            step_end: StepEndCodec::builtin(),
            route: Route::new(scenario),
            ticks: scenario.ticks(),
        }
    }

    /// Serves until the scenario's time is up. Nobody waits for a first SYNC
    /// in vain: `patience` counts from the last frame on, by the wall clock.
    pub fn run(mut self, patience: Duration, mut progress: impl FnMut(u64) -> ControlFlow<()>) -> (ServeEnd, Outcome) {
        let mut tick = 0;
        let mut heard = self.clock.now();
        let end = loop {
            if progress(tick).is_break() {
                break ServeEnd::Run(End::Interrupted);
            }
            match self.bus.receive(self.clock.now() + LOOK_UP) {
                Ok(Some((_, Arrival::Frame(frame)))) => {
                    heard = self.clock.now();
                    match self.take(frame) {
                        Ok(Some((reached, end))) => {
                            tick = reached;
                            if let Some(end) = end {
                                break ServeEnd::Run(end);
                            }
                        }
                        Ok(None) => {}
                        Err(error) => break ServeEnd::Lost(error),
                    }
                }
                Ok(_) if self.clock.now() - heard > patience => break ServeEnd::Silent,
                Ok(_) => {}
                Err(error) => break ServeEnd::Lost(error),
            }
        };
        let outcome = Outcome { end: end.of_the_run(), ticks: tick, wire: *self.far_side.wire_stats(), state: None };
        (end, outcome)
    }

    /// Hands a frame to the far side and passes on what comes of it. A SYNC
    /// that arrived gives the tick, and how the run ends if it does.
    fn take(&mut self, frame: Frame) -> Result<Option<(u64, Option<End>)>, BusError> {
        self.far_side.take(frame);
        let mut step = None;
        while let Some((at, happening)) = self.far_side.poll() {
            match happening {
                Happening::Frame(crossed) => {
                    self.sink.event(at, &Event::Frame(crossed));
                    if !crossed.sent_by_stack {
                        self.send(&crossed.frame)?;
                    }
                }
                Happening::Synced(synced) => step = Some((synced.tick, self.tell(at, &synced))),
            }
        }
        if let Some((tick, end)) = step {
            let marker = StepEnd { tick: tick as u32, last: end.is_some() };
            self.send(&self.step_end.encode(marker))?;
        }
        Ok(step)
    }

    fn tell(&mut self, at: Instant, synced: &Synced) -> Option<End> {
        let reference = self.route.at(synced.tick, synced.enabled);
        let truth = truth(synced.tick, &synced.state, &reference, synced.torque_nm);
        self.sink.event(at, &Event::Truth(truth));
        if is_lost(&truth) {
            return Some(End::Diverged);
        }
        (synced.tick >= self.ticks).then_some(End::Finished)
    }

    /// A full queue is waited for: nothing else can happen until the frame is
    /// out.
    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        const TRIES: u32 = 50_000;
        for _ in 0..TRIES {
            match self.bus.send(frame) {
                Err(BusError::Full) => {
                    // Only the bus can tell when there is room; what arrives
                    // meanwhile cannot be a SYNC, for none is due.
                    let soon = self.clock.now() + Duration::from_micros(100);
                    if let Some((_, Arrival::Frame(early))) = self.bus.receive(soon)? {
                        self.far_side.take(early);
                    }
                }
                other => return other,
            }
        }
        Err(BusError::Full)
    }
}
