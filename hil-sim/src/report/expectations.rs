//! The part of a page that says what was expected and what came of it.

use canloop::report::{Badge, Chart, Column, Figure, Role, Section, Series, Stroke, Table, stack_states};

use super::history::History;
use super::page::marked;
use crate::expect::{Subject, Verdict};
use crate::scenario::Scenario;
use crate::summary::Summary;

/// All verdicts, and each signal around the moment that matters.
pub(super) fn section(scenario: &Scenario, summary: &Summary, history: &History) -> Section {
    let section = Section::new("Expectations");
    if summary.expectations.is_empty() {
        return section.paragraph("Nothing was expected of this run.");
    }
    let table = Table::new([
        Column::number("", "", 0),
        Column::text("verdict"),
        Column::prose("what must hold"),
        Column::prose("what came of it"),
    ]);
    let section = section.table(numbered(summary).fold(table, |table, (number, verdict)| {
        let badge = if verdict.passed { Badge::Pass } else { Badge::Fail };
        let claim = match &verdict.name {
            Some(name) => format!("{name}: {}", verdict.claim),
            None => verdict.claim.clone(),
        };
        table.row([(number as f64).into(), badge.into(), claim.into(), verdict.result.as_str().into()])
    }));
    let subjects = scenario.expectations.iter().map(|expectation| &expectation.subject);
    let charts: Vec<_> =
        numbered(summary).zip(subjects).filter_map(|(one, subject)| chart(one, subject, history)).collect();
    if charts.is_empty() {
        return section;
    }
    let caption = "Each signal around the moment at which it was nearest to its bounds or furthest beyond them.";
    section.figure(Figure::new("Worst moments", caption, charts))
}

fn numbered(summary: &Summary) -> impl Iterator<Item = (usize, &Verdict)> {
    (1..).zip(&summary.expectations)
}

/// The signal with its bounds, if it has samples.
fn chart((number, verdict): (usize, &Verdict), subject: &Subject, history: &History) -> Option<Chart> {
    let (first, last) = (verdict.curve.first()?, verdict.curve.last()?);
    let title = format!("{number}. {}", verdict.name.as_deref().unwrap_or(&verdict.signal));
    let chart = Chart::new(title).x_axis("time", "s");
    let chart = match subject {
        Subject::State(..) => stack_states(chart, verdict.curve.clone()),
        Subject::Rate(_) => bounded(
            chart.y_axis(format!("change of {}", verdict.signal), "a second"),
            verdict,
            (verdict.min, verdict.max),
        ),
        Subject::Samples { above, below, .. } => {
            bounded(chart.y_axis(verdict.signal.as_str(), ""), verdict, (*below, *above))
        }
        _ => bounded(chart.y_axis(verdict.signal.as_str(), ""), verdict, (verdict.min, verdict.max)),
    };
    let chart = match verdict.worst_at_s {
        Some(at_s) if (first.0..=last.0).contains(&at_s) => chart.marker(verdict.word(), at_s),
        _ => chart,
    };
    Some(marked(chart, history, (first.0, last.0)))
}

fn bounded(chart: Chart, verdict: &Verdict, (least, most): (Option<f64>, Option<f64>)) -> Chart {
    let chart = chart.series(Series::new("value", Role::Response, Stroke::Solid, verdict.curve.clone()));
    [least, most].into_iter().flatten().fold(chart, |chart, bound| chart.limit("bound", bound))
}
