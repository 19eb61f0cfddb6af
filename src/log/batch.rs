//! Events in transit from the loop to the log's thread.
//!
//! An [`Event`] has the size of its largest variant; most events are frames of
//! 8 bytes. A batch keeps order and classic frames in one list and the large
//! payloads in lists of their own, so that the loop copies only what is there.

use crate::event::{BusFrame, Event, Mark, Notice, Sink, Tick, Timing, Truth};
use crate::exchange::Exchange;
use crate::frame::{CanId, Frame, FrameKind};
use crate::time::{Duration, Instant};

/// Events that one batch takes.
const CAPACITY: usize = 2048;
/// A batch goes to the log's thread when its events span this much time, so
/// that a loop in real time has little to lose when it is killed.
const SPAN: Duration = Duration::from_millis(250);

/// A list of events in order of time.
#[derive(Default)]
pub(super) struct Batch {
    /// Events that found no room after the batch before this one.
    pub lost_before: u64,
    items: Vec<(Instant, Item)>,
    frames: Vec<BusFrame>,
    ticks: Vec<Tick>,
    truths: Vec<Truth>,
    timings: Vec<Timing>,
    notices: Vec<Notice>,
    exchanges: Vec<Exchange>,
}

/// An event, or word that the next one of a list comes now.
enum Item {
    Classic { id: CanId, remote: bool, len: u8, data: [u8; 8], bus: u8, sent_by_stack: bool },
    Frame,
    Tick,
    Truth,
    Timing,
    Notice,
    Mark(Mark),
    Exchange,
}

impl Batch {
    /// An empty batch with room for what a batch mostly holds.
    pub fn with_room() -> Self {
        Self {
            items: Vec::with_capacity(CAPACITY),
            ticks: Vec::with_capacity(CAPACITY / 4),
            truths: Vec::with_capacity(CAPACITY / 4),
            timings: Vec::with_capacity(CAPACITY / 4),
            exchanges: Vec::with_capacity(CAPACITY),
            ..Self::default()
        }
    }

    /// Whether an event at `at` belongs into the next batch.
    pub fn is_full(&self, at: Instant) -> bool {
        self.items.len() >= CAPACITY || self.start().is_some_and(|start| at - start >= SPAN)
    }

    /// The time of its first event.
    pub fn start(&self) -> Option<Instant> {
        self.items.first().map(|&(at, _)| at)
    }

    /// Whether it takes such an event at all. The beginning of a period says
    /// nothing that its end does not, so [`Event::Sync`] is left out.
    pub const fn keeps(event: &Event) -> bool {
        !matches!(event, Event::Sync(_))
    }

    /// Takes an event.
    pub fn push(&mut self, at: Instant, event: &Event) {
        let item = match event {
            Event::Frame(on_bus) => self.frame_item(on_bus),
            Event::Sync(_) => return,
            Event::Tick(tick) => {
                self.ticks.push(*tick);
                Item::Tick
            }
            Event::Truth(truth) => {
                self.truths.push(*truth);
                Item::Truth
            }
            Event::Timing(timing) => {
                self.timings.push(*timing);
                Item::Timing
            }
            Event::Notice(notice) => {
                self.notices.push(*notice);
                Item::Notice
            }
            Event::Mark(mark) => Item::Mark(*mark),
            Event::Exchange(exchange) => {
                self.exchanges.push(*exchange);
                Item::Exchange
            }
        };
        self.items.push((at, item));
    }

    /// Gives every event to `sink`, in order, and leaves the batch empty.
    pub fn drain_into(&mut self, sink: &mut impl Sink) {
        let mut frames = self.frames.drain(..);
        let mut ticks = self.ticks.drain(..);
        let mut truths = self.truths.drain(..);
        let mut timings = self.timings.drain(..);
        let mut notices = self.notices.drain(..);
        let mut exchanges = self.exchanges.drain(..);
        for (at, item) in self.items.drain(..) {
            let event = match item {
                Item::Classic { id, remote, len, data, bus, sent_by_stack } => {
                    let mut frame = Frame::classic(id, &data[..usize::from(len)]);
                    frame.kind = if remote { FrameKind::Remote } else { FrameKind::Classic };
                    Some(Event::Frame(BusFrame { bus, sent_by_stack, frame }))
                }
                Item::Frame => frames.next().map(Event::Frame),
                Item::Tick => ticks.next().map(Event::Tick),
                Item::Truth => truths.next().map(Event::Truth),
                Item::Timing => timings.next().map(Event::Timing),
                Item::Notice => notices.next().map(Event::Notice),
                Item::Mark(mark) => Some(Event::Mark(mark)),
                Item::Exchange => exchanges.next().map(Event::Exchange),
            };
            sink.event(at, &event.expect("a list holds as many as were announced"));
        }
    }

    fn frame_item(&mut self, on_bus: &BusFrame) -> Item {
        let &BusFrame { bus, sent_by_stack, ref frame } = on_bus;
        match (frame.kind, frame.storage().first_chunk()) {
            (FrameKind::Classic | FrameKind::Remote, Some(&data)) if frame.len() <= data.len() => {
                let remote = frame.kind == FrameKind::Remote;
                Item::Classic { id: frame.id, remote, len: frame.len() as u8, data, bus, sent_by_stack }
            }
            _ => {
                self.frames.push(*on_bus);
                Item::Frame
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Keeps what it is given.
    struct Kept(Vec<(Instant, Event)>);

    impl Sink for Kept {
        fn event(&mut self, at: Instant, event: &Event) {
            self.0.push((at, *event));
        }
    }

    #[test]
    fn a_batch_gives_back_what_it_was_given_in_order_but_for_sync() {
        let id = CanId::Standard(0x181);
        let frame = |frame| Event::Frame(BusFrame { bus: 3, sent_by_stack: true, frame });
        let mut remote = Frame::zeroed(id, 4);
        remote.kind = FrameKind::Remote;
        let mut short_fd = Frame::classic(CanId::Extended(9), &[1, 2]);
        short_fd.kind = FrameKind::FdBitRateSwitch;
        let events = [
            frame(Frame::classic(id, &[1, 2, 3])),
            Event::Tick(Tick { tick: 1, ..Tick::default() }),
            frame(remote),
            Event::Truth(Truth { tick: 2, ..Truth::default() }),
            frame(short_fd),
            Event::Timing(Timing { tick: 3, lateness_s: 1e-5, ..Timing::default() }),
            Event::Notice(Notice { kind: "tripped", text: "The robot stopped." }),
            frame(Frame::zeroed(id, 64)),
            Event::Tick(Tick { tick: 2, ..Tick::default() }),
            Event::Exchange(Exchange::Sent(Frame::zeroed(id, 64))),
            Event::Exchange(Exchange::Farewell),
        ];
        let mut batch = Batch::default();
        batch.push(Instant::ZERO, &Event::Sync(Default::default()));
        for (nanos, event) in events.iter().enumerate() {
            batch.push(Instant::from_nanos(nanos as i64), event);
        }
        let mut kept = Kept(Vec::new());
        batch.drain_into(&mut kept);
        let expected: Vec<_> = (0..).map(Instant::from_nanos).zip(events).collect();
        assert_eq!(kept.0, expected);
        assert_eq!(batch.start(), None);
    }
}
