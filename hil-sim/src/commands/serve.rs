//! `hil-sim serve`: the drives impersonated on a bus, for any controller.

use std::path::PathBuf;
use std::process::ExitCode;

use canloop::bus::{self, OpenOptions};
use canloop::cli::{self, WatchArgs};
use canloop::config::Problem;
use canloop::run::{self, Clock};
use canloop::time::Instant;

use super::conclusion::conclude;
use super::pace::{Pace, RealTimeFactor};
use super::progress::Progress;
use super::run::logged_to;
use super::{FAILED, Failure, HELD, INTERRUPTED, create_folder, interrupt, say};
use crate::bench::End;
use crate::recording::Recording;
use crate::scenario::{Link, Scenario};
use crate::serve::{ServeEnd, Served, Server};
use crate::wall::WallServer;

/// What `hil-sim serve` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Each SYNC moves the plant on by the scenario's period; when the drives have
answered, the marker StepEnd of dbc/sim.dbc ends the step. A stack that waits
for it runs in lock-step, and nothing depends on the host's speed.

Examples:
  hil-sim serve dac-friction --bus vcan0
  hil-sim serve dac-friction --bus tcp-listen://127.0.0.1:29536/can0
  hil-sim serve dac-friction --bus vcan0 --live      a page to look on

Exit status: 0 all expectations hold, 1 one does not or the controller fell
silent, 2 bad input or no bus, 130 ended by Ctrl-C.")]
pub struct Args {
    /// Name of a shipped scenario, or path of a scenario file ending in .toml
    scenario: String,
    /// can0, vcan0, tcp://HOST:PORT/NAME, or tcp-listen://HOST:PORT/NAME to host a bus
    #[arg(long)]
    bus: String,
    /// What the plant's time goes by
    #[arg(long, value_enum, default_value_t = Time::Sync)]
    time: Time,
    /// Lay KEY=VALUE over the scenario: KEY a dotted path, VALUE as TOML
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Where run.mcap and summary.json go
    #[arg(long, value_name = "DIR", default_value = "runs")]
    out: PathBuf,
    /// Write no log, only summary.json
    #[arg(long)]
    no_log: bool,
    /// How long, by the wall clock, the controller may be silent, s
    #[arg(long, default_value_t = 30.0, value_name = "SECONDS")]
    dead_man_s: f64,
    /// Let other machines reach a bus that is hosted here
    #[arg(long)]
    allow_others: bool,
    #[command(flatten)]
    watch: WatchArgs,
    /// In lock-step: how many seconds to simulate a second at most: a number, or max [default: max; 1 where somebody looks on]
    #[arg(long, value_name = "FACTOR", value_parser = RealTimeFactor::parse)]
    real_time_factor: Option<RealTimeFactor>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Time {
    /// Each SYNC is a period: lock-step
    Sync,
    /// The clock: real time
    Wall,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let scenario = Scenario::load(&args.scenario, &args.overrides)?;
    let Link::Can(rates) = scenario.link else {
        let problem = Problem::bare(format!("`{}` has an ideal link, which no bus can be", scenario.name));
        return Err(problem.help("serve a scenario with bus.link = \"can\"").into());
    };
    let patience = cli::seconds("--dead-man-s", args.dead_man_s)?;
    if args.time == Time::Wall {
        RealTimeFactor::refuse(args.real_time_factor)?;
    }
    let live = args.watch.open()?;
    let clock = Clock::new();
    let options = OpenOptions {
        bit_rate_bit_s: Some(rates.nominal_bit_s),
        allow_others: args.allow_others,
        ..OpenOptions::default()
    };
    let mut bus = bus::open(&args.bus, &options, clock)?;
    create_folder(&args.out)?;
    let recording = logged_to(Recording::of_another_stack(&scenario), &args.out, !args.no_log)?;
    let start = if args.time == Time::Sync { Instant::ZERO } else { clock.now() };
    let mut recording = recording.with_live(&live, "hil-sim serve", start);
    interrupt::listen();
    say(format_args!("serving {} on {}", scenario.name, args.bus));
    let mut progress = Progress::new(scenario.name.clone(), scenario.ticks());
    let mut watch = |tick| {
        progress.at(tick);
        interrupt::check()
    };
    let Served { end, outcome, ignored } = match args.time {
        Time::Sync => {
            let factor = RealTimeFactor::or_default(args.real_time_factor, live.is_watched());
            let mut pace = None;
            // Time begins with the first period, however long the controller is waited for.
            let paced = |tick| {
                if tick > 0 {
                    pace.get_or_insert_with(|| Pace::new(factor, &scenario)).keep(tick);
                }
                watch(tick)
            };
            Server::new(&scenario, rates, bus.as_mut(), &mut recording, clock).run(patience, paced)
        }
        Time::Wall => {
            raise_priority();
            WallServer::new(&scenario, rates, bus.as_mut(), &mut recording, clock).run(patience, watch)
        }
    };
    progress.done();
    let summary = conclude(&scenario, recording.finish(&outcome), &args.out, progress.elapsed_s())?;
    if ignored > 0 {
        say(format_args!("  ignored          {ignored} frames that were corrupt or not meant for the drives"));
    }
    match end {
        ServeEnd::Silent => {
            say(format_args!("  ended            nothing came from the controller for {} s", args.dead_man_s));
            Ok(ExitCode::from(FAILED))
        }
        ServeEnd::Lost(error) => Err(Failure::Broken(error.to_string())),
        ServeEnd::Run(End::Interrupted) => Ok(ExitCode::from(INTERRUPTED)),
        ServeEnd::Run(_) => Ok(ExitCode::from(if summary.passed { HELD } else { FAILED })),
    }
}

/// Drives answer at once; where this program may not, it says so. The log's
/// threads run already, and keep an ordinary priority.
fn raise_priority() {
    for degraded in run::raise() {
        say(format_args!("  degraded         {}", degraded.refusal));
    }
}
