//! How one message came: how often, how regularly, how long.

use super::sample::Sample;
use crate::frame::{CanId, FrameKind};
use crate::time::{Duration, Instant};
use crate::traffic::{Direction, Record, RecordedFrame};

/// Of more messages than these no periods are kept: they are those of a
/// damaged log, or of somebody who tried all ids.
pub(super) const MOST_WITH_PERIODS: usize = 2048;

/// Frames of one id on one bus.
pub struct Message {
    /// The id.
    pub id: CanId,
    /// Frames.
    pub count: u64,
    /// Of those, the ones that the one who logged sent.
    pub sent: u64,
    /// Of those, remote requests.
    pub remote: u64,
    /// Of those, CAN FD frames.
    pub fd: u64,
    /// Least and greatest number of bytes.
    pub lengths: (usize, usize),
    first: Option<Instant>,
    latest: Option<Instant>,
    /// From each frame to the next.
    periods: Option<Sample>,
    /// The longest of them, and when it began.
    pub longest_gap: Option<(Duration, Instant)>,
}

/// Figures of the periods of a message, s.
#[derive(Clone, Copy, Debug)]
pub struct Periods {
    /// The median.
    pub median_s: f64,
    /// All but the hundredth shortest and longest lie within so much.
    pub jitter_s: f64,
}

impl Message {
    /// Without a frame yet.
    pub fn new(id: CanId, with_periods: bool) -> Self {
        let (lengths, periods) = ((usize::MAX, 0), with_periods.then(Sample::default));
        Self { id, count: 0, sent: 0, remote: 0, fd: 0, lengths, first: None, latest: None, periods, longest_gap: None }
    }

    /// Takes one of its frames into account.
    pub fn add(&mut self, record: &Record, recorded: &RecordedFrame) {
        let len = recorded.frame.len();
        self.count += 1;
        self.sent += u64::from(record.direction == Direction::Sent);
        self.remote += u64::from(recorded.frame.kind == FrameKind::Remote);
        self.fd += u64::from(recorded.is_fd());
        self.lengths = (self.lengths.0.min(len), self.lengths.1.max(len));
        self.first.get_or_insert(record.at);
        if let Some(before) = self.latest.replace(record.at) {
            self.add_period(record.at - before, before);
        }
    }

    /// Median and jitter; `None` before the third frame.
    pub fn periods(&self) -> Option<Periods> {
        let periods = self.periods.as_ref().filter(|_| self.count > 2)?.sorted();
        let at = |share: f64| {
            let index = (share * (periods.len() - 1) as f64).round() as usize;
            Duration::from_nanos(periods[index]).as_secs_f64()
        };
        Some(Periods { median_s: at(0.5), jitter_s: at(0.99) - at(0.01) })
    }

    /// The mean period, s; 0 of a single frame.
    pub fn mean_period_s(&self) -> f64 {
        let (Some(first), Some(latest)) = (self.first, self.latest) else { return 0.0 };
        (latest - first).as_secs_f64() / (self.count.max(2) - 1) as f64
    }

    /// What sort of frames they were.
    pub const fn kind(&self) -> &'static str {
        match (self.remote, self.fd) {
            (0, 0) => "data",
            (0, fd) if fd == self.count => "fd",
            (remote, 0) if remote == self.count => "remote",
            _ => "mixed",
        }
    }

    fn add_period(&mut self, period: Duration, before: Instant) {
        if let Some(periods) = &mut self.periods {
            periods.add(period.as_nanos());
        }
        if self.longest_gap.is_none_or(|(longest, _)| period > longest) {
            self.longest_gap = Some((period, before));
        }
    }
}
