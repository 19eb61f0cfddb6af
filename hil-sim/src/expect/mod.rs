//! What must hold of a run, and whether it did.
//!
//! An [`Expectation`] looks at a [`Subject`] for a [`Span`] of simulated time
//! and holds it to [`Bounds`]: all the while, at some moment, for some time, or
//! by counting. A [`Watch`] follows one through a run and ends in a
//! [`Verdict`].

mod always;
mod around;
mod bounds;
mod claim;
mod count;
mod read;
mod signal;
mod span;
mod subject;
mod verdict;
mod watch;
mod within;

pub use bounds::Bounds;
pub use read::Vocabulary;
pub use signal::Signal;
pub use span::Span;
pub use subject::Subject;
pub use verdict::{Sample, Verdict};
pub use watch::{Occurrence, Watch};

/// Something that must hold of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Expectation {
    /// What its author calls it.
    name: Option<String>,
    pub(crate) subject: Subject,
    bounds: Bounds,
    span: Span,
    demand: Demand,
    /// The text that it stands in, and the line there.
    place: (String, usize),
}

/// How a subject must keep to its bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Demand {
    /// All through the span.
    Always,
    /// From some moment within the first so many seconds of the span on, for
    /// `for_s`; 0 is for that moment.
    Within { within_s: f64, for_s: f64 },
    /// Its number must, once the span is over.
    Count,
}

impl Expectation {
    /// Starts watching a run with period `period_s`.
    pub fn watch(&self, period_s: f64) -> Watch {
        Watch::new(self.clone(), period_s)
    }
}
