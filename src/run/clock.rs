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

/// Turns stamps of the calendar clock (`CLOCK_REALTIME`, as the kernel stamps
/// frames) into moments, whatever is done to that clock meanwhile.
#[derive(Clone, Debug)]
pub struct RealtimeStamps {
    clock: Clock,
    ahead_nanos: i64,
    /// Stamps for which the clocks' distance is taken as last read.
    trusted_nanos: std::ops::Range<i64>,
}

/// For how long the clocks' distance is trusted: read for every frame, it costs
/// a logger more than the frame.
const TRUSTED_NANOS: i64 = 10_000_000;

impl RealtimeStamps {
    /// Those that become moments of `clock`.
    pub const fn new(clock: Clock) -> Self {
        Self { clock, ahead_nanos: 0, trusted_nanos: 0..0 }
    }

    /// The moment that a stamp means.
    pub fn moment(&mut self, stamp_nanos: i64) -> Instant {
        if !self.trusted_nanos.contains(&stamp_nanos) {
            self.ahead_nanos = realtime_ahead_nanos();
            self.trusted_nanos = stamp_nanos..stamp_nanos.saturating_add(TRUSTED_NANOS);
        }
        Instant::from_nanos(stamp_nanos - self.ahead_nanos + self.clock.offset_nanos)
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
