//! `hil-sim scenario`: a scenario as one file.

use std::process::ExitCode;

use super::{Failure, HELD, say};
use crate::scenario::Scenario;

/// What `hil-sim scenario` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  hil-sim scenario dac-friction > robot.toml     for canloop drive --config robot.toml
  hil-sim scenario half-empty.toml               with all that it is based on
  hil-sim scenario cia402 --set seed=7 > mine.toml

The file is checked as for a run. It is based on nothing any more; the path of a
drive profile of your own still counts from where the file is.
Exit status: 0 it is printed, 2 bad input.")]
pub struct Args {
    /// Name of a shipped scenario, or path of a scenario file ending in .toml
    #[arg(value_name = "SCENARIO")]
    scenario: String,
    /// Lay KEY=VALUE over the scenario: KEY a dotted path, VALUE as TOML
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let scenario = Scenario::load(&args.scenario, &args.overrides)?;
    say(scenario.text.trim_end());
    Ok(ExitCode::from(HELD))
}
