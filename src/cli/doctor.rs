//! `canloop doctor`: what this machine, and a bus, allow a control loop.

use std::process::ExitCode;

use super::say;
use crate::bus::Address;
use crate::config::{Problem, Problems};
use crate::run::doctor::{Machine, Outcome, PERIOD, examine};

/// What `canloop doctor` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  canloop doctor                      the machine alone
  canloop doctor --bus can0           and whether can0 is set up for a control loop
  canloop doctor --bus tcp://127.0.0.1:29536/can0
  canloop doctor --seconds 60         measure wake-ups for longer: the rare ones count
  chrt -f 40 canloop doctor           wake-ups as a real-time thread has them
  canloop doctor --quick --json

Each line says OK, degraded or missing, what was found, and below it the command
that mends it. Nothing is changed. A period T is called fine when the latest of
the measured wake-ups was late by no more than a tenth of it.
Exit status: 0 nothing is missing, 1 something is, 2 bad input.")]
pub struct Args {
    /// Look at this bus too: can0, vcan0, or tcp://HOST:PORT/NAME
    #[arg(long)]
    bus: Option<String>,
    /// How long to measure wake-ups, s
    #[arg(long, default_value_t = 1.0, value_name = "SECONDS")]
    seconds: f64,
    /// Measure wake-ups for a tenth of a second only
    #[arg(long, conflicts_with = "seconds")]
    quick: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

const QUICK_S: f64 = 0.1;

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Problems> {
    let bus = args.bus.as_deref().map(bus_to_look_at).transpose()?;
    let wake_ups = wake_ups(if args.quick { QUICK_S } else { args.seconds })?;
    let report = examine(&Machine::here(), bus.as_ref(), wake_ups);
    match args.json {
        true => say(serde_json::to_string_pretty(&report).map_err(|error| Problem::bare(error.to_string()))?),
        false => say(&report),
    }
    Ok(ExitCode::from(u8::from(report.outcome == Outcome::Missing)))
}

fn bus_to_look_at(text: &str) -> Result<Address, Problem> {
    match Address::parse(text)? {
        Address::Listen(endpoint) => Err(Problem::bare(format!("{text}: a bus that is yet to be served"))
            .help(format!("serve it first, then look at {endpoint}"))),
        address => Ok(address),
    }
}

/// How many wake-ups fill so many seconds.
fn wake_ups(seconds: f64) -> Result<usize, Problem> {
    if (0.01..=3_600.0).contains(&seconds) {
        return Ok((seconds / PERIOD.as_secs_f64()).round() as usize);
    }
    Err(Problem::bare(format!("--seconds will not do: found {seconds}, expected 0.01 to 3600")))
}
