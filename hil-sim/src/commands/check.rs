//! `hil-sim check`: what is wrong with scenarios, before anything runs.

use std::path::PathBuf;
use std::process::ExitCode;

use canloop::check::Checker;

use super::{Failure, say};
use crate::scenario::{SHIPPED, Scenario};

/// What `hil-sim check` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  hil-sim check half-empty.toml
  hil-sim check --json scenarios/*.toml    a line of JSON a finding, for editors

A scenario is looked through with all that it is based on, its drive profile and
its DBC. Profiles and DBC files can be given too, as to canloop check.
Exit status: 0 no error, 1 errors, 2 a file that cannot be read.")]
pub struct Args {
    /// Scenario, drive profile or DBC
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Print a line of JSON for each finding
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let robot = |path: &str| Scenario::load(path, &[]).map(|scenario| scenario.stack);
    let report = Checker { bitrate_bit_s: None, shipped: SHIPPED, robot }.check_all(&args.files);
    report.text(args.json).lines().for_each(say);
    Ok(ExitCode::from(report.exit_status()))
}
