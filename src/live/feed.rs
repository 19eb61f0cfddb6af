//! From a loop to those who look on: bounded queues without locks, and a
//! thread that empties them.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant as WallTime};

use rtrb::{Consumer, Producer, RingBuffer};

use super::outlet::{Outlets, lock};
use crate::event::{Event, Sink};
use crate::time::Instant;

/// The loop's end: a push that takes no lock, no memory and never waits. What
/// finds no room is counted. What happens seldom, and people want to know, has
/// a queue of its own, which frames and samples cannot fill.
pub struct Feed {
    often: Producer<Timed>,
    seldom: Producer<Timed>,
    lost: Arc<AtomicU64>,
    takes_exchange: bool,
    verdict: Sender<String>,
    thread: Option<JoinHandle<()>>,
}

type Timed = (Instant, Event);

/// Frames and samples on their way: some seconds of a loop at 1 kHz.
const OFTEN: usize = 1 << 14;
/// Notices and marks on their way.
const SELDOM: usize = 1 << 12;
/// Events handed on in one go.
const BATCH: usize = 1024;
/// How long the thread rests when nothing has come.
const REST: Duration = Duration::from_millis(5);
/// From one update of what is shown to the next.
const UPDATE: Duration = Duration::from_millis(100);

impl Feed {
    /// A feed to `outlets`, and its thread.
    pub(super) fn start(outlets: Outlets) -> Self {
        let takes_exchange = lock(&outlets).iter().any(|outlet| outlet.wants_exchange());
        let (often, often_out) = RingBuffer::new(OFTEN);
        let (seldom, seldom_out) = RingBuffer::new(SELDOM);
        let (verdict, verdicts) = channel();
        let lost = Arc::new(AtomicU64::new(0));
        let drain = Drain {
            often: often_out,
            seldom: seldom_out,
            lost: Arc::clone(&lost),
            told_lost: 0,
            batch: Vec::with_capacity(BATCH),
            outlets,
        };
        let thread = Builder::new().name("live".to_owned()).spawn(move || drain.run(&verdicts));
        // Without a thread the queues fill up, and all that happens is counted as lost.
        Self { often, seldom, lost, takes_exchange, verdict, thread: thread.ok() }
    }

    /// The run is over and ended so, in words for people. Waits until all that
    /// has happened is shown.
    pub fn end(self, verdict: &str) {
        let _ = self.verdict.send(verdict.to_owned());
    }
}

