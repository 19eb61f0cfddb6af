//! What a run says at its end, and what it writes.

use std::path::Path;

use super::{Failure, say, write_file};
use crate::recording::Finished;
use crate::report::junit::Timed;
use crate::report::page;
use crate::scenario::Scenario;
use crate::summary::Summary;

/// The log's name in a run's folder.
pub(super) const LOG_NAME: &str = "run.mcap";

/// Writes the summary of a run and prints it.
pub(super) fn conclude(
    scenario: &Scenario,
    finished: Finished,
    folder: &Path,
    elapsed_s: f64,
) -> Result<Summary, Failure> {
    let Finished { summary, history, log_error, .. } = finished;
    let summary_path = folder.join("summary.json");
    let mut json = serde_json::to_string_pretty(&summary).expect("a summary is plain data");
    json.push('\n');
    write_file(&summary_path, &json)?;
    print(&summary, elapsed_s);
    let mut written: Vec<_> = summary.log.iter().map(|_| folder.join(LOG_NAME)).collect();
    written.push(summary_path);
    if let Some(history) = history {
        let path = folder.join("report.html");
        write_file(&path, &page(scenario, &summary, &history).to_html())?;
        written.push(path);
    }
    let written = written.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ");
    say(format_args!("  written          {written}"));
    match log_error {
        Some(error) => Err(Failure::Broken(error.to_string())),
        None => Ok(summary),
    }
}

fn print(summary: &Summary, elapsed_s: f64) {
    let verdict = loud(summary.verdict());
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
        verdict.lines_around().for_each(|line| say(format_args!("                   {line}")));
    }
    if let Some(command) = summary.reproduce.as_ref().filter(|_| !summary.passed) {
        say(format_args!("  reproduce        {command}"));
    }
    if summary.end == "interrupted" && summary.log.is_some() {
        say(format_args!("  interrupted      the log up to {:.3} s is complete and can be read", summary.simulated_s));
    }
}

/// A table of several runs, a row each.
pub(super) fn print_all(runs: &[Timed]) {
    let widest = runs.iter().map(|(summary, _)| summary.scenario.len()).max().unwrap_or(0).max(8);
    say(format_args!("\n{:widest$}  verdict      expectations     simulated", "scenario"));
    for (summary, _) in runs {
        let held = summary.expectations.iter().filter(|verdict| verdict.passed).count();
        let held = format!("{held} of {} held", summary.expectations.len());
        let (name, verdict) = (&summary.scenario, loud(summary.verdict()));
        say(format_args!("{name:widest$}  {verdict:11}  {held:14}  {:>10.3} s", summary.simulated_s));
    }
}

/// What asks for somebody to look is not overlooked in a terminal.
fn loud(verdict: &str) -> &str {
    if verdict == "failed" { "FAILED" } else { verdict }
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
