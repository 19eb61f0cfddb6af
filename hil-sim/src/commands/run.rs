//! `hil-sim run`: scenarios, their figures and their logs.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use canloop::cli::WatchArgs;
use canloop::config::{Problem, Problems};
use canloop::live::Live;
use canloop::time::Instant;

use super::conclusion::{LOG_NAME, conclude, print_all};
use super::pace::{Pace, RealTimeFactor};
use super::progress::Progress;
use super::{FAILED, Failure, HELD, INTERRUPTED, create_folder, interrupt, say, write_file};
use crate::recording::Recording;
use crate::report::annotation::annotations;
use crate::report::junit::{Timed, junit};
use crate::scenario::Scenario;

/// What `hil-sim run` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  hil-sim run dac-friction                        a shipped scenario
  hil-sim run my.toml --set controller.filter=1   a file, with one key changed
  hil-sim run dac-friction --set 'controller.law=\"dac\"' --out runs/dac
  hil-sim run dac-friction line figure-eight      a folder each under runs/
  hil-sim run dac-friction --live                 in real time, with a page to look on
  hil-sim run scenarios/*.toml --junit junit.xml  for CI: every expectation a test case

Where GITHUB_ACTIONS is true, what does not hold is annotated in the scenario.
Exit status: 0 all expectations hold, 1 one does not, 2 bad input (nothing is
written), 130 ended by Ctrl-C (the log up to there can be read).")]
pub struct Args {
    /// Names of shipped scenarios, or paths of scenario files ending in .toml
    #[arg(required_unless_present = "list", value_name = "SCENARIO")]
    scenarios: Vec<String>,
    /// Lay KEY=VALUE over the scenario: KEY a dotted path, VALUE as TOML
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Where run.mcap, summary.json and report.html go; with several scenarios, a folder each in it
    #[arg(long, value_name = "DIR", default_value = "runs")]
    out: PathBuf,
    /// Write no log
    #[arg(long)]
    no_log: bool,
    /// Write no page
    #[arg(long)]
    no_report: bool,
    /// Write what became of every expectation as JUnit XML, too
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    #[command(flatten)]
    watch: WatchArgs,
    /// How many seconds to simulate a second at most: a number, or max [default: max; 1 where somebody looks on]
    #[arg(long, value_name = "FACTOR", value_parser = RealTimeFactor::parse)]
    real_time_factor: Option<RealTimeFactor>,
    /// List the shipped scenarios and end
    #[arg(long)]
    list: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    if args.list {
        crate::scenario::SHIPPED.iter().for_each(|(name, _)| say(name));
        return Ok(ExitCode::from(HELD));
    }
    let scenarios = load(&args.scenarios, &args.overrides)?;
    let live = args.watch.open()?;
    interrupt::listen();
    let mut runs: Vec<Timed> = Vec::new();
    for scenario in &scenarios {
        let folder = if scenarios.len() == 1 { args.out.clone() } else { args.out.join(&scenario.name) };
        runs.push(run_one(scenario, &folder, args, &live)?);
        if interrupt::check().is_break() {
            break;
        }
    }
    if let Some(path) = &args.junit {
        write_file(path, &junit(&runs))?;
    }
    if std::env::var_os("GITHUB_ACTIONS").is_some_and(|value| value == "true") {
        runs.iter().flat_map(|(summary, _)| annotations(summary)).for_each(say);
    }
    if scenarios.len() > 1 {
        print_all(&runs);
    }
    Ok(ExitCode::from(match runs {
        _ if interrupt::check().is_break() => INTERRUPTED,
        runs if runs.iter().all(|(summary, _)| summary.passed) => HELD,
        _ => FAILED,
    }))
}

/// Loads them all before any is run: bad input writes nothing.
fn load(names: &[String], overrides: &[String]) -> Result<Vec<Scenario>, Problems> {
    let mut scenarios = Vec::new();
    let mut problems = Vec::new();
    for name in names {
        match Scenario::load(name, overrides) {
            Ok(scenario) => scenarios.push(scenario),
            Err(found) => problems.extend(found.0),
        }
    }
    let mut folders = BTreeSet::new();
    for scenario in &scenarios {
        if !folders.insert(&scenario.name) {
            let problem = Problem::bare(format!("two scenarios are named `{}`", scenario.name));
            problems.push(problem.help("each gets a folder of its name: give one another `name`, or run them apart"));
        }
    }
    if problems.is_empty() { Ok(scenarios) } else { Err(Problems(problems)) }
}

fn run_one(scenario: &Scenario, folder: &Path, args: &Args, live: &Live) -> Result<Timed, Failure> {
    create_folder(folder)?;
    let recording = logged_to(Recording::new(scenario), folder, !args.no_log)?;
    let recording = if args.no_report { recording } else { recording.with_history() };
    let recording = recording.with_live(live, "hil-sim run", Instant::ZERO);
    let pace = Pace::new(RealTimeFactor::or_default(args.real_time_factor, live.is_watched()), scenario);
    let mut progress = Progress::new(scenario.name.clone(), scenario.ticks());
    let finished = recording.run(|tick| {
        if tick.is_multiple_of(256) {
            progress.at(tick);
        }
        pace.keep(tick);
        interrupt::check()
    });
    progress.done();
    let elapsed_s = progress.elapsed_s();
    Ok((conclude(scenario, finished, folder, elapsed_s)?, elapsed_s))
}

/// A recording with a log, where it is wanted.
pub(super) fn logged_to<'s>(recording: Recording<'s>, folder: &Path, logged: bool) -> Result<Recording<'s>, Failure> {
    if !logged {
        return Ok(recording);
    }
    recording.with_log(&folder.join(LOG_NAME)).map_err(|error| Failure::Broken(error.to_string()))
}
