//! `hil-sim plant`: the plant alone, open loop.

use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use canloop::config::Problem;

use super::{Failure, HELD};
use crate::scenario::Scenario;
use crate::torque_csv;

/// What `hil-sim plant` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The torque file has the header t_s,torque_right_nm,torque_left_nm. Each row
holds until the next; the last one ends the run. The answer has a row for each:
t_s,x_m,y_m,heading_rad,theta_right_rad,theta_left_rad,omega_right_rad_s,omega_left_rad_s

Examples:
  hil-sim plant dac-friction --torque steps.csv --out answer.csv
  hil-sim plant dac-friction --torque steps.csv --out answer.csv --set 'robot.model=\"rigid-body\"'")]
pub struct Args {
    /// Name of a shipped scenario, or path of a scenario file ending in .toml: robot, friction and start are taken from it
    scenario: String,
    /// Torques at the wheels over time
    #[arg(long, value_name = "IN.csv")]
    torque: PathBuf,
    /// Where the motion goes
    #[arg(long, value_name = "OUT.csv")]
    out: PathBuf,
    /// Lay KEY=VALUE over the scenario: KEY a dotted path, VALUE as TOML
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let scenario = Scenario::load(&args.scenario, &args.overrides)?;
    let rows = torque_csv::read(&args.torque)?;
    let cannot = |error: std::io::Error| Problem::bare(format!("cannot write {}: {error}", args.out.display()));
    let file = std::fs::File::create(&args.out).map_err(cannot)?;
    let mut out = BufWriter::new(file);
    torque_csv::run_open_loop(scenario.plant(), &rows, &mut out).and_then(|()| out.flush()).map_err(cannot)?;
    Ok(ExitCode::from(HELD))
}
