//! The figures of a run, as `summary.json` holds them.

use canloop::event::{Event, Mark, Sink, Truth};
use canloop::frame::Frame;
use canloop::robot::Pose;
use canloop::schema::{Message, Profile};
use canloop::time::Instant;
use canloop::wheels::Wheel;
use serde::Serialize;

use crate::bench::{End, Outcome};
use crate::expect::{Occurrence, Verdict, Watch};
use crate::frames_hash::FramesHash;
use crate::scenario::{Link, Scenario};
use crate::wire::NodeStats;

/// All figures of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// The scenario's name.
    pub scenario: String,
    /// The scenario's seed.
    pub seed: u64,
    /// Overrides laid over the scenario.
    pub overrides: Vec<String>,
    /// Version of the program.
    pub version: &'static str,
    /// The command that runs the same again; `null` where the stack was another
    /// program.
    pub reproduce: Option<String>,
    /// Whether all expectations held.
    pub passed: bool,
    /// `finished`, `diverged`, `blocked`, `silent` or `interrupted`.
    pub end: &'static str,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// T, s.
    pub period_s: f64,
    /// Periods simulated.
    pub ticks: u64,
    /// The control law.
    pub law: &'static str,
    /// `can` or `ideal`.
    pub link: &'static str,
    /// What the stack was doing at the end; `null` on an ideal link.
    pub state: Option<&'static str>,
    /// How well the robot kept to its path.
    pub tracking: Tracking,
    /// What the controller asked of the motors.
    pub torque: TorqueFigures,
    /// Whether the torque never settled.
    pub rings: bool,
    /// What crossed the bus.
    pub bus: BusFigures,
    /// The hash of every frame that crossed: [`FramesHash`].
    pub frames_blake3: String,
    /// What the figures mean, where something went wrong.
    pub findings: Vec<String>,
    /// Every expectation and how it fared.
    pub expectations: Vec<Verdict>,
    /// What was logged; `null` without a log.
    pub log: Option<LogFigures>,
}

/// Errors against the path, at every tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Tracking {
    /// Root mean square of the position error, m.
    pub rms_m: f64,
    /// Largest position error, m.
    pub max_m: f64,
    /// Position error at the end, m.
    pub final_m: f64,
    /// Heading error at the end, wrapped to +-pi, rad.
    pub final_heading_rad: f64,
    /// Largest position error from 30 s on, m; `null` in a shorter run.
    pub max_after_30s_m: Option<f64>,
    /// How far the middle of the axle has come, forwards or backwards, m.
    pub travelled_m: f64,
}

/// Torque that the stack sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TorqueFigures {
    /// Largest at either wheel, N m.
    pub max_nm: f64,
    /// Mean absolute step from sample to sample, right wheel, N m.
    pub chatter_nm: f64,
}

/// What crossed the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BusFigures {
    /// Frames delivered.
    pub frames: u64,
    /// Frames lost because a transmit queue was full.
    pub lost: u64,
    /// Attempts to send that ended in an error frame.
    pub error_frames: u64,
    /// Frames that faults took, or that were thrown away off the bus.
    pub discarded: u64,
    /// Share of the time that the bus was busy, percent.
    pub load_percent: f64,
    /// What each node can tell of itself at the end.
    pub nodes: Nodes,
}

/// What the nodes of the bus can tell of themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Nodes {
    /// The stack's controller.
    pub stack: NodeStats,
    /// The right wheel's drive.
    pub right: NodeStats,
    /// The left wheel's drive.
    pub left: NodeStats,
}

/// What went into the log.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LogFigures {
    /// Messages written.
    pub messages: u64,
    /// Times that the run waited for the log's queue.
    pub queue_full: u64,
}

/// Gathers figures while a run goes on.
pub struct Gauge {
    period_s: f64,
    tracking: Tracking,
    squares_m2: f64,
    samples: u64,
    last_pose: Option<Pose>,
    torque: TorqueFigures,
    steps_nm: f64,
    steps: u64,
    last_right_nm: Option<f64>,
    /// Reads torques from the commands on the bus, where the stack that sent
    /// them is somebody else's and tells nothing.
    commands: Option<Profile>,
    frames: FramesHash,
    /// Names of the scenario's events.
    planned: Vec<String>,
    watches: Vec<Watch>,
}

impl Summary {
    /// How the run went, in a word: `passed`, `failed` or `interrupted`.
    pub fn verdict(&self) -> &'static str {
        match (self.end, self.passed) {
            ("interrupted", _) => "interrupted",
            (_, true) => "passed",
            (_, false) => "failed",
        }
    }

    /// The command that runs the same again, or nothing.
    pub fn reproduce_line(&self) -> &str {
        self.reproduce.as_deref().unwrap_or_default()
    }
}

impl Gauge {
    /// Nothing gathered yet.
    pub fn new(scenario: &Scenario) -> Self {
        let period_s = scenario.period_s();
        Self {
            period_s,
            tracking: Tracking::default(),
            squares_m2: 0.0,
            samples: 0,
            last_pose: None,
            torque: TorqueFigures::default(),
            steps_nm: 0.0,
            steps: 0,
            last_right_nm: None,
            commands: None,
            frames: FramesHash::new(),
            planned: scenario.events.iter().map(|event| event.name.clone()).collect(),
            watches: scenario.expectations.iter().map(|expectation| expectation.watch(period_s)).collect(),
        }
    }

