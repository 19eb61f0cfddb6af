//! The command line of `canloop`.

mod budget;
mod check;
mod convert;
#[cfg(target_os = "linux")]
mod doctor;
mod drive;
mod log;
mod log_file;
mod repair;
mod replay;
mod report;
mod show;
mod stop;
mod watch;

use std::fmt::Display;
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
pub use watch::WatchArgs;

use crate::config::{Document, Problem, Problems};
use crate::schema::Profile;
use crate::stack::RobotFile;
use crate::time::Duration;

/// The input was bad, or the bus or the log could not be had.
const BAD_INPUT: u8 = 2;

/// Closes a robot's control loop over a CAN bus
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Drive a robot: run the control stack on a CAN bus
    Drive(drive::Args),
    /// Look at what this machine, and a bus, allow a control loop
    #[cfg(target_os = "linux")]
    Doctor(doctor::Args),
    /// Look through DBC files, drive profiles, robot files and scenarios
    Check(check::Args),
    /// Tell whether the bus can carry a robot's traffic in time
    Budget(budget::Args),
    /// Write a log of a bus in another format
    Convert(convert::Args),
    /// Log buses to an MCAP file
    Log(log::Args),
    /// Let the stack do again what a log holds, and compare
    Replay(replay::Args),
    /// Make a page of a log
    Report(report::Args),
    /// Make a log that breaks off one that all readers open
    Repair(repair::Args),
    /// Look at what is in a log of a bus
    Show(show::Args),
    /// Print the messages of a drive profile as a Markdown table
    #[command(after_help = "\
Examples:
  canloop messages                      the drive that comes with the program
  canloop messages odrive-0.6           another one that comes along
  canloop messages my-drive.toml        a profile of your own, checked while it is read
  canloop messages robot.toml           a robot's, with the node ids of its drives")]
    Messages {
        /// Name of a built-in profile, or path of a profile or a robot file ending in .toml
        #[arg(default_value = "wheel_drive")]
        profile: String,
    },
}

/// Runs the program. Exit status 2 is bad input.
pub fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Drive(args) => drive::run(&args),
        #[cfg(target_os = "linux")]
        Command::Doctor(args) => doctor::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Budget(args) => budget::run(&args),
        Command::Convert(args) => convert::run(&args),
        Command::Log(args) => log::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Repair(args) => repair::run(&args),
        Command::Show(args) => show::run(&args),
        Command::Messages { profile } => messages(&profile),
    };
    result.unwrap_or_else(|problems| {
        eprintln!("{problems}");
        ExitCode::from(BAD_INPUT)
    })
}

fn messages(profile: &str) -> Result<ExitCode, Problems> {
    say(profile_of(profile)?.dbc.markdown_table().trim_end());
    Ok(ExitCode::SUCCESS)
}

/// A profile by its name or path, or that of the robot in a file.
fn profile_of(name_or_path: &str) -> Result<Profile, Problems> {
    let is_robot = name_or_path.ends_with(".toml") && Document::read(Path::new(name_or_path))?.has("drive");
    if is_robot { Ok(RobotFile::load(name_or_path, &[])?.stack.profile) } else { Profile::load(name_or_path) }
}

/// The time that an option gives, from a millisecond to a day.
///
/// # Errors
/// Any other number, with the option's name.
pub fn seconds(option: &str, seconds: f64) -> Result<Duration, Problem> {
    if (0.001..=86_400.0).contains(&seconds) {
        return Ok(Duration::from_secs_f64(seconds));
    }
    Err(Problem::bare(format!("{option} will not do: found {seconds}, expected 0.001 to 86400")))
}

/// Prints a line, unless nobody reads any more.
fn say(line: impl Display) {
    let _ = writeln!(std::io::stdout(), "{line}");
}
