//! The equivalents of the paper's figures 5 (without friction) and 6 (with),
//! and what the paper does not show.

use canloop::report::{Chart, Figure, Role, Series, Stroke};
use canloop::robot::Pose;

use super::cases::{Friction, Setup};
use super::{Finished, Outcome};

/// A figure with the name that its files begin with.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Such as `figure-5a`.
    pub file_stem: String,
    /// For the page.
    pub figure: Figure,
    /// Its charts with the words that their files' names end in.
    pub charts: Vec<(&'static str, Chart)>,
}

/// A run that diverges is shown as long as it stays this near the circle.
const VIEW_M: (f64, f64) = (-5.0, 15.0);

/// All figures that the finished runs make.
pub fn figures(runs: &[Finished]) -> Vec<Picture> {
    let ideal = Setup::Ideal { period_ms: 1 };
    let mut figures = Vec::new();
    for (number, friction, words) in
        [("5", Friction::None, "without friction"), ("6", Friction::Paper, "with friction")]
    {
        let panels = [
            ("a", "dac", ideal, "DAC, ideal link, T = 1 ms"),
            ("b", "pi-speed", ideal, "PI on wheel speed, ideal link, T = 1 ms"),
            ("c", "dac-matched", Setup::Can, "DAC with the torque applied (dac-matched) over CAN, T = 5 ms"),
        ];
        for (letter, controller, setup, what) in panels {
            if let Some(run) = find(runs, controller, friction, setup, false) {
                figures.push(four_panels(&format!("{number}{letter}"), &format!("{what}, {words}."), run));
            }
        }
    }
    if let Some(run) = find(runs, "dac-matched", Friction::Paper, Setup::Can, true) {
        let what = "The same from the paper's start (8, 4), heading 0, brought to the path by the pose loop.";
        figures.push(four_panels("7", what, run));
    }
    if let Some(run) = find(runs, "pi-angle", Friction::None, ideal, false) {
        let what = "Eq 20 as printed, PI on wheel angle, ideal link, no friction: it diverges, and leaves the picture.";
        figures.push(four_panels("8", what, run));
    }
    figures.extend(torques(runs));
    figures
}

fn find<'r>(
    runs: &'r [Finished],
    controller: &str,
    friction: Friction,
    setup: Setup,
    from_aside: bool,
) -> Option<&'r Finished> {
    runs.iter().find(|run| {
        let case = &run.case;
        case.controller == controller
            && case.friction == friction
            && case.setup == setup
            && case.from_aside == from_aside
    })
}

fn four_panels(number: &str, caption: &str, run: &Finished) -> Picture {
    let diverges = run.outcome() == Outcome::Diverges;
    let x = over_time(run, "Position x", ("x", "m"), |pose| pose.x_m);
    let y = over_time(run, "Position y", ("y", "m"), |pose| pose.y_m);
    let heading = over_time(run, "Heading", ("heading", "rad"), |pose| pose.heading_rad);
    let track = track(run);
    let (low, high) = VIEW_M;
    let charts = if diverges {
        let start_rad = run.trace.samples.first().map_or(0.0, |sample| sample.reference.heading_rad);
        vec![
            ("x", x.y_range(low, high)),
            ("y", y.y_range(low, high)),
            ("heading", heading.y_range(start_rad - 10.0, start_rad + 10.0)),
            ("track", track.x_range(low, high).y_range(low, high)),
        ]
    } else {
        vec![("x", x), ("y", y), ("heading", heading), ("track", track)]
    };
    picture(number, caption, charts)
}

fn over_time(run: &Finished, title: &str, (name, unit): (&str, &str), of: fn(&Pose) -> f64) -> Chart {
    let samples = &run.trace.samples;
    Chart::new(title)
        .x_axis("time", "s")
        .y_axis(name, unit)
        .series(Series::reference(samples.iter().map(|sample| (sample.time_s, of(&sample.reference))).collect()))
        .series(Series::response(samples.iter().map(|sample| (sample.time_s, of(&sample.pose))).collect()))
}

fn track(run: &Finished) -> Chart {
    let points = |of: fn(&crate::trace::Sample) -> &Pose| {
        run.trace.samples.iter().map(|sample| (of(sample).x_m, of(sample).y_m)).collect()
    };
    Chart::new("Track in the plane")
        .x_axis("x", "m")
        .y_axis("y", "m")
        .equal_aspect()
        .series(Series::reference(points(|sample| &sample.reference)))
        .series(Series::response(points(|sample| &sample.pose)))
}

/// Why eq 12 as printed will not do over a bus: half a second of its torque,
/// beside that of the law fed with the torque applied.
fn torques(runs: &[Finished]) -> Option<Picture> {
    let chart = |controller: &str, title: &str| {
        let run = find(runs, controller, Friction::Paper, Setup::Can, false)?;
        let torques = &run.trace.torques;
        let right = torques.iter().map(|&(time_s, torque)| (time_s, torque.right)).collect();
        let left = torques.iter().map(|&(time_s, torque)| (time_s, torque.left)).collect();
        Some(
            Chart::new(title)
                .x_axis("time", "s")
                .y_axis("torque sent", "N m")
                .y_range(-100.0, 100.0)
                .series(Series::new("right wheel", Role::Right, Stroke::Solid, right))
                .series(Series::new("left wheel", Role::Left, Stroke::Dashed, left)),
        )
    };
    let charts = vec![
        ("dac", chart("dac", "Torque, dac as printed")?),
        ("dac-matched", chart("dac-matched", "Torque, dac-matched")?),
    ];
    let caption = "Torque over CAN, T = 5 ms, with friction. Eq 12 as printed adds to its own last command, which \
                   over a bus acts a period late: the loop rings between the limits of the drives. Fed with the \
                   torque that was applied it is still.";
    Some(picture("9", caption, charts))
}

fn picture(number: &str, caption: &str, charts: Vec<(&'static str, Chart)>) -> Picture {
    let drawn = charts.iter().map(|(_, chart)| chart.clone()).collect();
    Picture {
        file_stem: format!("figure-{number}"),
        figure: Figure::new(format!("Figure {number}"), caption, drawn),
        charts,
    }
}
