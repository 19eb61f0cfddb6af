//! `hil-sim merge`: the parts of a sweep made one.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use canloop::config::Problem;

use super::{FAILED, Failure, HELD, say};
use crate::sweep::{Merged, Parts, to_parquet};

/// What `hil-sim merge` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  hil-sim merge sweeps/load-*-of-8 -o load.csv        load.csv, and load.parquet beside it
  hil-sim merge sweeps/load-*-of-8 -o load.parquet    load.parquet alone

The order of the folders does not matter. A run that is in several of them is kept
once; runs that are missing are named.
Exit status: 0 nothing is missing, 1 something is, 2 bad input, such as parts of
different plans.")]
pub struct Args {
    /// Folders of parts
    #[arg(value_name = "DIR", required = true)]
    folders: Vec<PathBuf>,
    /// Where to write all rows as CSV, and beside it as Parquet; a name that ends in .parquet for that alone
    #[arg(short, long, value_name = "FILE.csv")]
    output: PathBuf,
}

/// How the names of Parquet files end.
const PARQUET: &str = "parquet";
/// Missing stretches that are told one by one.
const MOST_TOLD: usize = 20;

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let parts = Parts::open(&args.folders).map_err(Problem::bare)?;
    let Merged { rows, duplicates, gaps } = written(parts, &args.output)?;
    say(format_args!("{rows} runs, {duplicates} of them several times, -> {}", args.output.display()));
    for (first, last) in gaps.iter().take(MOST_TOLD) {
        say(if first == last { format!("missing: run {first}") } else { format!("missing: runs {first} to {last}") });
    }
    if gaps.len() > MOST_TOLD {
        say(format_args!("... and {} stretches more", gaps.len() - MOST_TOLD));
    }
    Ok(ExitCode::from(if gaps.is_empty() { HELD } else { FAILED }))
}

fn written(parts: Parts, output: &Path) -> Result<Merged, Failure> {
    if output.extension().is_some_and(|extension| extension == PARQUET) {
        return Ok(parts.to_parquet(output).map_err(Problem::bare)?);
    }
    let plan = parts.plan();
    let merged = parts.to_csv(output).map_err(Problem::bare)?;
    // Beside a pipe or a device there is no place for another file.
    if output.is_file() {
        let written = plan.and_then(|plan| to_parquet(output, &output.with_extension(PARQUET), &plan));
        written.map_err(|error| Failure::Broken(format!("{error}; {} has all rows", output.display())))?;
    }
    Ok(merged)
}
