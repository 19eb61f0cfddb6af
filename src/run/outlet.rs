//! The way out of a stack: events to their reader, frames to the bus.

use crate::bus::{Bus, BusError};
use crate::event::{BusFrame, Event, Sink};
use crate::frame::Frame;
use crate::run::BusCounts;
use crate::stack::Stack;
use crate::time::Instant;

/// Passes on what a stack has to say.
#[derive(Default)]
pub(super) struct Outlet {
    /// A frame for which the transmit queue had no room.
    waiting: Option<Frame>,
    /// What passed through the bus, as far as it goes out.
    pub counts: BusCounts,
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
        tell(stack, sink, now);
        let sent = self.send(stack, bus, sink, now);
        // That a frame came out is an event as well.
        tell(stack, sink, now);
        sent
    }

    fn send(
        &mut self,
        stack: &mut Stack,
        bus: &mut dyn Bus,
        sink: &mut impl Sink,
        now: Instant,
    ) -> Result<(), BusError> {
        let mut tried_before = self.is_blocked();
        while let Some(frame) = self.waiting.take().or_else(|| stack.poll_transmit()) {
            match bus.send(&frame) {
                Ok(()) => {
                    self.counts.sent += 1;
                    sink.event(now, &Event::Frame(BusFrame { bus: 0, sent_by_stack: true, frame }));
                }
                Err(BusError::Full) => {
                    self.counts.delayed += u64::from(!tried_before);
                    self.waiting = Some(frame);
                    break;
                }
                Err(error) => return Err(error),
            }
            tried_before = false;
        }
        Ok(())
    }

    /// Whether a frame waits for room in the transmit queue.
    pub const fn is_blocked(&self) -> bool {
        self.waiting.is_some()
    }

    /// Drops all frames that wait; says whether there were any.
    pub fn give_up(&mut self, stack: &mut Stack) -> bool {
        if self.waiting.take().is_none() {
            return false;
        }
        self.counts.given_up += 1;
        while stack.poll_transmit().is_some() {
            self.counts.given_up += 1;
        }
        true
    }
}

fn tell(stack: &mut Stack, sink: &mut impl Sink, now: Instant) {
    while let Some(event) = stack.poll_event() {
        sink.event(now, &event);
    }
}
