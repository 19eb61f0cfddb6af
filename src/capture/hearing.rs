//! One bus, heard on a thread of its own.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::{Builder, JoinHandle};

use rtrb::{Consumer, RingBuffer};

use super::Filter;
use crate::bus::{Arrival, Bus, BusError};
use crate::run::{Clock, StopSwitch};
use crate::time::{Duration, Instant};
use crate::traffic::{Content, Direction};

/// Something heard, and when.
pub type Heard = (Instant, Arrival);

/// The recorder's end of a bus.
pub struct Hearing {
    /// The bus's name in the log.
    pub name: String,
    pub(super) queue: Consumer<Heard>,
    /// What found no room in the queue.
    pub(super) lost: Arc<AtomicU64>,
    thread: JoinHandle<Result<(), BusError>>,
}

/// Seconds of a full bus: frames are told apart by what they are, not by how many
/// fit into some memory.
const QUEUE: usize = 1 << 16;
/// How often to look whether somebody wants to stop.
const LOOK_UP: Duration = Duration::from_millis(50);

/// Hears a bus from now on, until somebody presses `stop` or the bus is gone.
///
/// # Errors
/// There is no thread for it.
pub fn hear(
    name: String,
    mut bus: Box<dyn Bus + Send>,
    filter: Filter,
    clock: Clock,
    stop: &'static StopSwitch,
) -> std::io::Result<Hearing> {
    let (mut to_recorder, queue) = RingBuffer::new(QUEUE);
    let lost = Arc::new(AtomicU64::new(0));
    let counter = Arc::clone(&lost);
    let mut keep = move |at: Instant, arrival: Arrival| {
        let arrival = with_content(arrival);
        let is_wanted = !matches!(&arrival, Arrival::Heard(_, content) if !filter.wants(content));
        if is_wanted && to_recorder.push((at, arrival)).is_err() {
            counter.fetch_add(1, Ordering::Relaxed);
        }
    };
    let listen = move || {
        let mut until = clock.now();
        while stop.wish().is_none() {
            match bus.receive(until)? {
                Some((at, arrival)) => keep(at, arrival),
                None => until = clock.now() + LOOK_UP,
            }
        }
        // What had come by then, and only waits to be read, is kept as well.
        let end = clock.now();
        while let Some((at, arrival)) = bus.receive(end)?.filter(|(at, _)| *at <= end) {
            keep(at, arrival);
        }
        Ok(())
    };
    let thread = Builder::new().name(format!("hear {name}")).spawn(listen)?;
    Ok(Hearing { name, queue, lost, thread })
}

impl Hearing {
    /// Whether nothing more comes.
    pub fn has_ended(&self) -> bool {
        self.queue.is_abandoned() && self.queue.is_empty()
    }

    /// Why it ended, if nobody wanted it to.
    pub fn end(self) -> Option<BusError> {
        self.thread.join().map_or(None, Result::err)
    }
}

/// Buses that tell no more than their frames have received all of them.
fn with_content(arrival: Arrival) -> Arrival {
    match arrival {
        Arrival::Frame(frame) => Arrival::Heard(Direction::Received, Content::Frame(frame.into())),
        other => other,
    }
}
