//! What an expectation looks at.

use canloop::event::{Event, Notice};
use canloop::frame::CanId;
use canloop::time::Instant;

use super::bounds::Bounds;
use super::signal::Signal;

/// What is held to bounds.
#[derive(Clone, Debug, PartialEq)]
pub enum Subject {
    /// A signal's value.
    Value(Signal),
    /// How fast a signal changes from one sample to the next, per second.
    Rate(Signal),
    /// The stack's state, whose name this is.
    State(Signal, String),
    /// The number of notices of a kind.
    Notices(String),
    /// The number of frames of a message.
    Frames {
        /// The message's name.
        name: String,
        /// Its id.
        id: CanId,
    },
    /// The number of a signal's samples beyond a value.
    Samples {
        /// The signal.
        signal: Signal,
        /// Those above this count,
        above: Option<f64>,
        /// or below this.
        below: Option<f64>,
    },
}

/// What an event says of a subject.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Said {
    /// Time, s, and value.
    Value(f64, f64),
    /// Something to be counted happened at this time, s.
    Happened(f64),
}

impl Subject {
    /// Its name in figures: that of the signal, the message or the kind.
    pub fn name(&self) -> &str {
        match self {
            Self::Value(signal) | Self::Rate(signal) | Self::State(signal, _) | Self::Samples { signal, .. } => {
                signal.name()
            }
            Self::Notices(name) | Self::Frames { name, .. } => name,
        }
    }

    /// The signal that its samples are of.
    pub const fn signal(&self) -> Option<&Signal> {
        match self {
            Self::Value(signal) | Self::Rate(signal) | Self::State(signal, _) | Self::Samples { signal, .. } => {
                Some(signal)
            }
            Self::Notices(_) | Self::Frames { .. } => None,
        }
    }

    /// Whether only the stack itself knows of it.
    pub(super) const fn is_of_the_stack(&self) -> bool {
        matches!(self, Self::Notices(_)) || matches!(self.signal(), Some(Signal::Tick(_)))
    }

    /// What `event` says of it.
    pub(super) fn said(&self, at: Instant, event: &Event, period_s: f64) -> Option<Said> {
        match (self, event) {
            (Self::Notices(kind), Event::Notice(notice)) => {
                is_of_kind(notice, kind).then(|| Said::Happened(at.as_secs_f64()))
            }
            (Self::Frames { id, .. }, Event::Frame(crossed)) => {
                (crossed.frame.id == *id).then(|| Said::Happened(at.as_secs_f64()))
            }
            _ => self.signal()?.sample(at, event, period_s).map(|(at_s, value)| Said::Value(at_s, value)),
        }
    }

    /// How far inside `bounds` a value is, negative when outside. A state is
    /// inside or outside, and neither more than another.
    pub(super) fn margin(&self, value: f64, bounds: &Bounds) -> f64 {
        let margin = bounds.margin(value);
        if matches!(self, Self::State(..)) { margin.clamp(-1.0, 0.0) } else { margin }
    }

    /// Whether a sample of it counts.
    pub(super) fn counts(&self, value: f64) -> bool {
        match self {
            Self::Samples { above, below, .. } => {
                above.is_some_and(|above| value > above) || below.is_some_and(|below| value < below)
            }
            _ => true,
        }
    }
}

/// Whether a notice is of a kind, or is a trip for the reason of that name.
pub(super) fn is_of_kind(notice: &Notice, kind: &str) -> bool {
    let is_reason = |reason: &canloop::safety::Reason| reason.name() == kind && reason.text() == notice.text;
    notice.kind == kind || notice.kind == "tripped" && canloop::safety::Reason::ALL.iter().any(is_reason)
}
