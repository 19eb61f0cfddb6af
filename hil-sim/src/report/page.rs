//! The page of a run.

use canloop::report::{
    Cell, Chart, Column, Curve, Figure, Page, Role, Section, Series, Stroke, Table, levels, stack_states, steps,
};
use canloop::robot::Pose;
use canloop::schema::DriveState;

use super::expectations;
use super::history::{History, Moment};
use crate::scenario::{Link, Scenario};
use crate::summary::Summary;

/// One page with the verdict, the figures and the pictures of a run.
pub fn page(scenario: &Scenario, summary: &Summary, history: &History) -> Page {
    let verdict = if summary.passed { "passed" } else { "failed" };
    let held = summary.expectations.iter().filter(|verdict| verdict.passed).count();
    let lead = format!(
        "{} of {} expectations held over {:.3} s of simulated time. The run {}.",
        held,
        summary.expectations.len(),
        summary.simulated_s,
        end(summary.end)
    );
    let again = Section::new("Run it again").paragraph("The same scenario gives the same frames on any machine.");
    let mut page = Page::new(format!("{}: {verdict}", summary.scenario)).lead(lead);
    page = page.section(expectations::section(scenario, summary, history));
    if !summary.findings.is_empty() {
        let findings = Section::new("What went wrong, and why");
        page = page.section(summary.findings.iter().fold(findings, |section, finding| section.paragraph(finding)));
    }
    page.section(Section::new("The run").figure(Figure::new("Whole run", CAPTION, charts(scenario, history))))
        .section(Section::new("What happened").table(moments(history)))
        .section(Section::new("Figures").table(figures(summary)))
        .section(again.table(Table::new([Column::text("command")]).row([summary.reproduce_line().into()])))
        .footer(format!("Made by hil-sim {} run. Frames: {}", summary.version, summary.frames_blake3))
}

const CAPTION: &str = "Reference dotted. Of each stretch of time the least and the greatest value are drawn, so that \
                       no spike is lost; dashed red lines are limits, dashed grey ones what happened.";

/// What a drive does.
const DRIVE_STATES: [&str; 4] = ["boot", "ready", "enabled", "fault"];

fn end(word: &str) -> &'static str {
    match word {
        "finished" => "went on to its end",
        "diverged" => "was ended when the robot was lost",
        "blocked" => "was ended when the bus was blocked",
        "silent" => "was ended when the controller fell silent",
        _ => "was interrupted",
    }
}

fn charts(scenario: &Scenario, history: &History) -> Vec<Chart> {
    let mut charts = vec![track(history), position_error(history), torque(scenario, history)];
    if scenario.link != Link::Ideal {
        charts.extend([bus_load(history), stack_state(history), drive_states(history)]);
    }
    charts
}

fn track(history: &History) -> Chart {
    let place = |pose: &Pose| (pose.x_m, pose.y_m);
    let (track, reference) = history.track.iter().map(|(pose, reference)| (place(pose), place(reference))).unzip();
    Chart::new("Track in the plane")
        .x_axis("x", "m")
        .y_axis("y", "m")
        .equal_aspect()
        .series(Series::reference(reference))
        .series(Series::response(track))
}

/// A chart over the whole run, with what happened marked in it.
fn over_time(title: &str, history: &History) -> Chart {
    let chart = Chart::new(title).x_axis("time", "s").x_range(0.0, history.last_s);
    marked(chart, history, (0.0, history.last_s))
}

/// Marks what happened in a span of time. That a run begins goes without saying.
pub(super) fn marked(chart: Chart, history: &History, (from_s, until_s): (f64, f64)) -> Chart {
    let is_worth_marking = |moment: &&Moment| {
        !["boot", "stopped", "enabling", "running", "culprit"].contains(&moment.kind)
            && (from_s..=until_s).contains(&moment.at_s)
    };
    let label = |moment: &Moment| if moment.kind == "event" { moment.text.to_string() } else { moment.kind.to_owned() };
    let moments = history.moments.iter().filter(is_worth_marking);
    moments.fold(chart, |chart, moment| chart.marker(label(moment), moment.at_s))
}

fn position_error(history: &History) -> Chart {
    let points = history.position_error_m.clone().points();
    over_time("Position error", history).y_axis("distance from the path", "m").series(Series::response(points))
}

fn torque(scenario: &Scenario, history: &History) -> Chart {
    let limit_nm = scenario.stack.safety.torque_limit_nm;
    let line = |name, role, curve: &Curve| Series::new(name, role, Stroke::Solid, curve.clone().points());
    over_time("Torque sent", history)
        .y_axis("torque", "N m")
        .limit("limit", limit_nm)
        .limit("limit", -limit_nm)
        .series(line("right wheel", Role::Right, &history.torque_nm.right))
        .series(line("left wheel", Role::Left, &history.torque_nm.left))
}

fn bus_load(history: &History) -> Chart {
    let load = history.load_percent();
    let most = load.iter().fold(1.0, |most: f64, (_, percent)| most.max(*percent));
    over_time("Bus load", history).y_axis("load", "%").y_range(0.0, 1.1 * most).series(Series::new(
        "load",
        Role::Response,
        Stroke::Solid,
        load,
    ))
}

fn stack_state(history: &History) -> Chart {
    let states = history.states.iter().map(|&(at_s, state)| (at_s, f64::from(state)));
    stack_states(over_time("State of the stack", history), steps(states, history.last_s))
}

fn drive_states(history: &History) -> Chart {
    let level = |state: DriveState| match state {
        DriveState::Boot => 0.0,
        DriveState::Ready => 1.0,
        DriveState::Enabled => 2.0,
        DriveState::Fault => 3.0,
    };
    let line = |states: &Vec<(f64, DriveState)>| {
        steps(states.iter().map(|&(at_s, state)| (at_s, level(state))), history.last_s)
    };
    over_time("States of the drives", history)
        .y_range(-0.5, 3.5)
        .y_words(levels(&DRIVE_STATES))
        .series(Series::new("right drive", Role::Right, Stroke::Solid, line(&history.drive_states.right)))
        .series(Series::new("left drive", Role::Left, Stroke::Dashed, line(&history.drive_states.left)))
}

fn moments(history: &History) -> Table {
    let table = Table::new([Column::number("time", "s", 3), Column::text("kind"), Column::prose("what")]);
    let row = |table: Table, moment: &Moment| {
        table.row([moment.at_s.into(), moment.kind.into(), moment.text.as_ref().into()])
    };
    history.moments.iter().fold(table, row)
}

fn figures(summary: &Summary) -> Table {
    let (tracking, torque, bus) = (&summary.tracking, &summary.torque, &summary.bus);
    let number = |value: f64, decimals: usize| format!("{value:.decimals$}");
    let rows = [
        ("position error, root mean square, m", number(tracking.rms_m, 6)),
        ("position error, largest, m", number(tracking.max_m, 6)),
        ("position error, at the end, m", number(tracking.final_m, 6)),
        ("torque, largest, N m", number(torque.max_nm, 2)),
        ("torque, mean step, N m", number(torque.chatter_nm, 3)),
        ("frames", bus.frames.to_string()),
        ("frames lost", bus.lost.to_string()),
        ("bus load, %", number(bus.load_percent, 1)),
        ("law", summary.law.to_owned()),
        ("period, s", summary.period_s.to_string()),
        ("seed", summary.seed.to_string()),
    ];
    let table = Table::new([Column::text("figure"), Column::text("value")]);
    rows.into_iter().fold(table, |table, (name, value)| table.row([name.into(), Cell::Text(value)]))
}
