//! A number that a run has at every moment, and where in its events it stands.

use canloop::event::{Event, Tick, Truth};
use canloop::schema::MessageLayout;
use canloop::time::Instant;

/// A signal of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Signal {
    /// Of the stack, by its index in [`Tick::NAMES`].
    Tick(usize),
    /// Of the plant, by its index in [`Truth::NAMES`].
    Truth(usize),
    /// Of a message that crosses the bus.
    Framed {
        /// `Message.Signal`.
        name: String,
        /// The message.
        layout: Box<MessageLayout>,
        /// The signal's index in it.
        index: usize,
    },
}

impl Signal {
    /// The name that scenarios call it by.
    pub fn name(&self) -> &str {
        match self {
            Self::Tick(index) => Tick::NAMES[*index],
            Self::Truth(index) => Truth::NAMES[*index],
            Self::Framed { name, .. } => name,
        }
    }

    /// Time (s) and value, where `event` says it. What happens once a period
    /// has the time of the period's beginning, of `period_s`.
    pub fn sample(&self, at: Instant, event: &Event, period_s: f64) -> Option<(f64, f64)> {
        match (self, event) {
            (Self::Tick(index), Event::Tick(tick)) => Some((tick.tick as f64 * period_s, tick.values()[*index])),
            (Self::Truth(index), Event::Truth(truth)) => Some((truth.tick as f64 * period_s, truth.values()[*index])),
            (Self::Framed { layout, index, .. }, Event::Frame(crossed)) if crossed.frame.id == layout.id => {
                let wanted = &layout.signals[*index];
                let said = layout.decode(&crossed.frame).find(|(signal, _)| signal.name == wanted.name);
                said.map(|(_, value)| (at.as_secs_f64(), value))
            }
            _ => None,
        }
    }
}
