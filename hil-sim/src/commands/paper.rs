//! `hil-sim paper`: the paper's simulations, in one go.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::conclusion::length;
use super::progress::Progress;
use super::{Failure, HELD, INTERRUPTED, create_folder, interrupt, say, write_file};
use crate::paper::{Case, Finished, cases, figures, page};
use crate::recording::Recording;

/// What `hil-sim paper` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Writes report.html, which opens offline, its figures as SVG files, and all
figures of all runs as paper.json.

Example:
  hil-sim paper --out /tmp/paper")]
pub struct Args {
    /// Where the report goes
    #[arg(long, value_name = "DIR", default_value = "runs/paper")]
    out: PathBuf,
}

/// Samples a picture is drawn from; a chart is some 300 points wide.
const SAMPLES: u64 = 3000;

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    interrupt::listen();
    let cases = cases();
    create_folder(&args.out)?;
    let mut progress = Progress::new("paper", cases.len() as u64);
    let runs = run_all(&cases, &mut progress)?;
    progress.done();
    if interrupt::check().is_break() {
        eprintln!("interrupted: no report was written");
        return Ok(ExitCode::from(INTERRUPTED));
    }
    print(&runs);
    let simulated_s: f64 = runs.iter().map(|run| run.summary.simulated_s).sum();
    say(format_args!("\n{} runs, {simulated_s:.0} s simulated in {:.1} s", runs.len(), progress.elapsed_s()));
    write(&runs, &args.out)?;
    say(format_args!("report: {}", args.out.join("report.html").display()));
    Ok(ExitCode::from(HELD))
}

/// Runs every case, as many at a time as there are cores; the results come in
/// the order of the cases whoever finishes first.
fn run_all(cases: &[Case], progress: &mut Progress) -> Result<Vec<Finished>, Failure> {
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let results: Vec<Mutex<Option<Result<Finished, Failure>>>> = cases.iter().map(|_| Mutex::new(None)).collect();
    let work = || {
        while let Some(index) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&index| index < cases.len()) {
            let result = run_one(&cases[index]);
            *results[index].lock().expect("no worker panics while it holds this") = Some(result);
            done.fetch_add(1, Ordering::Relaxed);
        }
    };
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let others: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        while !others.iter().all(std::thread::ScopedJoinHandle::is_finished) {
            progress.at(done.load(Ordering::Relaxed) as u64);
            progress.wait();
        }
    });
    let finished = |slot: Mutex<Option<Result<Finished, Failure>>>| {
        slot.into_inner().expect("no worker panics while it holds this").expect("every case was run")
    };
    results.into_iter().map(finished).collect()
}

fn run_one(case: &Case) -> Result<Finished, Failure> {
    let scenario = case.scenario()?;
    let stop = |_| if interrupt::check().is_break() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let run = Recording::new(&scenario).with_trace(SAMPLES).run(stop);
    Ok(Finished { case: case.clone(), summary: run.summary, trace: run.trace.unwrap_or_default() })
}

fn print(runs: &[Finished]) {
    say(format_args!(
        "{:<12} {:<9} {:<6} {:>5}  {:>11} {:>11} {:>11}  {:>10}  outcome",
        "controller", "friction", "link", "T", "rms", "max", "final", "torque"
    ));
    for run in runs {
        let (case, tracking) = (&run.case, &run.summary.tracking);
        say(format_args!(
            "{:<12} {:<9} {:<6} {:>2} ms  {:>11} {:>11} {:>11}  {:>6.2} N m  {}{}",
            case.controller,
            case.friction.name(),
            case.setup.name(),
            case.setup.period_ms(),
            length(tracking.rms_m),
            length(tracking.max_m),
            length(tracking.final_m),
            run.summary.torque.max_nm,
            run.outcome().name(),
            if case.from_aside { ", from (8, 4, 0) by the pose loop" } else { "" },
        ));
    }
}

fn write(runs: &[Finished], out: &Path) -> Result<(), Failure> {
    let pictures = figures(runs);
    for picture in &pictures {
        for (what, chart) in &picture.charts {
            write_file(&out.join(format!("{}-{what}.svg", picture.file_stem)), &chart.to_svg())?;
        }
    }
    write_file(&out.join("report.html"), &page(runs, &pictures).to_html())?;
    let summaries: Vec<_> = runs.iter().map(|run| &run.summary).collect();
    let json = serde_json::to_string_pretty(&summaries).expect("summaries are plain data");
    write_file(&out.join("paper.json"), &json)
}
