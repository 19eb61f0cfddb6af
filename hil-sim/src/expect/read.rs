//! Reads `[[expect]]`.

use canloop::config::{Bound, Item, Section, nearest};
use canloop::event::{Notice, Tick, Truth};
use canloop::safety::Reason;
use canloop::schema::Dbc;

use super::{Bounds, Demand, Expectation, Signal, Span, Subject};

/// What the names in an expectation can stand for.
#[derive(Clone, Copy, Debug)]
pub struct Vocabulary<'v> {
    /// The messages of the bus.
    pub dbc: &'v Dbc,
    /// Names of the scenario's own events.
    pub events: &'v [String],
    /// How long the run is, s.
    pub duration_s: f64,
}

/// Keys that say what is looked at; each expectation has one of them.
const SUBJECTS: [&str; 6] = ["signal", "rate_of", "state", "notices", "frames", "samples"];

impl Expectation {
    /// Reads an `[[expect]]` table: an expectation for each of the names that
    /// it lists. One that reaches beyond the end of the run is a mistake,
    /// unless the run was `shortened` by somebody else than who wrote it.
    pub fn read(section: &Section<'_>, vocabulary: &Vocabulary<'_>, shortened: bool) -> Vec<Self> {
        let name = section.text_or_none("name");
        let subjects = read_subjects(section, vocabulary);
        let key = SUBJECTS.into_iter().find(|key| section.has(key)).unwrap_or(SUBJECTS[0]);
        let counts = matches!(key, "notices" | "frames" | "samples");
        let bounds = read_bounds(section, key, counts);
        let demand = read_demand(section, counts);
        let span = read_span(section, vocabulary, shortened);
        if !shortened {
            check_span(section, &span, demand);
        }
        let (file, line) = section.line();
        let listed = subjects.len() > 1;
        let one = |(subject, of_state): (Subject, Option<Bounds>)| Self {
            name: name.as_ref().map(|name| if listed { format!("{name}, {}", subject.name()) } else { name.clone() }),
            subject,
            bounds: of_state.unwrap_or(bounds),
            span: span.clone(),
            demand,
            place: (file.to_owned(), line),
        };
        subjects.into_iter().map(one).collect()
    }
}

/// The subjects, and for a state its bounds.
fn read_subjects(section: &Section<'_>, vocabulary: &Vocabulary<'_>) -> Vec<(Subject, Option<Bounds>)> {
    let given: Vec<_> = SUBJECTS.into_iter().filter(|key| section.has(key)).collect();
    let list = || SUBJECTS.map(|key| format!("`{key}`")).join(", ");
    let [key] = given[..] else {
        let label = match given[..] {
            [first, second, ..] => format!("found `{second}` beside `{first}`, expected one of {}", list()),
            _ => format!("found none of {}", list()),
        };
        let at = given.get(1).copied().unwrap_or_default();
        let problem = section.problem(at, "an expectation looks at one thing", &label);
        section.report(problem);
        return Vec::new();
    };
    let beyond = |key| section.number_or_none(key, Bound::Finite);
    let (above, below) = if key == "samples" { (beyond("above"), beyond("below")) } else { (None, None) };
    if key == "samples" && !section.has("above") && !section.has("below") {
        section.complain("samples", "found no value beyond which they count, expected `above` or `below`");
    }
    let subject = |name: String| {
        let signal = || find_signal(section, key, &name, vocabulary.dbc);
        Some(match key {
            "signal" => (Subject::Value(signal()?), None),
            "rate_of" => (Subject::Rate(signal()?), None),
            "samples" => (Subject::Samples { signal: signal()?, above, below }, None),
            "notices" => (Subject::Notices(find_notice(section, &name)?), None),
            "frames" => (find_frames(section, &name, vocabulary.dbc)?, None),
            _ => (Subject::State(Signal::Tick(STATE), name.clone()), Some(find_state(section, &name)?)),
        })
    };
    names(section, key).into_iter().filter_map(subject).collect()
}

/// Where in [`Tick::NAMES`] the state stands.
const STATE: usize = 1;

/// The names under `key`: one, or a list.
fn names(section: &Section<'_>, key: &str) -> Vec<String> {
    let items = section.items(key);
    let names: Vec<String> =
        items.iter().filter_map(|item| if let Item::Text(name) = item { Some(name.clone()) } else { None }).collect();
    if names.len() < items.len() || items.is_empty() {
        section.complain(key, "expected a name, or a list of names");
        return Vec::new();
    }
    names
}

fn read_bounds(section: &Section<'_>, key: &str, counts: bool) -> Bounds {
    let sort = if counts { Bound::NotNegative } else { Bound::Finite };
    let read = |bound| section.number_or_none(bound, sort);
    let bounds = Bounds { min: read("min"), max: read("max") };
    let has_bounds = section.has("min") || section.has("max");
    if key == "state" {
        if has_bounds {
            section.complain(
                if section.has("min") { "min" } else { "max" },
                "found a bound on a state's name, expected none",
            );
        }
    } else if !has_bounds {
        section.complain(key, "found no bound on it, expected `max` or `min`");
    }
    if bounds.min > bounds.max && bounds.max.is_some() {
        section.complain("min", "found a `min` above `max`, expected it below");
    }
    bounds
}

