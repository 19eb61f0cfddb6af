//! Lets a stack do again what a recorded one did: it is given the same things
//! in the same order, and what it says is held to what that one said.
//!
//! Like the stack it has no hands: whoever reads the log hands it one
//! [`Exchange`] after the other.

mod deviation;
mod playback;
mod recorded;

use crate::event::{Event, Sink};
use crate::exchange::Exchange;
use crate::frame::Frame;
use crate::path::Path;
use crate::stack::{Stack, StackConfig};
use crate::time::Instant;

pub use deviation::{Deviation, Deviations};
pub use playback::Playback;
pub use recorded::{Recorded, RecordedItem, attachments};

/// A stack that is given what another one was given.
pub struct Replay<'c> {
    config: &'c StackConfig,
    /// Paths that an operator may ask for, by the number of their event.
    paths: Vec<(u16, Path)>,
    stack: Option<Stack>,
    /// The moment of the last thing that went in.
    now: Instant,
    /// Periods begun.
    ticks: u64,
    /// Frames that came out as recorded.
    frames: u64,
}

/// The first frame that came out otherwise than recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Difference {
    /// In which period, counted from 0.
    pub tick: u64,
    /// The moment of what went in last.
    pub at: Instant,
    /// What the recorded stack sent there.
    pub recorded: Frame,
    /// What this one sends, if it sends anything.
    pub replayed: Option<Frame>,
}

/// Why a replay cannot go on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReplayError {
    /// The log does not begin where the stack began.
    #[error("the log does not say how its stack began: what went into it before is missing")]
    NoBeginning,
    /// The configuration has no such path.
    #[error("the stack was given the path of event {0} of its scenario, but there is no such event")]
    NoPath(u16),
}

impl<'c> Replay<'c> {
    /// A replay to a stack made from `config`, with the paths that an operator
    /// may ask for by the number of their event.
    pub fn new(config: &'c StackConfig, paths: Vec<(u16, Path)>) -> Self {
        Self { config, paths, stack: None, now: Instant::ZERO, ticks: 0, frames: 0 }
    }

    /// Does what the recorded stack was let do, or compares what it sent. Events
    /// of this stack go to `sink`. What it has yet to send when the log is over is
    /// no difference: the recorded run may have ended before that left.
    ///
    /// # Errors
    /// What keeps the replay from going on.
    pub fn take(&mut self, exchange: &Exchange, sink: &mut impl Sink) -> Result<Option<Difference>, ReplayError> {
        let stack = match (*exchange, &mut self.stack) {
            (Exchange::Begin(start), stack) => stack.insert(Stack::new(self.config, start)),
            (_, Some(stack)) => stack,
            (_, None) => return Err(ReplayError::NoBeginning),
        };
        match *exchange {
            Exchange::Begin(_) => {}
            Exchange::Sent(recorded) => {
                let replayed = stack.poll_transmit();
                return Ok(self.compare(recorded, replayed));
            }
            Exchange::Frame(at, frame) => {
                self.now = at;
                stack.handle_frame(at, &frame);
            }
            Exchange::Wakeup(at) => {
                self.now = at;
                stack.handle_wakeup(at);
            }
            Exchange::Operate(wish) => stack.operate(wish),
            Exchange::Trip(reason) => stack.trip(reason),
            Exchange::Follow(event) => {
                let path = self.paths.iter().find(|(number, _)| *number == event);
                let (_, path) = path.ok_or(ReplayError::NoPath(event))?;
                stack.follow(path.clone(), event);
            }
            Exchange::Farewell => stack.farewell(),
        }
        while let Some(event) = stack.poll_event() {
            self.ticks += u64::from(matches!(event, Event::Sync(_)));
            sink.event(self.now, &event);
        }
        Ok(None)
    }

    /// Periods begun.
    pub const fn ticks(&self) -> u64 {
        self.ticks
    }

    /// Frames that came out as recorded.
    pub const fn frames(&self) -> u64 {
        self.frames
    }

    fn compare(&mut self, recorded: Frame, replayed: Option<Frame>) -> Option<Difference> {
        if Some(recorded) == replayed {
            self.frames += 1;
            return None;
        }
        Some(Difference { tick: self.ticks.saturating_sub(1), at: self.now, recorded, replayed })
    }
}
