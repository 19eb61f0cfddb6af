//! How the signals of a stack with another configuration deviate from the
//! recorded ones.

use std::path::Path;
use std::process::ExitCode;

use super::origin::Origin;
use super::{broken, say, say_cut};
use crate::config::{Problem, Problems, nearest};
use crate::event::Tick;
use crate::replay::{Deviations, Recorded, RecordedItem, Replay};
use crate::report::{Chart, Curve, Figure, Page, Role, Section, Series, Stroke};

/// Tolerances by signal.
pub struct Comparison {
    tolerances: Vec<(String, f64)>,
}

/// Both courses of a signal.
#[derive(Clone, Debug, Default)]
struct Courses {
    recorded: Curve,
    replayed: Curve,
}

impl Comparison {
    /// Reads `SIGNAL=VALUE` each.
    pub fn new(tolerances: &[String]) -> Result<Self, Problem> {
        let tolerances = tolerances.iter().map(|text| read_tolerance(text)).collect::<Result<_, _>>()?;
        Ok(Self { tolerances })
    }

    /// Replays a log and compares.
    pub fn run(&self, origin: &Origin, log: &[u8], name: &Path, report: Option<&Path>) -> Result<ExitCode, Problems> {
        let mut deviations = Deviations::new(|name| self.tolerance(name));
        let mut replay = Replay::new(&origin.config, origin.paths.clone());
        let mut recorded = Recorded::new(log).map_err(|what| broken(name, &what))?;
        let mut courses = vec![Courses::default(); Tick::NAMES.len()];
        let period_s = origin.config.period.as_secs_f64();
        for item in recorded.by_ref() {
            match item.map_err(|what| broken(name, &what))? {
                RecordedItem::Exchange(exchange) => {
                    replay.take(&exchange, &mut deviations).map_err(|what| broken(name, &what.to_string()))?;
                }
                RecordedItem::Tick(was) => {
                    let is = deviations.recorded(&was);
                    if let Some(is) = is.filter(|_| report.is_some()) {
                        let at_s = was[0] * period_s;
                        for ((courses, was), is) in courses.iter_mut().zip(&*was).zip(is) {
                            courses.recorded.take(at_s, *was);
                            courses.replayed.take(at_s, is);
                        }
                    }
                }
                _ => {}
            }
        }
        let is_within = tell(&deviations, name);
        say_cut(recorded.is_cut());
        if let Some(path) = report {
            write_page(path, name, &deviations, courses)?;
            say(format_args!("  written          {}", path.display()));
        }
        Ok(ExitCode::from(u8::from(!is_within)))
    }

    fn tolerance(&self, name: &str) -> f64 {
        self.tolerances.iter().rev().find(|(known, _)| known == name).map_or(0.0, |(_, value)| *value)
    }
}

fn read_tolerance(text: &str) -> Result<(String, f64), Problem> {
    let refused = |what: String| Problem::bare(format!("--tolerance will not do: {what}"));
    let (name, value) =
        text.split_once('=').ok_or_else(|| refused(format!("found {text:?}, expected SIGNAL=VALUE")))?;
    if !Tick::NAMES.contains(&name) {
        let problem = refused(format!("the stack has no signal {name:?}"));
        return Err(match nearest(name, Tick::NAMES.into_iter()) {
            Some(near) => problem.help(format!("did you mean `{near}`?")),
            None => problem.help(format!("there are {}", Tick::NAMES.join(", "))),
        });
    }
    match value.parse() {
        Ok(number) if number >= 0.0 => Ok((name.to_owned(), number)),
        _ => Err(refused(format!("found {value:?} for {name}, expected a number from 0 on"))),
    }
}

/// Prints what deviates; says whether all is within its tolerance.
fn tell(deviations: &Deviations, name: &Path) -> bool {
    let deviating: Vec<_> = deviations.signals().filter(|(_, signal)| signal.first_tick.is_some()).collect();
    let beyond = deviating.iter().filter(|(_, signal)| signal.beyond_tick.is_some()).count();
    let verdict = match (deviating.len(), beyond) {
        (0, _) => "no signal differs",
        (_, 0) => "all signals are within their tolerances",
        _ => "signals differ by more than they may",
    };
    say(format_args!("{}: {verdict}", name.display()));
    say(format_args!("  ticks            {} compared", deviations.compared()));
    if !deviating.is_empty() {
        say(format_args!(
            "  {:<28} {:>12} {:>12} {:>8} {:>12} {:>12}",
            "signal", "first tick", "most", "at tick", "tolerance", "beyond from"
        ));
    }
    for (name, signal) in deviating {
        let first = signal.first_tick.unwrap_or_default();
        let beyond = signal.beyond_tick.map_or("-".to_owned(), |tick| tick.to_string());
        say(format_args!(
            "  {name:<28} {first:>12} {:>12.6} {:>8} {:>12} {beyond:>12}",
            signal.most, signal.most_tick, signal.tolerance
        ));
    }
    beyond == 0
}

/// A page with every signal that differs.
fn write_page(path: &Path, log: &Path, deviations: &Deviations, courses: Vec<Courses>) -> Result<(), Problem> {
    let mut page = Page::new(format!("Replay of {}", log.display()))
        .lead("What the stack did as recorded, and what it does with another configuration from the same input.");
    for ((name, signal), courses) in deviations.signals().zip(courses) {
        let Some(first) = signal.first_tick else { continue };
        let chart = Chart::new(name)
            .x_axis("time", "s")
            .y_axis(name, "")
            .series(Series::new("recorded", Role::Reference, Stroke::Solid, courses.recorded.points()))
            .series(Series::new("replayed", Role::Response, Stroke::Solid, courses.replayed.points()));
        let caption =
            format!("differs from tick {first} on, by {:.6} at most, in tick {}", signal.most, signal.most_tick);
        page = page.section(Section::new(name).figure(Figure::new(name, caption, vec![chart])));
    }
    std::fs::write(path, page.to_html())
        .map_err(|error| Problem::bare(format!("cannot write {}: {error}", path.display())))
}
