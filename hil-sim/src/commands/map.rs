//! `hil-sim map`: a picture of a sweep.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use canloop::config::Problem;

use super::{Failure, HELD, say, write_file};
use crate::sweep::{Axes, FILE, map};

/// What `hil-sim map` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  hil-sim map sweeps/load-and-belief --x robot.load.mass_kg \\
      --y controller.model.load.mass_kg --value tracking.rms_m
  hil-sim map all.csv --x period_s --y controller.law --value tracking.max_m -o map.svg
  hil-sim map all.csv --x period_s --y robot.load.mass_kg --value tracking.rms_m \\
      --where controller.law=dac-matched

A cell is the mean over the seeds. Grey is where a run did not go on to its end,
rang, or was stopped by the safety chain; the red line runs around it.
Exit status: 0 the picture is written, 2 bad input.")]
pub struct Args {
    /// Folder of a sweep, or a file of results
    #[arg(value_name = "RESULTS")]
    results: PathBuf,
    /// The key from left to right
    #[arg(long, value_name = "KEY")]
    x: String,
    /// The key from the bottom to the top
    #[arg(long, value_name = "KEY")]
    y: String,
    /// The figure that is drawn, by its column
    #[arg(long, value_name = "COLUMN", default_value = "tracking.rms_m")]
    value: String,
    /// Only runs in which a column has this value; may be given several times
    #[arg(long = "where", value_name = "COLUMN=VALUE")]
    only: Vec<String>,
    /// Where to draw it; without it, beside the results
    #[arg(short, long, value_name = "FILE.svg")]
    output: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let only = args.only.iter().map(|text| {
        let pair = text.split_once('=').map(|(name, value)| (name.to_owned(), value.to_owned()));
        pair.ok_or_else(|| Problem::bare(format!("--where will not do: found {text:?}, expected COLUMN=VALUE")))
    });
    let only = only.collect::<Result<_, _>>()?;
    let results = file_of(&args.results);
    let picture = map(&results, &Axes { x: &args.x, y: &args.y, value: &args.value, only }).map_err(Problem::bare)?;
    let output = args.output.clone().unwrap_or_else(|| results.with_extension("svg"));
    write_file(&output, &picture.to_svg())?;
    say(format_args!("written          {}", output.display()));
    Ok(ExitCode::from(HELD))
}

fn file_of(results: &Path) -> PathBuf {
    if results.is_dir() { results.join(FILE) } else { results.to_owned() }
}
