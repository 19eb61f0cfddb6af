//! The way out of a stack: events to their reader, frames to the bus.

use crate::bus::{Bus, BusError};
use crate::event::{BusFrame, Event, Sink};
use crate::frame::Frame;
use crate::stack::Stack;
use crate::time::Instant;

/// Passes on what a stack has to say.
#[derive(Default)]
pub(super) struct Outlet {
    /// A frame for which the transmit queue had no room.
    waiting: Option<Frame>,
}

impl Outlet {
    /// Tells what happened and sends what the bus takes; the rest waits.
    pub fn drain(
        &mut self,
        stack: &mut Stack,
        bus: &mut dyn Bus,
        sink: &mut impl Sink,
        now: Instant,
    ) -> Result<(), BusError> {
        while let Some(event) = stack.poll_event() {
            sink.event(now, &event);
        }
        while let Some(frame) = self.waiting.take().or_else(|| stack.poll_transmit()) {
            match bus.send(&frame) {
                Ok(()) => sink.event(now, &Event::Frame(BusFrame { bus: 0, sent_by_stack: true, frame })),
                Err(BusError::Full) => {
                    self.waiting = Some(frame);
                    break;
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Whether a frame waits for room in the transmit queue.
    pub const fn is_blocked(&self) -> bool {
        self.waiting.is_some()
    }

    /// Drops all frames that wait; says whether there were any.
    pub fn give_up(&mut self, stack: &mut Stack) -> bool {
        let was_blocked = self.waiting.take().is_some();
        while was_blocked && stack.poll_transmit().is_some() {}
        was_blocked
    }
}
