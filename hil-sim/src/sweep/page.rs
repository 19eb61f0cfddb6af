//! The page of a sweep.

use std::collections::BTreeMap;
use std::path::Path;

use canloop::report::{Cell, Column, HeatMap, Page, Section, Table};
use csv::StringRecord;

use super::Plan;
use super::rows::Rows;

/// The page of the results at `path` with these maps of them.
///
/// # Errors
/// The results cannot be read.
pub fn page(plan: &Plan, path: &Path, maps: Vec<HeatMap>) -> Result<Page, String> {
    let ends = ends(path)?;
    let runs: u64 = ends.values().sum();
    let varied: Vec<&str> = plan.axes.iter().map(|axis| axis.key.as_str()).collect();
    let lead = format!("{runs} runs of {}, in which {} were varied.", plan.scenario, varied.join(", "));
    let table = Table::new([Column::text("how a run ended"), Column::number("runs", "", 0)]);
    let table =
        ends.iter().fold(table, |table, (end, runs)| table.row([Cell::Text(end.clone()), Cell::Number(*runs as f64)]));
    let page = Page::new(format!("Sweep {}", plan.name)).lead(lead);
    let section = maps.into_iter().fold(Section::new("Maps"), Section::map);
    let page = page.section(section).section(Section::new("Runs").table(table));
    Ok(page.footer(format!("hil-sim {}", env!("CARGO_PKG_VERSION"))))
}

/// How many runs ended in which way.
fn ends(path: &Path) -> Result<BTreeMap<String, u64>, String> {
    let mut rows = Rows::open(path)?;
    let (outcome, state, rings) = (rows.column("outcome")?, rows.column("state")?, rows.column("rings")?);
    let mut ends = BTreeMap::new();
    let mut row = StringRecord::new();
    while rows.next(&mut row)? {
        let end = match (&row[outcome], &row[state], &row[rings]) {
            ("finished", "tripped", _) => "stopped by the safety chain",
            ("finished", _, "true") => "finished, the torque rings",
            (outcome, ..) => outcome,
        };
        *ends.entry(end.to_owned()).or_default() += 1;
    }
    Ok(ends)
}
