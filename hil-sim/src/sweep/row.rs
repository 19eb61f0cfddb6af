//! A run's row in the results.

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::{Case, Kind, Plan};
use crate::recording::Recording;
use crate::scenario::Scenario;
use crate::summary::Summary;

/// Columns after those of the plan's keys, units last.
pub const COLUMNS: [(&str, Kind); 20] = [
    ("seed", Kind::Whole),
    ("outcome", Kind::Words),
    ("passed", Kind::Truth),
    ("state", Kind::Words),
    ("rings", Kind::Truth),
    ("simulated_s", Kind::Number),
    ("tracking.rms_m", Kind::Number),
    ("tracking.max_m", Kind::Number),
    ("tracking.final_m", Kind::Number),
    ("tracking.final_heading_rad", Kind::Number),
    ("tracking.max_after_30s_m", Kind::Number),
    ("tracking.travelled_m", Kind::Number),
    ("torque.max_nm", Kind::Number),
    ("torque.chatter_nm", Kind::Number),
    ("bus.frames", Kind::Whole),
    ("bus.lost", Kind::Whole),
    ("bus.error_frames", Kind::Whole),
    ("bus.load_percent", Kind::Number),
    ("frames_blake3", Kind::Words),
    ("error", Kind::Words),
];
/// So many of them, from the first, are filled in every row.
pub const ALWAYS_FILLED: usize = 2;

/// Runs a case; its cells are those of the plan's keys and then of [`COLUMNS`].
/// A scenario that will not do, or a panic, is a row as well.
pub fn run(plan: &Plan, case: &Case) -> Vec<String> {
    let ran = catch_unwind(AssertUnwindSafe(|| {
        let scenario = Scenario::load(&plan.scenario, &case.overrides).map_err(|problems| first_line(&problems))?;
        Ok(Recording::new(&scenario).run(|_| ControlFlow::Continue(())).summary)
    }));
    let ran: Result<Summary, String> = ran.unwrap_or_else(|_| Err("it panicked".to_owned()));
    let own = case.values.iter().map(|value| plain(value));
    own.chain(cells(case, ran)).collect()
}

fn cells(case: &Case, ran: Result<Summary, String>) -> Vec<String> {
    let mut cells = vec![case.seed.to_string()];
    match ran {
        Ok(summary) => {
            let (tracking, torque, bus) = (&summary.tracking, &summary.torque, &summary.bus);
            cells.extend([summary.end.to_owned(), summary.passed.to_string()]);
            cells.extend([summary.state.unwrap_or_default().to_owned(), summary.rings.to_string()]);
            let numbers = [
                summary.simulated_s,
                tracking.rms_m,
                tracking.max_m,
                tracking.final_m,
                tracking.final_heading_rad,
                tracking.max_after_30s_m.unwrap_or(f64::NAN),
                tracking.travelled_m,
                torque.max_nm,
                torque.chatter_nm,
            ];
            cells.extend(numbers.map(number));
            cells.extend([bus.frames, bus.lost, bus.error_frames].map(|count| count.to_string()));
            cells.extend([number(bus.load_percent), summary.frames_blake3, String::new()]);
        }
        Err(error) => {
            cells.push("refused".to_owned());
            cells.resize(COLUMNS.len() - 1, String::new());
            cells.push(error);
        }
    }
    cells
}

/// Empty where there is no number.
fn number(value: f64) -> String {
    if value.is_nan() { String::new() } else { format!("{value:?}") }
}

/// A value without TOML's quotes.
fn plain(value: &str) -> String {
    value.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')).unwrap_or(value).to_owned()
}

fn first_line(problems: &canloop::config::Problems) -> String {
    problems.0.first().map_or_else(String::new, |problem| {
        let label = if problem.label.is_empty() { String::new() } else { format!(": {}", problem.label) };
        format!("{}{label}", problem.title)
    })
}