impl Sink for Feed {
    fn event(&mut self, at: Instant, event: &Event) {
        let queue = match event {
            Event::Notice(_) | Event::Mark(_) => &mut self.seldom,
            Event::Exchange(_) if !self.takes_exchange => return,
            _ => &mut self.often,
        };
        if queue.push((at, *event)).is_err() {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl Drop for Feed {
    fn drop(&mut self) {
        // Without a word the thread takes the run for one that broke off.
        let _ = self.verdict.send(String::new());
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has said so itself.
            let _ = thread.join();
        }
    }
}

/// The other end.
struct Drain {
    often: Consumer<Timed>,
    seldom: Consumer<Timed>,
    lost: Arc<AtomicU64>,
    /// Losses that the outlets know of.
    told_lost: u64,
    batch: Vec<Timed>,
    outlets: Outlets,
}

impl Drain {
    fn run(mut self, verdicts: &Receiver<String>) {
        let mut shown = now();
        let verdict = loop {
            // Asked first: what was pushed before the word is taken after it.
            let verdict = verdicts.try_recv().ok();
            while self.hand_on() && now() - shown < UPDATE {}
            if let Some(verdict) = verdict {
                while self.hand_on() {}
                break verdict;
            }
            if now() - shown >= UPDATE {
                lock(&self.outlets).iter_mut().for_each(|outlet| outlet.show());
                shown = now();
            }
            rest();
        };
        let verdict = if verdict.is_empty() { "broken off" } else { &verdict };
        lock(&self.outlets).iter_mut().for_each(|outlet| outlet.end(verdict));
    }

    /// Hands a batch to the outlets; says whether there was anything.
    fn hand_on(&mut self) -> bool {
        self.batch.clear();
        for queue in [&mut self.seldom, &mut self.often] {
            while self.batch.len() < BATCH
                && let Ok(timed) = queue.pop()
            {
                self.batch.push(timed);
            }
        }
        let lost = self.lost.load(Ordering::Relaxed) - self.told_lost;
        self.told_lost += lost;
        if self.batch.is_empty() && lost == 0 {
            return false;
        }
        self.batch.sort_by_key(|&(at, _)| at);
        for outlet in lock(&self.outlets).iter_mut() {
            outlet.take(&self.batch);
            if lost > 0 {
                outlet.lose(lost);
            }
        }
        true
    }
}

#[allow(clippy::disallowed_methods, reason = "who looks on waits for the loop, by the wall clock")]
fn rest() {
    std::thread::sleep(REST);
}

#[allow(clippy::disallowed_methods, reason = "people look on by the wall clock; the loop does not see it")]
fn now() -> WallTime {
    WallTime::now()
}

#[cfg(test)]
mod tests {
    use std::sync::{Mutex, mpsc};

    use super::super::Run;
    use super::super::outlet::Outlet;
    use super::*;
    use crate::event::{Notice, SyncEvent};

    /// Keeps what it is told, and is as slow as the test likes.
    struct Kept {
        told: Arc<Mutex<Told>>,
        gate: Option<mpsc::Receiver<()>>,
    }

    #[derive(Default)]
    struct Told {
        events: Vec<Timed>,
        lost: u64,
        verdict: Option<String>,
    }

    impl Outlet for Kept {
        fn begin(&mut self, _: &Run<'_>) {}

        fn take(&mut self, events: &[Timed]) {
            if let Some(gate) = self.gate.take() {
                let _ = gate.recv();
            }
            self.told.lock().unwrap().events.extend_from_slice(events);
        }

        fn lose(&mut self, events: u64) {
            self.told.lock().unwrap().lost += events;
        }

        fn show(&mut self) {}

        fn end(&mut self, verdict: &str) {
            self.told.lock().unwrap().verdict = Some(verdict.to_owned());
        }
    }

    fn feed(gate: Option<mpsc::Receiver<()>>) -> (Feed, Arc<Mutex<Told>>) {
        let told = Arc::new(Mutex::new(Told::default()));
        let outlet = Kept { told: Arc::clone(&told), gate };
        (Feed::start(Arc::new(Mutex::new(vec![Box::new(outlet)]))), told)
    }

    fn sync(tick: u64) -> Event {
        Event::Sync(SyncEvent { tick, ..SyncEvent::default() })
    }

    const NOTICE: Event = Event::Notice(Notice { kind: "tripped", text: "tripped: a test" });

    #[test]
    fn all_that_was_pushed_is_shown_in_order_before_the_run_is_over() {
        let (mut feed, told) = feed(None);
        for tick in 0..5000 {
            feed.event(Instant::from_nanos(tick * 2), &sync(tick as u64));
        }
        feed.event(Instant::from_nanos(10_001), &NOTICE);
        feed.end("passed");
        let told = told.lock().unwrap();
        assert_eq!((told.events.len(), told.lost), (5001, 0));
        assert!(told.events.iter().filter(|(_, event)| *event != NOTICE).is_sorted_by_key(|&(at, _)| at));
        assert_eq!(told.verdict.as_deref(), Some("passed"));
    }

    #[test]
    fn what_finds_no_room_is_counted_and_leaves_room_for_notices() {
        let (open, gate) = mpsc::channel();
        let (mut feed, told) = feed(Some(gate));
        let pushed = 3 * OFTEN as u64;
        for tick in 0..pushed {
            feed.event(Instant::from_nanos(tick as i64), &sync(tick));
        }
        feed.event(Instant::from_nanos(pushed as i64), &NOTICE);
        open.send(()).unwrap();
        feed.end("passed");
        let told = told.lock().unwrap();
        assert!(told.lost >= pushed - OFTEN as u64 - 2 * BATCH as u64, "{}", told.lost);
        assert_eq!(told.events.len() as u64 + told.lost, pushed + 1);
        assert!(told.events.contains(&(Instant::from_nanos(pushed as i64), NOTICE)));
    }

    #[test]
    fn a_loop_that_breaks_off_leaves_word_of_that() {
        let (feed, told) = feed(None);
        drop(feed);
        assert_eq!(told.lock().unwrap().verdict.as_deref(), Some("broken off"));
    }
}
