//! From a real-time loop to whoever reads its events: a bounded queue without
//! locks. The loop never waits; what finds no room is counted.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use rtrb::{Consumer, Producer, RingBuffer};

use crate::event::{Event, Sink};
use crate::time::Instant;

/// The loop's end.
pub struct Tap {
    ring: Producer<(Instant, Event)>,
    lost: Arc<AtomicU64>,
}

/// The reader's end.
pub struct Drain {
    ring: Consumer<(Instant, Event)>,
    lost: Arc<AtomicU64>,
}

/// Events on their way: some three seconds of a loop at 1 kHz.
const CAPACITY: usize = 1 << 15;

/// A queue and both its ends; all its memory is taken now.
pub fn tap() -> (Tap, Drain) {
    let (producer, consumer) = RingBuffer::new(CAPACITY);
    let lost = Arc::new(AtomicU64::new(0));
    (Tap { ring: producer, lost: Arc::clone(&lost) }, Drain { ring: consumer, lost })
}

impl Sink for Tap {
    fn event(&mut self, at: Instant, event: &Event) {
        if self.ring.push((at, *event)).is_err() {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl Drain {
    /// Hands what has come to `sink`; says whether more can come.
    pub fn drain_into(&mut self, sink: &mut impl Sink) -> bool {
        let open = !self.ring.is_abandoned();
        while let Ok((at, event)) = self.ring.pop() {
            sink.event(at, &event);
        }
        open
    }

    /// Events that found no room so far.
    pub fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }
}
