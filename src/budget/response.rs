//! The response-time analysis for CAN of Davis, Burns, Bril and Lukkien,
//! "Controller Area Network (CAN) schedulability analysis: Refuted, revisited
//! and revised", Real-Time Systems 35 (2007), 239-272, section 3.
//!
//! The exact one: of message m, all instances in the busy period of its level
//! are looked at, not only the first, because one that has waited can make the
//! next wait longer (the paper's section 4 has the example). In the paper's
//! symbols, `hp(m)` being the messages with a higher priority than m:
//!
//! ```text
//! t_m     = B_m + sum over hp(m) and m of ceil((t_m + J_k) / T_k) C_k       busy period
//! Q_m     = ceil((t_m + J_m) / T_m)                                         instances in it
//! w_m(q)  = B_m + q C_m + sum over hp(m) of ceil((w_m + J_k + tau_bit) / T_k) C_k
//! R_m     = max over q < Q_m of J_m + w_m(q) - q T_m + C_m
//! ```
//!
//! `t_m` and `w_m` are the least solutions, found by iteration from below.

use crate::time::Duration;

/// A message as the analysis sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stream {
    /// C: for how long it occupies the bus at most.
    pub transmission: Duration,
    /// T: the least time between two events that make its sender send it.
    pub period: Duration,
    /// J: how long after that event it is queued, at most.
    pub jitter: Duration,
}

/// Busy periods that last longer are taken to last for ever.
const FOR_EVER: Duration = Duration::from_millis(60_000);

/// R of each of `streams`, which are given from the highest priority to the
/// lowest; nothing for those that can be kept waiting for ever. `bit` is the
/// time of a bit, the paper's tau.
pub fn worst_case_responses(streams: &[Stream], bit: Duration) -> Vec<Option<Duration>> {
    let response = |(index, own): (usize, &Stream)| {
        let lower = streams[index + 1..].iter().map(|stream| stream.transmission);
        worst_case_response(own, lower.max().unwrap_or_default(), &streams[..index], bit)
    };
    streams.iter().enumerate().map(response).collect()
}

/// R of one message, counted from the event that makes its sender send it:
/// `blocking` is B, the longest frame that may just have won the bus, and
/// `before` those that go before it. Nothing when it can be kept waiting for
/// ever.
pub fn worst_case_response(own: &Stream, blocking: Duration, before: &[Stream], bit: Duration) -> Option<Duration> {
    let load: f64 = before.iter().chain([own]).map(Stream::load).sum();
    if load >= 1.0 {
        return None;
    }
    let busy = fixed_point(own.transmission, |busy| {
        blocking + work(before, busy) + own.transmission * own.instances_within(busy)
    })?;
    let mut waiting = Duration::ZERO;
    let mut worst = Duration::ZERO;
    for instance in 0..own.instances_within(busy) {
        let first = blocking + own.transmission * instance;
        waiting = fixed_point(waiting.max(first), |waiting| first + work(before, waiting + bit))?;
        let since_event = own.jitter + waiting + own.transmission;
        worst = worst.max(since_event - own.period * instance);
    }
    Some(worst)
}

/// The least time that `next` leaves as it is, at or after `from`, which must
/// not lie beyond it; nothing when there is none worth waiting for.
pub(super) fn fixed_point(from: Duration, next: impl Fn(Duration) -> Duration) -> Option<Duration> {
    let mut now = from;
    while now <= FOR_EVER {
        let then = next(now);
        if then <= now {
            return Some(now);
        }
        now = then;
    }
    None
}

/// Time on the bus of all that is queued within `window`.
pub(super) fn work(streams: &[Stream], window: Duration) -> Duration {
    let of = |stream: &Stream| stream.transmission * stream.instances_within(window);
    streams.iter().fold(Duration::ZERO, |sum, stream| sum + of(stream))
}

impl Stream {
    /// The share of the bus's time that it takes.
    pub(super) fn load(&self) -> f64 {
        self.transmission.as_secs_f64() / self.period.as_secs_f64()
    }

    /// How often it can be queued within `window`, which begins when it is.
    fn instances_within(&self, window: Duration) -> i64 {
        let span = (window + self.jitter).as_nanos();
        let period = self.period.as_nanos();
        span / period + i64::from(span % period > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 8 us: a bit at 125 kbit/s.
    const BIT: Duration = Duration::from_micros(8);

    fn stream(transmission_us: i64, period_us: i64, jitter_us: i64) -> Stream {
        let [transmission, period, jitter] = [transmission_us, period_us, jitter_us].map(Duration::from_micros);
        Stream { transmission, period, jitter }
    }

    fn responses_us(streams: &[Stream]) -> Vec<Option<i64>> {
        let of = |response: Duration| response.as_nanos() / 1_000;
        worst_case_responses(streams, BIT).into_iter().map(|response| response.map(of)).collect()
    }

    #[test]
    fn the_paper_s_example_comes_out_where_the_original_analysis_was_wrong() {
        // Table 3: 7 bytes are 125 bits, 1 ms. The second instance of the last
        // message waits longer than the first, whose 3.0 ms were thought to be
        // the worst.
        let streams = [stream(1_000, 2_500, 0), stream(1_000, 3_500, 0), stream(1_000, 3_500, 0)];
        assert_eq!(responses_us(&streams), [Some(2_000), Some(3_000), Some(3_500)]);
    }

    #[test]
    fn jitter_counts_for_oneself_and_makes_others_come_twice() {
        let alone = [stream(1_000, 10_000, 300)];
        assert_eq!(responses_us(&alone), [Some(1_300)]);
        let pushed = [stream(1_000, 4_000, 3_500), stream(1_000, 20_000, 0)];
        assert_eq!(responses_us(&pushed)[1], Some(3_000));
    }

    #[test]
    fn a_level_that_needs_the_whole_bus_waits_for_ever() {
        let streams = [stream(1_000, 2_000, 0), stream(1_000, 2_000, 0), stream(1_000, 9_000, 0)];
        assert_eq!(responses_us(&streams), [Some(2_000), None, None]);
    }

    #[test]
    fn a_frame_queued_within_the_last_bit_still_goes_first() {
        // Waits 2 ms; the next of the first message comes 4 us later.
        let streams = [stream(1_000, 2_004, 0), stream(1_000, 50_000, 0), stream(1_000, 50_000, 0)];
        assert_eq!(responses_us(&streams)[1], Some(4_000));
    }
}
