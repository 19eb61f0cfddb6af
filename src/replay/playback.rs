//! When frames of a log are due that are played onto a bus.

use crate::time::{Duration, Instant};

/// Maps the moments of a log to those of a clock. Each is counted from the
/// beginning, so that what comes late makes nothing after it late.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playback {
    /// When the first frame was in the log.
    first: Instant,
    /// When it is due.
    start: Instant,
    /// How many times as fast as it was.
    speed: f64,
}

impl Playback {
    /// A log whose first frame was at `first`, played from `start` on so many
    /// times as fast as it was.
    pub const fn new(first: Instant, start: Instant, speed: f64) -> Self {
        Self { first, start, speed }
    }

    /// When what was at this moment is due.
    pub fn due(&self, at: Instant) -> Instant {
        let nanos = (at - self.first).as_nanos();
        // A double holds whole nanoseconds for a hundred days.
        let scaled = if self.speed == 1.0 { nanos } else { (nanos as f64 / self.speed).round() as i64 };
        self.start + Duration::from_nanos(scaled)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_counted_from_the_first_and_stretched() {
        let at = Instant::from_nanos;
        let due = |speed| Playback::new(at(1_000), at(50), speed).due(at(1_000 + 1_700_000_000_123_456_789 / 1000));
        assert_eq!(due(1.0), at(50 + 1_700_000_000_123_456));
        assert_eq!(due(2.0), at(50 + 850_000_000_061_728));
        assert_eq!(due(0.5), at(50 + 3_400_000_000_246_912));
    }
}
