//! `canloop replay`: lets the stack do again what a log holds.

mod comparison;
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

The log says what went into the stack: frames, wake-ups with all their jitter, what
the operator wanted; and it has the configuration with it. All that goes into a
stack of today in the same order, as fast as it can. Nothing is sent anywhere.

With another configuration the stack's signals are compared, tick by tick. The
robot does not answer to it: what it did is what the log holds.
Exit status: 0 all is the same or within its tolerance, 1 something is not, 2 bad
input.")]
pub struct Args {
    /// Log of a run: of canloop drive, or of hil-sim run
    #[arg(value_name = "FILE.mcap")]
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
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Problems> {
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
