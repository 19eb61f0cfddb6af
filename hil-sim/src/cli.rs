//! The command line.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::commands::{Failure, campaign, check, map, merge, paper, plant, run, scenario, serve, sweep};

/// Impersonates a robot's CAN motor drives, with the robot's dynamics behind them
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Reproduce the paper: every controller, with and without friction, ideal and over CAN
    Paper(paper::Args),
    /// Run scenarios: the control stack over a simulated CAN bus against the simulated robot
    Run(run::Args),
    /// Let everything go wrong, and check what must hold all the same
    Campaign(campaign::Args),
    /// Run thousands of variants of a scenario, a row of figures each
    Sweep(sweep::Args),
    /// Draw a map of a sweep
    Map(map::Args),
    /// Make the parts of a sweep one
    Merge(merge::Args),
    /// Impersonate the drives on a bus, for any controller
    Serve(serve::Args),
    /// Run the plant alone, open loop, from a file of torques
    Plant(plant::Args),
    /// Print a scenario as one file, with all that it is based on
    Scenario(scenario::Args),
    /// Look through scenarios before they run
    Check(check::Args),
}

/// Runs the program.
pub fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Paper(args) => paper::run(&args),
        Command::Run(args) => run::run(&args),
        Command::Campaign(args) => campaign::run(&args),
        Command::Sweep(args) => sweep::run(&args),
        Command::Map(args) => map::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::Serve(args) => serve::run(&args),
        Command::Plant(args) => plant::run(&args),
        Command::Scenario(args) => scenario::run(&args),
        Command::Check(args) => check::run(&args),
    };
    result.unwrap_or_else(|failure: Failure| failure.report())
}
