//! The clock of a runtime.

use rustix::time::{ClockId, Timespec, clock_gettime};

use crate::time::Instant;

/// Moments as Unix time that never jumps: the monotonic clock, set once by the
/// calendar clock.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    /// What the calendar clock was ahead of the monotonic clock at the start.
    offset_nanos: i64,
}

impl Clock {
    /// A clock that shows the right time now.
    pub fn new() -> Self {
        Self { offset_nanos: realtime_ahead_nanos() }
    }

    /// The present moment.
    pub fn now(&self) -> Instant {
        Instant::from_nanos(nanos(clock_gettime(ClockId::Monotonic)) + self.offset_nanos)
    }

    /// The moment that a stamp of the calendar clock (`CLOCK_REALTIME`, as the
    /// kernel stamps frames) means, whatever has been done to that clock since
    /// the start.
    pub fn from_realtime_nanos(&self, stamp_nanos: i64) -> Instant {
        Instant::from_nanos(stamp_nanos - realtime_ahead_nanos() + self.offset_nanos)
    }

    /// The moment as the kernel wants it for an absolute wait on
    /// `CLOCK_MONOTONIC`.
    pub fn to_monotonic(&self, at: Instant) -> Timespec {
        let nanos = (at.as_nanos() - self.offset_nanos).max(0);
        Timespec { tv_sec: nanos / 1_000_000_000, tv_nsec: nanos % 1_000_000_000 }
    }
}

impl Default for Clock {
    fn default() -> Self {
        Self::new()
    }
}

/// What the calendar clock is ahead of the monotonic clock: read between two
/// readings of the other, again if the thread was held up in between.
fn realtime_ahead_nanos() -> i64 {
    const TRIES: u32 = 5;
    const UNDISTURBED_NANOS: i64 = 2_000;
    let mut best = (i64::MAX, 0);
    for _ in 0..TRIES {
        let before = nanos(clock_gettime(ClockId::Monotonic));
        let realtime = nanos(clock_gettime(ClockId::Realtime));
        let after = nanos(clock_gettime(ClockId::Monotonic));
        if after - before < best.0 {
            best = (after - before, realtime - before - (after - before) / 2);
        }
        if best.0 < UNDISTURBED_NANOS {
            break;
        }
    }
    best.1
}

fn nanos(time: Timespec) -> i64 {
    time.tv_sec * 1_000_000_000 + time.tv_nsec
}
