//! The far side on a bus, for whatever controller is at the other end of it,
//! in lock-step: each SYNC makes a step, each step ends with the marker.
//!
//! Only what is valid and meant for the drives counts. Anything else on the
//! bus, from whomever, is left alone: it comes when the host's clock likes,
//! and on the simulated wire it would make a run depend on that. Who sent a
//! valid frame, a bus does not tell; like real drives, these obey it.

use std::ops::ControlFlow;

use canloop::bus::{Arrival, BitRates, Bus, BusError, ControllerState};
use canloop::event::{Event, Sink};
use canloop::frame::Frame;
use canloop::run::Clock;
use canloop::schema::{Profile, StepEnd, StepEndCodec};
use canloop::time::{Duration, Instant};

use crate::bench::{End, Outcome, is_lost, truth};
use crate::far_side::{FarSide, Happening, Synced, controller_notice};
use crate::route::Route;
use crate::scenario::Scenario;

/// Drives, plant and wire, impersonated on a bus.
pub struct Server<'r, S> {
    far_side: FarSide,
    profile: Profile,
    bus: &'r mut dyn Bus,
    sink: &'r mut S,
    clock: Clock,
    step_end: StepEndCodec,
    route: Route,
    ticks: u64,
    /// The period that began last, and how the run ends with it if it does.
    begun: Option<(u64, Option<End>)>,
    ignored: u64,
    /// Frames that were lost on the way here.
    lost: u64,
}

/// A run on a bus.
#[derive(Debug)]
pub struct Served {
    /// How it ended.
    pub end: ServeEnd,
    /// The same as of a run in one process.
    pub outcome: Outcome,
    /// Frames that were corrupt or not meant for the drives.
    pub ignored: u64,
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

/// What a look at the bus brought.
enum Heard {
    /// Nothing for the drives.
    Nothing,
    /// A command.
    Command,
    /// A SYNC: which, and how the run ends if it does.
    Sync(u64, Option<End>),
}

/// For how long a controller may say goodbye.
const FAREWELL: Duration = Duration::from_millis(100);
/// How often to look whether somebody wants to stop.
const LOOK_UP: Duration = Duration::from_millis(100);

impl<'r, S: Sink> Server<'r, S> {
    /// The far side of `scenario` on `bus`.
    pub fn new(scenario: &Scenario, rates: BitRates, bus: &'r mut dyn Bus, sink: &'r mut S, clock: Clock) -> Self {
        Self {
            far_side: FarSide::new(scenario, rates, Instant::ZERO),
            profile: scenario.stack.profile.clone(),
            bus,
            sink,
            clock,
            step_end: StepEndCodec::builtin(),
            route: Route::new(scenario),
            ticks: scenario.ticks(),
            begun: None,
            ignored: 0,
            lost: 0,
        }
    }

    /// The far side, for something to go wrong with it.
    pub const fn far_side_mut(&mut self) -> &mut FarSide {
        &mut self.far_side
    }

    /// Serves until the scenario's time is up. Nobody waits for a first SYNC
    /// in vain: `patience` counts from the last frame for the drives on, by the
    /// wall clock.
    pub fn run(mut self, patience: Duration, mut progress: impl FnMut(u64) -> ControlFlow<()>) -> Served {
        let mut tick = 0;
        let mut heard = self.clock.now();
        let end = loop {
            if progress(tick).is_break() {
                break ServeEnd::Run(End::Interrupted);
            }
            match self.hear() {
                Ok(Heard::Nothing) if self.clock.now() - heard > patience => break ServeEnd::Silent,
                Ok(Heard::Nothing) => continue,
                Ok(Heard::Command) => {}
                Ok(Heard::Sync(reached, end)) => {
                    tick = reached;
                    if let Some(end) = end {
                        break ServeEnd::Run(end);
                    }
                }
                Err(error) => break ServeEnd::Lost(error),
            }
            heard = self.clock.now();
        };
        if matches!(end, ServeEnd::Run(End::Finished | End::Diverged)) {
            self.hear_the_controller_out();
        } else {
            self.let_the_wire_finish();
        }
        let mut wire = self.far_side.wire_stats();
        wire.lost += self.lost;
        let outcome = Outcome { end: end.of_the_run(), ticks: tick, wire, state: None };
        Served { end, outcome, ignored: self.ignored }
    }

    /// Waits a little for a frame for the drives, and carries it out.
    fn hear(&mut self) -> Result<Heard, BusError> {
        match self.bus.receive(self.clock.now() + LOOK_UP)? {
            Some((_, Arrival::Frame(frame))) if self.is_for_drives(&frame) => {
                let step = self.take(frame)?;
                Ok(step.map_or(Heard::Command, |(tick, end)| Heard::Sync(tick, end)))
            }
            Some((_, Arrival::Frame(_))) => {
                self.ignored += 1;
                Ok(Heard::Nothing)
            }
            Some((_, Arrival::Lost(frames))) => {
                self.lost += u64::from(frames);
                Ok(Heard::Nothing)
            }
            _ => Ok(Heard::Nothing),
        }
    }

    fn is_for_drives(&self, frame: &Frame) -> bool {
        self.profile.is_for_drives(frame)
    }

    /// A run that is over counts no more frames, but who hangs up on a
    /// controller in mid-sentence may keep it from hearing that it is over.
    fn hear_the_controller_out(&mut self) {
        let deadline = self.clock.now() + FAREWELL;
        while self.clock.now() < deadline && self.bus.receive(deadline).is_ok() {}
    }

    /// What the controller said last is still on the wire, with no SYNC behind
    /// it to move time on.
    fn let_the_wire_finish(&mut self) {
        self.far_side.settle();
        while let Some((at, happening)) = self.far_side.poll() {
            if let Happening::Frame(crossed) | Happening::Unheard(crossed) = happening {
                self.sink.event(at, &Event::Frame(crossed));
            }
        }
    }

    /// Hands a frame to the far side and passes on what comes of it. A step
    /// that is over gives the tick, and how the run ends if it does.
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
                Happening::Synced(synced) => self.begun = Some((synced.tick, self.tell(at, &synced))),
                Happening::Unheard(crossed) => self.sink.event(at, &Event::Frame(crossed)),
                Happening::Controller(state) => self.sink.event(at, &Event::Notice(controller_notice(state))),
                Happening::Answered(state) => {
                    step = self.begun.take();
                    if let Some((tick, end)) = step {
                        let bus_off = state == ControllerState::BusOff;
                        let marker = StepEnd { tick: tick as u32, last: end.is_some(), bus_off };
                        self.send(&self.step_end.encode(marker))?;
                    }
                }
                Happening::Marked(mark) => self.sink.event(at, &Event::Mark(mark)),
            }
        }
        Ok(step)
    }

    fn tell(&mut self, at: Instant, synced: &Synced) -> Option<End> {
        let reference = self.route.at(synced.tick, synced.path_began);
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
                    match self.bus.receive(soon)? {
                        Some((_, Arrival::Frame(early))) if self.is_for_drives(&early) => self.far_side.take(early),
                        Some((_, Arrival::Frame(_))) => self.ignored += 1,
                        _ => {}
                    }
                }
                other => return other,
            }
        }
        Err(BusError::Full)
    }
}