fn read_demand(section: &Section<'_>, counts: bool) -> Demand {
    let within_s = section.number_or_none("within_s", Bound::NotNegative);
    let for_s = section.number_or_none("for_s", Bound::NotNegative);
    if counts {
        for key in ["within_s", "for_s"].into_iter().filter(|key| section.has(key)) {
            section.complain(key, "found with a count, expected `until_s`, which says how long to count");
        }
        return Demand::Count;
    }
    if section.has("for_s") && !section.has("within_s") {
        section.complain("for_s", "found without `within_s`, expected the time within which this is to begin");
    }
    if section.has("until_s") && section.has("within_s") {
        section
            .complain("until_s", "found beside `within_s`, expected one of them: within a time, or all through a span");
    }
    match within_s {
        Some(within_s) => Demand::Within { within_s, for_s: for_s.unwrap_or(0.0) },
        None => Demand::Always,
    }
}

fn read_span(section: &Section<'_>, vocabulary: &Vocabulary<'_>, shortened: bool) -> Span {
    let after = section.text_or_none("after");
    if let Some(mark) = &after {
        let events = vocabulary.events.iter().map(String::as_str);
        let known: Vec<_> = events.chain(notice_kinds()).collect();
        known_name(section, "after", mark, &known);
    }
    Span {
        from_s: section.number_or("from_s", 0.0, Bound::NotNegative),
        until_s: section.number_or_none("until_s", Bound::NotNegative),
        after,
        duration_s: vocabulary.duration_s,
        shortened,
    }
}

fn check_span(section: &Section<'_>, span: &Span, demand: Demand) {
    let Span { from_s, duration_s, .. } = *span;
    let until_s = span.until_s.unwrap_or(duration_s);
    let last = match demand {
        Demand::Within { within_s, for_s } => from_s + within_s + for_s,
        _ => until_s,
    };
    if last > duration_s {
        let key = if section.has("within_s") { "within_s" } else { "until_s" };
        section.complain(key, &format!("found {last}, expected no more than `duration_s`, {duration_s}"));
    } else if from_s >= until_s {
        let label = format!("found {from_s}, expected a time before {until_s}");
        let problem = section.problem("from_s", "this span has no beginning within the run", &label);
        section.report(problem);
    }
}

fn find_signal(section: &Section<'_>, key: &str, name: &str, dbc: &Dbc) -> Option<Signal> {
    let position = |names: &[&str]| names.iter().position(|known| *known == name);
    if let Some(index) = position(&Truth::NAMES) {
        return Some(Signal::Truth(index));
    }
    if let Some(index) = position(&Tick::NAMES) {
        return Some(Signal::Tick(index));
    }
    let Some((message, signal)) = name.split_once('.') else {
        known_name(section, key, name, &[&Truth::NAMES[..], &Tick::NAMES].concat());
        return None;
    };
    let Some(layout) = dbc.message(message) else {
        unknown(section, key, "there is no such message", message, &message_names(dbc));
        return None;
    };
    match layout.signals.iter().position(|known| known.name == signal) {
        Some(index) => Some(Signal::Framed { name: name.to_owned(), layout: Box::new(layout.clone()), index }),
        None => {
            let title = format!("`{message}` has no such signal");
            let known: Vec<_> = layout.signals.iter().map(|known| known.name.as_str()).collect();
            unknown(section, key, &title, signal, &known);
            None
        }
    }
}

fn find_frames(section: &Section<'_>, name: &str, dbc: &Dbc) -> Option<Subject> {
    let found = dbc.message(name).map(|layout| Subject::Frames { name: name.to_owned(), id: layout.id });
    if found.is_none() {
        unknown(section, "frames", "there is no such message", name, &message_names(dbc));
    }
    found
}

fn find_notice(section: &Section<'_>, name: &str) -> Option<String> {
    known_name(section, "notices", name, &notice_kinds()).then(|| name.to_owned())
}

fn find_state(section: &Section<'_>, name: &str) -> Option<Bounds> {
    let bounds = Bounds::of_state(name);
    known_name(section, "state", name, &Bounds::state_names().collect::<Vec<_>>());
    bounds
}

/// Whether a name is one of those; what is wrong where it is not.
fn known_name(section: &Section<'_>, key: &str, name: &str, known: &[&str]) -> bool {
    let is_known = known.contains(&name);
    if !is_known {
        let what = match key {
            "after" => "event",
            "notices" => "kind of notice",
            "state" => "state",
            _ => "signal",
        };
        unknown(section, key, &format!("there is no such {what}"), name, known);
    }
    is_known
}

fn unknown(section: &Section<'_>, key: &str, title: &str, name: &str, known: &[&str]) {
    let list = known.join(", ");
    let problem = section.problem(key, title, &format!("found {name:?}"));
    section.report(match nearest(name, known.iter().copied()) {
        Some(near) => problem.help(format!("did you mean `{near}`? There are {list}")),
        None => problem.help(format!("there are {list}")),
    });
}

/// Kinds of notices; a trip is also of the kind that is its reason.
fn notice_kinds() -> Vec<&'static str> {
    Notice::KINDS.into_iter().chain(Reason::ALL.into_iter().map(Reason::name)).collect()
}

fn message_names(dbc: &Dbc) -> Vec<&str> {
    dbc.messages.iter().map(|message| message.name.as_str()).collect()
}
