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
        Self { offset_nanos: nanos(clock_gettime(ClockId::Realtime)) - nanos(clock_gettime(ClockId::Monotonic)) }
    }

    /// The present moment.
    pub fn now(&self) -> Instant {
        Instant::from_nanos(nanos(clock_gettime(ClockId::Monotonic)) + self.offset_nanos)
    }

    /// The moment that a stamp of the calendar clock (`CLOCK_REALTIME`, as the
    /// kernel stamps frames) means, whatever has been done to that clock since
    /// the start.
    pub fn from_realtime_nanos(&self, stamp_nanos: i64) -> Instant {
        let ago_nanos = nanos(clock_gettime(ClockId::Realtime)) - stamp_nanos;
        Instant::from_nanos(self.now().as_nanos() - ago_nanos)
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

fn nanos(time: Timespec) -> i64 {
    time.tv_sec * 1_000_000_000 + time.tv_nsec
}
