//! The paper's simulations: which there are, and the pictures and the page
//! made of them.

mod cases;
mod page;
mod pictures;

pub use cases::{Case, Friction, Setup, cases};
pub use page::page;
pub use pictures::{Picture, figures};

use crate::summary::Summary;
use crate::trace::Trace;

/// A case and what came of it.
#[derive(Clone, Debug)]
pub struct Finished {
    /// What was run.
    pub case: Case,
    /// Its figures.
    pub summary: Summary,
    /// What its pictures are drawn from.
    pub trace: Trace,
}

/// How a run went, in a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It stayed on its path to the end.
    Tracks,
    /// It ended elsewhere.
    Drifts,
    /// Its torque never settled.
    Rings,
    /// Its stack tripped.
    Trips,
    /// It ran away, out of the circle's reach.
    Diverges,
}

/// A robot that ends further from its path than this, m, has left it.
const ON_PATH_M: f64 = 0.02;
/// No two points of the circle are this far apart, m: a robot that ever was is
/// running away.
const RUNAWAY_M: f64 = 10.0;

impl Finished {
    /// How it went.
    pub fn outcome(&self) -> Outcome {
        let summary = &self.summary;
        match summary.state {
            Some("tripped") => Outcome::Trips,
            _ if summary.tracking.max_m > RUNAWAY_M => Outcome::Diverges,
            _ if summary.rings => Outcome::Rings,
            _ if summary.tracking.final_m > ON_PATH_M => Outcome::Drifts,
            _ => Outcome::Tracks,
        }
    }
}

impl Outcome {
    /// The word.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tracks => "tracks",
            Self::Drifts => "drifts",
            Self::Rings => "rings",
            Self::Trips => "trips",
            Self::Diverges => "diverges",
        }
    }
}
