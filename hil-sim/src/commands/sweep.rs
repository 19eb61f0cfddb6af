//! `hil-sim sweep`: thousands of runs that answer one question.

use std::io::ErrorKind;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use canloop::config::Problem;

use super::progress::Progress;
use super::{Failure, HELD, INTERRUPTED, create_folder, interrupt, say};
use crate::parallel;
use crate::sweep::{self, FILE, PARQUET, Plan, Results, ResultsError, Shard};

/// What `hil-sim sweep` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  hil-sim sweep load.toml                    all of it, on all processors, to sweeps/load/
  hil-sim sweep load.toml --shard 3/8        the third of eight parts
  hil-sim merge parts/* -o load.csv          parts made one

A plan names a scenario and what is varied:

  name = \"load\"
  scenario = \"dac-friction\"
  set = [\"duration_s=20\", \"expect=[]\"]
  seeds = 2
  [[vary]]
  key = \"robot.load.mass_kg\"
  from = 0
  to = 160
  count = 9
  [[vary]]
  key = \"period_s\"
  values = [0.002, 0.005, 0.01]
  [[map]]                                    drawn in map.svg and report.html
  x = \"robot.load.mass_kg\"
  y = \"period_s\"

results.csv has a row a run, in their order: what was varied, the figures of its
summary, and what went wrong, if anything did. results.parquet has the same rows
once all are done or the sweep was ended, with columns of numbers, words, true and
false, and null where a cell is empty. A sweep that was ended goes on where it was.
Slurm's job arrays, Kubernetes' indexed jobs and the matrices of GitLab and
CircleCI are understood by their variables without --shard.
Exit status: 0 all runs are done, 2 bad input or no room, 130 ended by Ctrl-C.")]
pub struct Args {
    /// Path of a plan
    #[arg(value_name = "PLAN.toml")]
    plan: String,
    /// The I-th of N disjoint parts
    #[arg(long, value_name = "I/N", value_parser = Shard::parse)]
    shard: Option<Shard>,
    /// Folder for the results; without it, sweeps/NAME, and of a part sweeps/NAME-I-of-N
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Threads; without it, as many as there are processors
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let plan = Plan::load(&args.plan)?;
    let shard = match args.shard {
        Some(shard) => shard,
        None => Shard::of_engine(|name| std::env::var(name).ok())
            .map_err(|what| {
                Problem::bare(format!("the environment names no part: {what}")).help("say it with --shard I/N")
            })?
            .unwrap_or(Shard::WHOLE),
    };
    let folder = args.out.clone().unwrap_or_else(|| default_folder(&plan, shard));
    create_folder(&folder)?;
    let mut results = Results::open(&folder, &plan, shard).map_err(refused)?;
    let (cases, done) = (shard.count(plan.runs()), results.done);
    let threads = args.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    if done > 0 {
        say(format_args!("{done} of {cases} runs were done before"));
    }
    interrupt::listen();
    remove_outdated(&folder)?;
    let mut progress = Progress::new(plan.name.clone(), cases);
    let mut failed = None;
    let work = |nth| {
        let case = plan.case(shard.case(done + nth));
        (case.number, sweep::run(&plan, &case))
    };
    parallel::in_order(cases.saturating_sub(done), threads, work, |nth, (number, cells)| {
        progress.at(done + nth + 1);
        match results.put(number, &cells) {
            Ok(()) => interrupt::check(),
            Err(error) => {
                failed = Some(error);
                ControlFlow::Break(())
            }
        }
    });
    progress.done();
    if let Some(error) = failed {
        return Err(refused(error));
    }
    let is_ended = interrupt::check().is_break();
    let what = if is_ended { "ended; the same command goes on with it" } else { "done" };
    say(format_args!("{} runs in {:.1} s, {what}", cases - done, progress.elapsed_s()));
    say(format_args!("written          {}", folder.join(FILE).display()));
    write_parquet(&folder, &plan)?;
    if shard == Shard::WHOLE && !plan.maps.is_empty() && !is_ended {
        super::map::write_maps(&plan, &folder.join(FILE))?;
    }
    Ok(ExitCode::from(if is_ended { INTERRUPTED } else { HELD }))
}

/// A table of fewer rows than there are would be taken for all of them if this
/// program was killed.
fn remove_outdated(folder: &Path) -> Result<(), Failure> {
    let path = folder.join(PARQUET);
    match std::fs::remove_file(&path) {
        Err(error) if error.kind() != ErrorKind::NotFound => {
            Err(Failure::Broken(format!("cannot remove {}, which is outdated: {error}", path.display())))
        }
        _ => Ok(()),
    }
}

fn write_parquet(folder: &Path, plan: &Plan) -> Result<(), Failure> {
    let (csv, output) = (folder.join(FILE), folder.join(PARQUET));
    sweep::to_parquet(&csv, &output, plan).map_err(|error| {
        Failure::Broken(format!("{error}; {} has all rows, the same command tries again", csv.display()))
    })?;
    say(format_args!("written          {}", output.display()));
    Ok(())
}

fn default_folder(plan: &Plan, shard: Shard) -> PathBuf {
    let part = if shard == Shard::WHOLE { String::new() } else { format!("-{}-of-{}", shard.index, shard.of) };
    PathBuf::from("sweeps").join(format!("{}{part}", plan.name))
}

fn refused(error: ResultsError) -> Failure {
    match error {
        ResultsError::Io(..) => Failure::Broken(format!("{error}; what is written there is kept")),
        ResultsError::Other(..) => Problem::bare(error.to_string()).help("choose another folder with --out").into(),
    }
}
