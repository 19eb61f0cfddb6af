//! What an expectation says, as a sentence.

use super::subject::Subject;
use super::{Bounds, Demand, Expectation, Span};

impl Expectation {
    /// Such as `position_error_m <= 0.01 from 30 s to 150 s`.
    pub fn claim(&self) -> String {
        let when = when(&self.span, self.demand);
        match &self.subject {
            Subject::State(_, name) => format!("state is {name} {when}"),
            subject => format!("{}{} {when}", what(subject), within(&self.bounds)),
        }
    }
}

fn what(subject: &Subject) -> String {
    match subject {
        Subject::Value(signal) | Subject::State(signal, _) => signal.name().to_owned(),
        Subject::Rate(signal) => format!("change of {} a second", signal.name()),
        Subject::Notices(kind) => format!("notices of `{kind}`"),
        Subject::Frames { name, .. } => format!("frames of {name}"),
        Subject::Samples { signal, above, below } => {
            let above = above.map(|above| format!("above {above}"));
            let below = below.map(|below| format!("below {below}"));
            let beyond: Vec<_> = above.into_iter().chain(below).collect();
            format!("samples of {} {}", signal.name(), beyond.join(" or "))
        }
    }
}

fn within(bounds: &Bounds) -> String {
    match (bounds.min, bounds.max) {
        (Some(min), Some(max)) if min == max => format!(" = {min}"),
        (min, max) => {
            let min = min.map_or(String::new(), |min| format!(" >= {min}"));
            let max = max.map_or(String::new(), |max| format!(" <= {max}"));
            min + &max
        }
    }
}

fn when(span: &Span, demand: Demand) -> String {
    let from_s = span.from_s;
    let start = match &span.after {
        Some(mark) if from_s == 0.0 => format!(" after `{mark}`"),
        Some(mark) => format!(" from {from_s} s after `{mark}` on"),
        None if from_s == 0.0 => String::new(),
        None => format!(" from {from_s} s on"),
    };
    match demand {
        Demand::Within { within_s, for_s: 0.0 } => format!("within {within_s} s{start}"),
        Demand::Within { within_s, for_s } => format!("for {for_s} s, beginning within {within_s} s{start}"),
        Demand::Always | Demand::Count => match (&span.after, span.until_s) {
            (None, until_s) => format!("from {from_s} s to {} s", until_s.unwrap_or(span.duration_s)),
            (Some(mark), Some(until_s)) => format!("from {from_s} s to {until_s} s after `{mark}`"),
            (Some(mark), None) if from_s == 0.0 => format!("after `{mark}`"),
            (Some(mark), None) => format!("from {from_s} s after `{mark}` on"),
        },
    }
}
