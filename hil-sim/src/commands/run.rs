//! `hil-sim run`: scenarios, their figures and their logs.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use canloop::config::{Problem, Problems};

use super::progress::Progress;
use super::{FAILED, Failure, HELD, INTERRUPTED, create_folder, interrupt, say, write_file};
use crate::recording::{Finished, Recording};
use crate::scenario::Scenario;
use crate::summary::Summary;

/// What `hil-sim run` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  hil-sim run dac-friction                        a shipped scenario
  hil-sim run my.toml --set controller.filter=1   a file, with one key changed
  hil-sim run dac-friction --set 'controller.law=\"dac\"' --out runs/dac
  hil-sim run dac-friction line figure-eight      a folder each under runs/

Exit status: 0 all expectations hold, 1 one does not, 2 bad input (nothing is
written), 130 ended by Ctrl-C (the log up to there can be read).")]
pub struct Args {
    /// Names of shipped scenarios, or paths of scenario files ending in .toml
    #[arg(required_unless_present = "list", value_name = "SCENARIO")]
    scenarios: Vec<String>,
    /// Lay KEY=VALUE over the scenario: KEY a dotted path, VALUE as TOML
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Where run.mcap and summary.json go; with several scenarios, a folder each in it
    #[arg(long, value_name = "DIR", default_value = "runs")]
    out: PathBuf,
    /// Write no log, only summary.json
    #[arg(long)]
    no_log: bool,
    /// List the shipped scenarios and end
    #[arg(long)]
    list: bool,
}

/// The log's name in a run's folder.
const LOG_NAME: &str = "run.mcap";

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    if args.list {
        crate::scenario::SHIPPED.iter().for_each(|(name, _)| say(name));
        return Ok(ExitCode::from(HELD));
    }
    let scenarios = load(&args.scenarios, &args.overrides)?;
    interrupt::listen();
    let mut status = HELD;
    for scenario in &scenarios {
        let folder = if scenarios.len() == 1 { args.out.clone() } else { args.out.join(&scenario.name) };
        let summary = run_one(scenario, &folder, !args.no_log)?;
        if interrupt::check().is_break() {
            return Ok(ExitCode::from(INTERRUPTED));
        }
        if !summary.passed {
            status = FAILED;
        }
    }
    Ok(ExitCode::from(status))
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

fn run_one(scenario: &Scenario, folder: &Path, logged: bool) -> Result<Summary, Failure> {
    create_folder(folder)?;
    let recording = logged_to(Recording::new(scenario), folder, logged)?;
    let mut progress = Progress::new(scenario.name.clone(), scenario.ticks());
    let finished = recording.run(|tick| {
        if tick.is_multiple_of(256) {
            progress.at(tick);
        }
        interrupt::check()
    });
    progress.done();
    conclude(finished, folder, progress.elapsed_s())
}

/// A recording with a log, where it is wanted.
pub(super) fn logged_to<'s>(recording: Recording<'s>, folder: &Path, logged: bool) -> Result<Recording<'s>, Failure> {
    if !logged {
        return Ok(recording);
    }
    recording.with_log(&folder.join(LOG_NAME)).map_err(|error| Failure::Broken(error.to_string()))
}

/// Writes the summary of a run and prints it.
pub(super) fn conclude(finished: Finished, folder: &Path, elapsed_s: f64) -> Result<Summary, Failure> {
    let Finished { summary, log_error, .. } = finished;
    let summary_path = folder.join("summary.json");
    let mut json = serde_json::to_string_pretty(&summary).expect("a summary is plain data");
    json.push('\n');
    write_file(&summary_path, &json)?;
    print(&summary, elapsed_s);
    let log = summary.log.map(|_| format!("{}, ", folder.join(LOG_NAME).display())).unwrap_or_default();
    say(format_args!("  written          {log}{}", summary_path.display()));
    match log_error {
        Some(error) => Err(Failure::Broken(error.to_string())),
        None => Ok(summary),
    }
}

fn print(summary: &Summary, elapsed_s: f64) {
    let verdict = match (summary.end, summary.passed) {
        ("interrupted", _) => "interrupted",
        (_, true) => "passed",
        (_, false) => "FAILED",
    };
    let speed = summary.simulated_s / elapsed_s.max(1e-9);
    say(format_args!("{}: {verdict}", summary.scenario));
    say(format_args!(
        "  simulated        {:.3} s in {elapsed_s:.2} s, {speed:.0} times real time",
        summary.simulated_s
    ));
    let tracking = &summary.tracking;
    say(format_args!(
        "  position error   rms {}, max {}, final {}{}",
        length(tracking.rms_m),
        length(tracking.max_m),
        length(tracking.final_m),
        tracking.max_after_30s_m.map_or(String::new(), |max| format!(", max after 30 s {}", length(max))),
    ));
    say(format_args!(
        "  torque           max {:.2} N m, chatter {:.3} N m",
        summary.torque.max_nm, summary.torque.chatter_nm
    ));
    if summary.link == "can" {
        let bus = &summary.bus;
        say(format_args!(
            "  bus              {} frames, {} lost, load {:.1} %",
            bus.frames, bus.lost, bus.load_percent
        ));
    }
    for finding in &summary.findings {
        say(format_args!("  finding          {finding}"));
    }
    for verdict in &summary.expectations {
        say(format_args!("  expectation      {verdict}"));
    }
    if summary.end == "interrupted" && summary.log.is_some() {
        say(format_args!("  interrupted      the log up to {:.3} s is complete and can be read", summary.simulated_s));
    }
}

/// A length with the prefix that people read easiest.
pub(super) fn length(metres: f64) -> String {
    match metres.abs() {
        size if size < 1e-12 => "0 m".to_owned(),
        size if size < 1e-6 => format!("{:.3} nm", metres * 1e9),
        size if size < 1e-3 => format!("{:.3} um", metres * 1e6),
        size if size < 1.0 => format!("{:.3} mm", metres * 1e3),
        _ => format!("{metres:.3} m"),
    }
}
