//! `canloop check`: what is wrong with input files, before anything runs.

use std::path::PathBuf;
use std::process::ExitCode;

use super::say;
use crate::check::Checker;
use crate::config::Problems;
use crate::stack::RobotFile;

/// What `canloop check` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  canloop check my-drive.dbc                   one file
  canloop check dbc/*.dbc dbc/*.toml           many
  canloop check --bitrate 250000 my-drive.dbc  and whether a bus of 250 kbit/s carries it
  canloop check --json robot.toml              a line of JSON a finding, for editors

What a file is for is seen by its extension and its contents. A robot file is
looked through together with its profile, a profile together with its DBC. Of a
scenario, what the control stack reads is checked; hil-sim check knows the rest.
Errors are what nothing can run on, warnings what is worth a second look.
Exit status: 0 no error, 1 errors, 2 a file that cannot be read.")]
pub struct Args {
    /// DBC, drive profile, robot or scenario
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// The bus's bit rate, bit/s, where a file does not say
    #[arg(long, value_name = "BIT/S", value_parser = clap::value_parser!(u32).range(10_000..=1_000_000))]
    bitrate: Option<u32>,
    /// Print a line of JSON for each finding
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Problems> {
    let robot = |path: &str| RobotFile::load(path, &[]).map(|robot| robot.stack);
    let report = Checker { bitrate_bit_s: args.bitrate, shipped: &[], robot }.check_all(&args.files);
    report.text(args.json).lines().for_each(say);
    Ok(ExitCode::from(report.exit_status()))
}
