//! The real-time loop takes no memory once it runs: not for frames, not for
//! events, not for a trip.

#![allow(unsafe_code, reason = "an allocator is unsafe by its trait")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::collections::VecDeque;

use canloop::bus::{Arrival, Bus, BusError};
use canloop::event::{Event, Sink};
use canloop::frame::Frame;
use canloop::live::{Addresses, Feed, Live, Run};
use canloop::log::LogContents;
use canloop::run::{Clock, End, RealTime, StopSwitch, Tap, tap};
use canloop::safety::Operator;
use canloop::stack::Stack;
use canloop::time::{Duration, Instant};
use hil_sim::scenario::Scenario;
use hil_sim::virtual_robot::VirtualRobot;

/// The system's allocator, which counts what this thread asks of it.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<Option<u64>> = const { Cell::new(None) };
}

fn count() {
    ALLOCATIONS.with(|allocations| allocations.set(allocations.get().map(|so_far| so_far + 1)));
}

// SAFETY: every call goes to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller keeps to what `GlobalAlloc` asks.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps to what `GlobalAlloc` asks.
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller keeps to what `GlobalAlloc` asks.
        unsafe { System.realloc(memory, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Drives and plant right behind the bus; counting starts after a while and
/// the drives fall silent in the end.
struct Direct {
    robot: VirtualRobot,
    clock: Clock,
    answers: VecDeque<Frame>,
    syncs: u32,
    synced_at: Instant,
}

const WARM_UP: u32 = 20;
const SILENT_AFTER: u32 = 150;

impl Bus for Direct {
    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        let now = self.clock.now();
        if self.robot.handle_frame(frame, (now - self.synced_at).as_secs_f64()) {
            self.synced_at = now;
            self.syncs += 1;
            if self.syncs == WARM_UP {
                ALLOCATIONS.with(|allocations| allocations.set(Some(0)));
            }
        }
        while let Some((_, answer)) = self.robot.poll_transmit() {
            if self.syncs < SILENT_AFTER {
                self.answers.push_back(answer);
            }
        }
        Ok(())
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<(Instant, Arrival)>, BusError> {
        if let Some(frame) = self.answers.pop_front() {
            return Ok(Some((self.clock.now(), Arrival::Frame(frame))));
        }
        while self.clock.now() < deadline {
            std::hint::spin_loop();
        }
        Ok(None)
    }
}

/// Remembers the words of the last notice.
struct LastNotice(&'static str);

impl Sink for LastNotice {
    fn event(&mut self, _at: Instant, event: &Event) {
        if let Event::Notice(notice) = event {
            self.0 = notice.text;
        }
    }
}

/// Gives every event to the log's queue and to those who look on.
struct Both(Tap, Feed);

impl Sink for Both {
    fn event(&mut self, at: Instant, event: &Event) {
        self.0.event(at, event);
        self.1.event(at, event);
    }
}

/// A page, where it is built in, and the feed to it of a run of `scenario`.
fn live(scenario: &Scenario, start: Instant) -> (Live, Feed) {
    let page = cfg!(feature = "live").then(|| "127.0.0.1:0".parse().expect("an address"));
    let live = Live::open(&Addresses { page, ..Addresses::default() }).expect("a free port");
    let run = Run {
        name: "watched",
        program: "a test",
        start,
        duration_s: None,
        stack: &scenario.stack,
        bit_rate_bit_s: None,
        contents: &LogContents::default(),
    };
    let feed = live.begin(&run);
    (live, feed)
}

#[test]
fn a_loop_that_runs_and_trips_takes_no_memory_while_somebody_looks_on() {
    let overrides = ["period_s=0.002".to_owned(), "safety.overrun_periods=1000".to_owned()];
    let scenario = Scenario::load("dac-friction", &overrides).expect("a good scenario");
    let clock = Clock::new();
    let start = clock.now() + Duration::from_millis(1);
    let profile = scenario.stack.profile.clone();
    let robot = VirtualRobot::new(profile, scenario.plant(), scenario.drive_spec(), start);
    let mut bus = Direct { robot, clock, answers: VecDeque::with_capacity(64), syncs: 0, synced_at: start };
    let mut stack = Stack::new(&scenario.stack, start);
    stack.operate(Operator::Enable);
    let (events, mut drain) = tap();
    let (_page, feed) = live(&scenario, start);
    let mut events = Both(events, feed);
    let until = start + Duration::from_secs_f64(20.0);
    let end = RealTime::new(stack, &mut bus, &mut events, clock).run(&StopSwitch::new(), until).end;
    let allocations = ALLOCATIONS.with(Cell::take);
    drop(events);
    let mut last = LastNotice("");
    drain.drain_into(&mut last);
    assert!(matches!(end, End::Tripped), "{end:?}: {}", last.0);
    assert!(last.0.contains("no feedback for too long"), "{}", last.0);
    assert_eq!(allocations, Some(0), "allocations in the loop");
    assert_eq!(drain.lost(), 0);
}