    /// The same for a run whose stack is another program: its torques are
    /// those of its commands.
    pub fn of_commands(scenario: &Scenario) -> Self {
        let gauge = Self::new(scenario);
        let watches = gauge.watches.into_iter().map(|watch| watch.without_the_stack(&gauge.planned)).collect();
        Self { commands: Some(scenario.stack.profile.clone()), watches, ..gauge }
    }

    /// The figures, once the run is over.
    pub fn summary(self, scenario: &Scenario, outcome: &Outcome) -> Summary {
        let expectations: Vec<Verdict> = self.watches.iter().map(Watch::verdict).collect();
        let simulated_s = outcome.ticks as f64 * self.period_s;
        let rms_m = (self.squares_m2 / self.samples.max(1) as f64).sqrt();
        let [stack, right, left] = outcome.wire.nodes;
        let chatter_nm = self.steps_nm / self.steps.max(1) as f64;
        let mut summary = Summary {
            scenario: scenario.name.clone(),
            seed: scenario.seed,
            overrides: scenario.overrides.clone(),
            version: env!("CARGO_PKG_VERSION"),
            reproduce: self.commands.is_none().then(|| crate::reproduce::command(scenario)),
            passed: !matches!(outcome.end, End::Interrupted | End::Silent | End::Blocked)
                && expectations.iter().all(|verdict| verdict.passed),
            end: match outcome.end {
                End::Finished => "finished",
                End::Diverged => "diverged",
                End::Blocked => "blocked",
                End::Silent => "silent",
                End::Interrupted => "interrupted",
            },
            simulated_s,
            period_s: self.period_s,
            ticks: outcome.ticks,
            law: scenario.stack.controller.law.name(),
            link: if scenario.link == Link::Ideal { "ideal" } else { "can" },
            state: outcome.state.map(|state| state.name()),
            tracking: Tracking { rms_m, ..self.tracking },
            torque: TorqueFigures { chatter_nm, ..self.torque },
            rings: crate::findings::rings(chatter_nm, scenario),
            bus: BusFigures {
                frames: outcome.wire.frames,
                lost: outcome.wire.lost,
                error_frames: outcome.wire.error_frames,
                discarded: outcome.wire.discarded,
                nodes: Nodes { stack, right, left },
                load_percent: 100.0 * outcome.wire.busy.as_secs_f64()
                    / outcome.wire.until.as_secs_f64().max(simulated_s).max(self.period_s),
            },
            frames_blake3: self.frames.finish(),
            findings: Vec::new(),
            expectations,
            log: None,
        };
        summary.findings = crate::findings::findings(scenario, &summary, outcome);
        summary
    }

    fn take_truth(&mut self, truth: &Truth) {
        let error_m = truth.position_error_m;
        self.samples += 1;
        self.squares_m2 += error_m * error_m;
        self.tracking.travelled_m +=
            self.last_pose.replace(truth.pose).map_or(0.0, |last| last.distance_m(&truth.pose));
        self.tracking.max_m = self.tracking.max_m.max(error_m);
        self.tracking.final_m = error_m;
        self.tracking.final_heading_rad = truth.heading_error_rad;
        if truth.tick as f64 * self.period_s >= 30.0 - 0.5 * self.period_s {
            let so_far = self.tracking.max_after_30s_m.unwrap_or(0.0);
            self.tracking.max_after_30s_m = Some(so_far.max(error_m));
        }
    }

    fn take_torque(&mut self, wheel: Wheel, torque_nm: f64) {
        self.torque.max_nm = self.torque.max_nm.max(torque_nm.abs());
        if wheel == Wheel::Left {
            return;
        }
        if let Some(last_nm) = self.last_right_nm.replace(torque_nm) {
            self.steps_nm += (torque_nm - last_nm).abs();
            self.steps += 1;
        }
    }

    fn take_mark(&mut self, at: Instant, mark: &Mark) {
        if mark.has_begun {
            let occurrence = Occurrence { name: &self.planned[usize::from(mark.event)], at_s: at.as_secs_f64() };
            self.watches.iter_mut().for_each(|watch| watch.take(occurrence));
        }
    }

    fn take_frame(&mut self, at: Instant, frame: &Frame) {
        self.frames.take(at, frame);
        let decoded = self.commands.as_ref().map(|profile| profile.decode(frame));
        if let Some(Ok(Message::Command(wheel, command))) = decoded {
            self.take_torque(wheel, command.torque_nm);
        }
    }
}

impl Sink for Gauge {
    fn event(&mut self, at: Instant, event: &Event) {
        match event {
            Event::Frame(crossed) => self.take_frame(at, &crossed.frame),
            Event::Truth(truth) => self.take_truth(truth),
            Event::Tick(tick) => {
                Wheel::BOTH.into_iter().for_each(|wheel| self.take_torque(wheel, tick.torque_sent_nm[wheel]))
            }
            Event::Mark(mark) => self.take_mark(at, mark),
            Event::Sync(_) | Event::Timing(_) | Event::Notice(_) | Event::Exchange(_) => {}
        }
        self.watches.iter_mut().for_each(|watch| watch.event(at, event));
    }
}
