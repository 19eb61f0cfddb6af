//! The command line of `canloop`.

use std::io::Write;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::schema::Profile;

/// Closes a robot's control loop over a CAN bus
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Print the messages of a drive profile as a Markdown table
    #[command(after_help = "\
Examples:
  canloop messages                      the drive that comes with the program
  canloop messages my-drive.toml        a profile of your own, checked while it is read")]
    Messages {
        /// Name of a built-in profile, or path of a profile ending in .toml
        #[arg(default_value = "wheel_drive")]
        profile: String,
    },
}

/// Runs the program. Exit status 2 is bad input.
pub fn main() -> ExitCode {
    let Command::Messages { profile } = Cli::parse().command;
    match Profile::load(&profile) {
        Ok(profile) => {
            // A reader that has closed the pipe has seen enough.
            let _ = std::io::stdout().write_all(profile.dbc.markdown_table().as_bytes());
            ExitCode::SUCCESS
        }
        Err(problems) => {
            eprintln!("{problems}");
            ExitCode::from(2)
        }
    }
}
