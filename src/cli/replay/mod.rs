//! `canloop replay`: lets the stack do again what a log holds.

mod comparison;
mod onto;
mod origin;
mod same;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::say;
use crate::config::{Problem, Problems};
use comparison::Comparison;
use origin::Origin;

/// What `canloop replay` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  canloop replay run.mcap                           is every frame the same, bit for bit?
  canloop replay run.mcap --set controller.kp_per_s2=0.7
                                                    what would be sent with another gain
  canloop replay run.mcap --config robot.toml --tolerance torque_sent_right_nm=0.5 --report replay.html
  canloop replay drive.log --onto vcan0             play the frames of any log onto a bus
  canloop replay drive.blf --onto can0 --from-bus can1 --speed 0.5 --loop 10

The log says what went into the stack: frames, wake-ups with all their jitter, what
the operator wanted; and it has the configuration with it. All that goes into a
stack of today in the same order, as fast as it can. Nothing is sent anywhere.

With another configuration the stack's signals are compared, tick by tick. robot does not answer to it: what it did is what the log holds.

With --onto the frames of one bus of the log, whatever its format, are sent onto a
bus at their moments, counted from the first: a late one makes none after it late.
Exit status: 0 all is the same or within its tolerance, 1 something is not, 2 bad
input.")]
pub struct Args {
    /// Log of a run: of canloop drive, or of hil-sim run; with --onto any log
    #[arg(value_name = "FILE")]
    log: PathBuf,
    /// Robot file or scenario in place of the one in the log
    #[arg(long, value_name = "FILE.toml")]
    config: Option<PathBuf>,
    /// Lay KEY=VALUE over the configuration: KEY a dotted path, VALUE as TOML
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// By how much a signal of the stack may differ; others may not at all
    #[arg(long = "tolerance", value_name = "SIGNAL=VALUE")]
    tolerances: Vec<String>,
    /// Write a page with the signals that differ, as recorded and as replayed
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Play the log's frames onto this bus
    #[arg(long, value_name = "BUS", conflicts_with_all = ["config", "overrides", "tolerances", "report"])]
    onto: Option<String>,
    /// The bus of the log to be played, where it has several
    #[arg(long, value_name = "NAME", requires = "onto")]
    from_bus: Option<String>,
    /// How many times as fast as it was
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, requires = "onto")]
    speed: f64,
    /// How often to play it
    #[arg(long = "loop", value_name = "TIMES", default_value_t = 1, requires = "onto",
        value_parser = clap::value_parser!(u32).range(1..))]
    times: u32,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Problems> {
    if let Some(bus) = &args.onto {
        return onto::run(&args.log, bus, args.from_bus.as_deref(), args.speed, args.times);
    }
    let log = std::fs::read(&args.log)
        .map_err(|error| Problem::bare(format!("cannot read {}: {error}", args.log.display())))?;
    let origin = Origin::find(&log, &args.log, args.config.as_deref(), &args.overrides)?;
    let compares = args.config.is_some() || !args.overrides.is_empty();
    if compares || !args.tolerances.is_empty() || args.report.is_some() {
        let comparison = Comparison::new(&args.tolerances)?;
        return comparison.run(&origin, &log, &args.log, args.report.as_deref());
    }
    same::run(&origin, &log, &args.log)
}

/// What is wrong with a log, as a message.
fn broken(path: &Path, what: &str) -> Problem {
    Problem::bare(format!("{} cannot be replayed: {what}", path.display()))
}

/// Says where a log that was cut off ends.
fn say_cut(is_cut: bool) {
    if is_cut {
        say("  note             the log was never ended: replayed as far as its whole chunks reach");
    }
}
