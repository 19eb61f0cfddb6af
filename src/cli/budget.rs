//! `canloop budget`: whether the bus can carry a robot's traffic in time.

use std::path::PathBuf;
use std::process::ExitCode;

use super::say;
use crate::budget::{Budget, Report, Terms};
use crate::bus::USUAL_BIT_RATE_BIT_S;
use crate::config::{Problem, Problems};
use crate::stack::RobotFile;
use crate::time::Duration;

/// What `canloop budget` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  canloop budget robot.toml                    with the bit rate that the file says
  canloop budget robot.toml --bitrate 250000   with another
  canloop budget robot.toml --set period_s=0.002
  canloop budget robot.toml --jitter-us 300 --answer-us 200
  canloop budget --json robot.toml

Each message's longest time on the wire, with all stuff bits, and its worst-case
response: from when it is due until it is through, behind the longest frame of
lower priority and all that goes before it. Then the exchange: all that stack and
drives say in one period, one after the other, which must fit into the period.
Without --jitter-us and --answer-us it is the bus alone that is judged; canloop
drive prints how late the loop really is.
Exit status: 0 all is in time, 1 something is not, 2 bad input.")]
pub struct Args {
    /// Robot file; a scenario will do
    #[arg(value_name = "CONFIG")]
    config: PathBuf,
    /// The bus's bit rate, bit/s, whatever the file says
    #[arg(long, value_name = "BIT/S", value_parser = clap::value_parser!(u32).range(10_000..=1_000_000))]
    bitrate: Option<u32>,
    /// Lay KEY=VALUE over the configuration: KEY a dotted path, VALUE as TOML
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// How late the stack's frames leave at most, each time that it speaks, us
    #[arg(long, default_value_t = 0.0, value_name = "MICROSECONDS")]
    jitter_us: f64,
    /// How late the drives' frames leave at most, us
    #[arg(long, default_value_t = 0.0, value_name = "MICROSECONDS")]
    answer_us: f64,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Problems> {
    let lateness = microseconds("--jitter-us", args.jitter_us)?;
    let answer = microseconds("--answer-us", args.answer_us)?;
    let robot = RobotFile::load(&args.config.display().to_string(), &args.overrides)?;
    let known = args.bitrate.or(robot.bit_rate_bit_s);
    let bit_rate_bit_s = known.unwrap_or(USUAL_BIT_RATE_BIT_S);
    let profile = &robot.stack.profile;
    let terms = Terms { period: robot.stack.period, bit_rate_bit_s, lateness, answer };
    let report = Report::of(profile, Budget::of(profile, &terms));
    if args.json {
        say(report.json());
    } else {
        if known.is_none() {
            say(format_args!("{} says no bus.bitrate_bit_s: the usual one is taken", args.config.display()));
        }
        say(&report);
    }
    Ok(ExitCode::from(u8::from(!report.failures.is_empty())))
}

/// The time that an option gives, up to ten seconds.
fn microseconds(option: &str, micros: f64) -> Result<Duration, Problem> {
    if (0.0..=1e7).contains(&micros) {
        return Ok(Duration::from_secs_f64(micros * 1e-6));
    }
    Err(Problem::bare(format!("{option} will not do: found {micros}, expected 0 to 10000000")))
}
