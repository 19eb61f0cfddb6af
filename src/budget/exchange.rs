//! The bounds of the exchange and of each message, which depend on each other:
//! raised from below until they agree.

use super::response::{Stream, fixed_point, work, worst_case_response};
use super::{Row, Terms, bits};
use crate::schema::Cause;
use crate::time::Duration;

/// Bounds that have not agreed after so many rounds are none.
const ROUNDS: u32 = 200;

/// How long the exchange and each of `rows` can take. The stack's rows stand in
/// the order in which it queues them.
pub(super) fn bounds(rows: &[Row], terms: &Terms) -> (Option<Duration>, Vec<Option<Duration>>) {
    let own = |row: &Row| Some(delay(row, terms) + row.transmission);
    let mut exchange = Some(Duration::ZERO);
    let mut responses: Vec<_> = rows.iter().map(own).collect();
    for _ in 0..ROUNDS {
        let bounds = Bounds { rows, terms, exchange, responses: &responses };
        let next = (bounds.exchange(), (0..rows.len()).map(|index| bounds.response(index)).collect::<Vec<_>>());
        if next == (exchange, responses.clone()) {
            return next;
        }
        (exchange, responses) = next;
    }
    (None, responses)
}

/// How late after the moment that it is due a frame is queued.
fn delay(row: &Row, terms: &Terms) -> Duration {
    if row.is_stack_s() { terms.lateness } else { terms.answer }
}

/// What the bounds were in the last round.
struct Bounds<'b> {
    rows: &'b [Row],
    terms: &'b Terms,
    exchange: Option<Duration>,
    responses: &'b [Option<Duration>],
}

impl Bounds<'_> {
    fn exchange(&self) -> Option<Duration> {
        match (self.by_work(), self.by_steps()) {
            (Some(by_work), Some(by_steps)) => Some(by_work.min(by_steps)),
            (one, other) => one.or(other),
        }
    }

    /// The frames of the exchange once each, and all that others can have to
    /// send from the beginning to the end of it.
    fn by_work(&self) -> Option<Duration> {
        let steps = self.steps().map(|cause| self.rows.iter().find(|row| row.cause == cause));
        let waiting =
            steps.into_iter().flatten().map(|row| delay(row, self.terms)).fold(Duration::ZERO, std::ops::Add::add);
        let of_exchange = self.rows.iter().filter(|row| row.is_of_exchange());
        let frames = of_exchange.fold(waiting, |sum, row| sum + row.transmission);
        let others: Vec<Stream> = self.unasked().collect();
        let load: f64 = others.iter().map(Stream::load).sum();
        if load >= 1.0 { None } else { fixed_point(frames, |span| frames + work(&others, span + self.bit())) }
    }

    /// The slowest message of each step, one step after the other.
    fn by_steps(&self) -> Option<Duration> {
        self.steps().into_iter().try_fold(Duration::ZERO, |sum, cause| {
            let mut of_step = self.rows.iter().zip(self.responses).filter(|(row, _)| row.cause == cause);
            let slowest = of_step.try_fold(Duration::ZERO, |slowest, (_, response)| Some(slowest.max((*response)?)))?;
            Some(sum + slowest)
        })
    }

    const fn steps(&self) -> [Cause; 3] {
        [Cause::Beginning, Cause::Asked, Cause::Answered]
    }

    fn response(&self, index: usize) -> Option<Duration> {
        let row = &self.rows[index];
        let queued_before = |other: usize| other < index && row.is_stack_s() && self.rows[other].cause == row.cause;
        // Waiting behind a frame of lower priority is waiting with its priority.
        let ahead = (0..index).filter(|&other| queued_before(other)).map(|other| self.rows[other].order());
        let level = ahead.fold(row.order(), u64::max);
        let mut blocking = Duration::ZERO;
        let mut before = Vec::new();
        for (other, frame) in self.rows.iter().enumerate().filter(|&(other, _)| other != index) {
            if frame.order() < level || queued_before(other) {
                before.push(self.seen_by(row, other));
            } else {
                blocking = blocking.max(frame.transmission);
            }
        }
        let own = Stream { transmission: row.transmission, period: row.period, jitter: delay(row, self.terms) };
        worst_case_response(&own, blocking, &before, self.bit())
    }

    /// Another message as it is in the way of `row`.
    fn seen_by(&self, row: &Row, other: usize) -> Stream {
        let frame = &self.rows[other];
        let jitter = match (row.is_of_exchange(), frame.is_of_exchange()) {
            (false, true) => self.within_exchange(frame),
            // An earlier one may still be waiting when the exchange begins.
            (true, false) => self.responses[other].map_or(frame.period, |response| response.min(frame.period)),
            _ => delay(frame, self.terms),
        };
        Stream { transmission: frame.transmission, period: frame.period, jitter }
    }

    /// What drives send by their own clocks, as the exchange sees it.
    fn unasked(&self) -> impl Iterator<Item = Stream> {
        let unasked = self.rows.iter().enumerate().filter(|(_, frame)| !frame.is_of_exchange());
        unasked.map(|(index, frame)| Stream {
            transmission: frame.transmission,
            period: frame.period,
            jitter: self.responses[index].map_or(frame.period, |response| response.min(frame.period)),
        })
    }

    /// A message of the exchange is queued somewhere between the beginning of
    /// the exchange and the last moment at which it can still be sent in it.
    /// What has not left when the next period begins is given up.
    fn within_exchange(&self, frame: &Row) -> Duration {
        let exchange = self.exchange.map_or(self.terms.period, |exchange| exchange.min(self.terms.period));
        (exchange - frame.transmission).max(delay(frame, self.terms))
    }

    fn bit(&self) -> Duration {
        bits(1, self.terms.bit_rate_bit_s)
    }
}
