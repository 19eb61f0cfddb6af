//! The page of the paper's reproduction.

use canloop::report::{Badge, Cell, Column, Page, Section, Table};

use super::pictures::Picture;
use super::{Finished, Outcome};

/// One page with the table, the figures and what they teach.
pub fn page(runs: &[Finished], pictures: &[Picture]) -> Page {
    let results = Section::new("Position error of every run")
        .paragraph(
            "Each run follows the circle of eq 19 for 150 s with the 80 kg load. Ideal: law and plant joined directly, \
             exact sensors, no frames, the robot started on the path. CAN: the control stack sends and receives CAN \
             frames through a simulated 500 kbit/s bus to simulated drives with 65536 encoder counts a motor turn, a \
             torque limit of 90 N m at the wheel, a current loop of 1 ms and one period of delay.",
        )
        .table(table(runs));
    let mut page = Page::new("Digital acceleration control, reproduced")
        .lead(
            "The simulations of the paper on wheeled robots with heavy, shifting loads on floors of unknown friction, \
             and then the same controller doing it through CAN frames against simulated motor drives.",
        )
        .section(results)
        .section(findings(runs));
    let mut figures = Section::new("Figures").paragraph("Reference dotted, response solid.");
    for picture in pictures {
        figures = figures.figure(picture.figure.clone());
    }
    page = page.section(figures).section(reproduce(runs));
    page.footer(format!("Made by hil-sim {} paper.", env!("CARGO_PKG_VERSION")))
}

fn table(runs: &[Finished]) -> Table {
    let table = Table::new([
        Column::text("controller"),
        Column::text("friction"),
        Column::text("link, T"),
        Column::text("outcome"),
        Column::number("rms", "m", 5),
        Column::number("max", "m", 5),
        Column::number("final", "m", 5),
        Column::number("torque, max", "N m", 2),
    ]);
    runs.iter().fold(table, |table, run| {
        let tracking = &run.summary.tracking;
        let controller = if run.case.from_aside {
            format!("{} + pose loop", run.case.controller)
        } else {
            run.case.controller.to_owned()
        };
        table.row([
            controller.into(),
            run.case.friction.name().into(),
            format!("{}, {} ms", run.case.setup.name(), run.case.setup.period_ms()).into(),
            badge(run.outcome()),
            tracking.rms_m.into(),
            tracking.max_m.into(),
            tracking.final_m.into(),
            run.summary.torque.max_nm.into(),
        ])
    })
}

fn badge(outcome: Outcome) -> Cell {
    match outcome {
        Outcome::Tracks => Badge::Pass.into(),
        Outcome::Diverges => Badge::Diverges.into(),
        Outcome::Drifts | Outcome::Rings | Outcome::Trips => outcome.name().into(),
    }
}

/// What went wrong, and why, said once for runs that failed in the same way.
fn findings(runs: &[Finished]) -> Section {
    let mut section = Section::new("What fails, and why");
    let mut said: Vec<&str> = Vec::new();
    for run in runs {
        let case = &run.case;
        let (Some((why, what)), false) = (run.summary.findings.split_last(), said.contains(&case.controller)) else {
            continue;
        };
        said.push(case.controller);
        let place = format!("{}, friction {}, {}", case.controller, case.friction.name(), case.setup.name());
        section = section.paragraph(format!("{place}: {} {why}", what.join(" ")));
    }
    section.paragraph(
        "pi-speed with friction: its integral must wind up to the 60 N m that break a wheel loose, each wheel at \
         another moment, so the robot turns away before it moves; the path is lost at the start and, without a loop \
         on the pose, never found again.",
    )
}

fn reproduce(runs: &[Finished]) -> Section {
    let section = Section::new("Run one alone")
        .paragraph("Each row of the table, in its order, as a command; add --out DIR for a log of its own.");
    let table = Table::new([Column::text("command")]);
    section.table(runs.iter().fold(table, |table, run| table.row([run.case.reproduce_line().into()])))
}
