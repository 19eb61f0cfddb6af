//! `hil-sim merge`: the parts of a sweep made one.

use std::path::PathBuf;
use std::process::ExitCode;

use canloop::config::Problem;

use super::{FAILED, Failure, HELD, say};
use crate::sweep::{Merged, Parts};

/// What `hil-sim merge` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  hil-sim merge sweeps/load-*-of-8 -o load.csv

The order of the folders does not matter. A run that is in several of them is kept
once; runs that are missing are named.
Exit status: 0 nothing is missing, 1 something is, 2 bad input, such as parts of
different plans.")]
pub struct Args {
    /// Folders of parts
    #[arg(value_name = "DIR", required = true)]
    folders: Vec<PathBuf>,
    /// Where to write all rows
    #[arg(short, long, value_name = "FILE.csv")]
    output: PathBuf,
}

/// Missing stretches that are told one by one.
const MOST_TOLD: usize = 20;

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let Merged { rows, duplicates, gaps } =
        Parts::open(&args.folders).and_then(|parts| parts.to_csv(&args.output)).map_err(Problem::bare)?;
    say(format_args!("{rows} runs, {duplicates} of them several times, -> {}", args.output.display()));
    for (first, last) in gaps.iter().take(MOST_TOLD) {
        say(if first == last { format!("missing: run {first}") } else { format!("missing: runs {first} to {last}") });
    }
    if gaps.len() > MOST_TOLD {
        say(format_args!("... and {} stretches more", gaps.len() - MOST_TOLD));
    }
    Ok(ExitCode::from(if gaps.is_empty() { HELD } else { FAILED }))
}
