//! `hil-sim map`: a picture of a sweep.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use canloop::config::Problem;
use canloop::report::HeatMap;

use super::{Failure, HELD, say, write_file};
use crate::sweep::{Axes, FILE, PLAN, Plan, map, page};

/// What `hil-sim map` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  hil-sim map sweeps/period-and-delay        the maps that the plan asks for
  hil-sim map sweeps/load --x robot.load.mass_kg --y controller.kp_per_s2
  hil-sim map all.csv --x period_s --y robot.load.mass_kg --value tracking.max_m \\
      --panels controller.law -o map.svg
  hil-sim map all.csv --x period_s --y robot.load.mass_kg --where controller.law=dac-matched

A cell is the mean over the seeds. A hatched one rings; grey is where a run did not go
on to its end, never drove, or was stopped by the safety chain; the red line runs
around what is stable.
Exit status: 0 the picture is written, 2 bad input.")]
pub struct Args {
    /// Folder of a sweep, or a file of results
    #[arg(value_name = "RESULTS")]
    results: PathBuf,
    /// The key from left to right
    #[arg(long, value_name = "KEY", requires = "y")]
    x: Option<String>,
    /// The key from the bottom to the top
    #[arg(long, value_name = "KEY", requires = "x")]
    y: Option<String>,
    /// The figure that is drawn, by its column
    #[arg(long, value_name = "COLUMN", default_value = "tracking.rms_m")]
    value: String,
    /// The key of which each value has a map of its own
    #[arg(long, value_name = "KEY", requires = "x")]
    panels: Option<String>,
    /// Only runs in which a column has this value; may be given several times
    #[arg(long = "where", value_name = "COLUMN=VALUE", requires = "x")]
    only: Vec<String>,
    /// Where to draw it; without it, beside the results
    #[arg(short, long, value_name = "FILE.svg", requires = "x")]
    output: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let results = file_of(&args.results);
    let (Some(x), Some(y)) = (&args.x, &args.y) else {
        return draw_planned(&results);
    };
    let only = args.only.iter().map(|text| {
        let pair = text.split_once('=').map(|(name, value)| (name.to_owned(), value.to_owned()));
        pair.ok_or_else(|| Problem::bare(format!("--where will not do: found {text:?}, expected COLUMN=VALUE")))
    });
    let axes = Axes {
        title: args.value.clone(),
        x: x.clone(),
        y: y.clone(),
        value: args.value.clone(),
        panels: args.panels.clone(),
        only: only.collect::<Result<_, _>>()?,
    };
    let picture = map(&results, &axes).map_err(Problem::bare)?;
    let output = args.output.clone().unwrap_or_else(|| results.with_extension("svg"));
    write_file(&output, &picture.to_svg())?;
    say(format_args!("written          {}", output.display()));
    Ok(ExitCode::from(HELD))
}

/// Draws what the plan beside the results asks for.
fn draw_planned(results: &Path) -> Result<ExitCode, Failure> {
    let plan = std::fs::read_to_string(results.with_file_name(PLAN)).ok().and_then(|text| Plan::parse(&text));
    let Some(plan) = plan.filter(|plan| !plan.maps.is_empty()) else {
        let what = format!("{} has no plan beside it that says what to draw", results.display());
        return Err(Problem::bare(what).help("say it with --x KEY --y KEY").into());
    };
    write_maps(&plan, results)?;
    Ok(ExitCode::from(HELD))
}

/// Draws the maps that a plan asks for beside its results: each as a picture, and a
/// page with all of them.
pub(super) fn write_maps(plan: &Plan, results: &Path) -> Result<(), Failure> {
    let maps: Vec<HeatMap> =
        plan.maps.iter().map(|axes| map(results, axes)).collect::<Result<_, _>>().map_err(Problem::bare)?;
    for (nth, map) in maps.iter().enumerate() {
        let number = if maps.len() == 1 { String::new() } else { format!("-{}", nth + 1) };
        let path = results.with_file_name(format!("map{number}.svg"));
        write_file(&path, &map.to_svg())?;
        say(format_args!("written          {}", path.display()));
    }
    let path = results.with_file_name("report.html");
    write_file(&path, &page(plan, results, maps).map_err(Problem::bare)?.to_html())?;
    say(format_args!("written          {}", path.display()));
    Ok(())
}

fn file_of(results: &Path) -> PathBuf {
    if results.is_dir() { results.join(FILE) } else { results.to_owned() }
}
