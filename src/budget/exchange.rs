//! The bounds of the exchange and of each message, which depend on each other:
//! raised from below until they agree.

use super::response::{Stream, fixed_point, work, worst_case_response};
use super::{Row, Terms, bits};
use crate::schema::Cause;
use crate::time::Duration;

/// Bounds that have not agreed after so many rounds are none.
const ROUNDS: u32 = 200;

/// How a drive's frames wait that are ready at the same time.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Queue {
    /// The most urgent is sent first.
    Sorted,
    /// The first to come is sent first.
    InTurn,
}

/// How long the exchange can take, whatever the drives' queues are like, and
/// each of `rows` where they send the most urgent frame first. The stack's rows
/// stand in the order in which it queues them.
pub(super) fn bounds(rows: &[Row], terms: &Terms) -> (Option<Duration>, Vec<Option<Duration>>) {
    let own = |row: &Row| Some(delay(row, terms) + row.transmission);
    let mut bounds = Bounds { rows, terms, exchange: Some(Duration::ZERO), in_turn: rows.iter().map(own).collect() };
    for _ in 0..ROUNDS {
        let next = Bounds { exchange: bounds.exchange(), in_turn: bounds.responses(Queue::InTurn), ..bounds };
        if (next.exchange, &next.in_turn) == (bounds.exchange, &bounds.in_turn) {
            return (next.exchange, next.responses(Queue::Sorted));
        }
        bounds = next;
    }
    (None, bounds.responses(Queue::Sorted))
}

/// How late after the moment that it is due a frame is queued.
fn delay(row: &Row, terms: &Terms) -> Duration {
    if row.is_stack_s() { terms.lateness } else { terms.answer }
}

/// What the bounds are so far.
struct Bounds<'b> {
    rows: &'b [Row],
    terms: &'b Terms,
    exchange: Option<Duration>,
    /// Each row's response where drives send what came first.
    in_turn: Vec<Option<Duration>>,
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
            let mut of_step = self.rows.iter().zip(&self.in_turn).filter(|(row, _)| row.cause == cause);
            let slowest = of_step.try_fold(Duration::ZERO, |slowest, (_, response)| Some(slowest.max((*response)?)))?;
            Some(sum + slowest)
        })
    }

    const fn steps(&self) -> [Cause; 3] {
        [Cause::Beginning, Cause::Asked, Cause::Answered]
    }

    fn responses(&self, drives: Queue) -> Vec<Option<Duration>> {
        (0..self.rows.len()).map(|index| self.response(index, drives)).collect()
    }

    fn response(&self, index: usize, drives: Queue) -> Option<Duration> {
        let row = &self.rows[index];
        let queued_before = |other: usize| match (row.is_stack_s(), drives) {
            (true, _) => other < index && self.rows[other].cause == row.cause,
            (false, Queue::InTurn) => other != index && self.rows[other].sender == row.sender,
            (false, Queue::Sorted) => false,
        };
        // Waiting behind a frame of lower priority is waiting with its priority.
        let all = 0..self.rows.len();
        let ahead = all.filter(|&other| queued_before(other)).map(|other| self.rows[other].order());
        let level = ahead.fold(row.order(), u64::max);
        let mut blocking = Duration::ZERO;
        let mut before = Vec::new();
        for (other, frame) in self.rows.iter().enumerate().filter(|&(other, _)| other != index) {
            if frame.order() < level || queued_before(other) {
                before.push(self.seen_by(row, other, drives));
            } else {
                blocking = blocking.max(frame.transmission);
            }
        }
        let own = Stream { transmission: row.transmission, period: row.period, jitter: delay(row, self.terms) };
        worst_case_response(&own, blocking, &before, self.bit())
    }

    /// Another message as it is in the way of `row`.
    fn seen_by(&self, row: &Row, other: usize, drives: Queue) -> Stream {
        let frame = &self.rows[other];
        let jitter = match (row.is_of_exchange(), frame.is_of_exchange()) {
            (false, true) => self.within_exchange(frame),
            // An earlier one may still be waiting when the exchange begins.
            (true, false) => self.waiting(other),
            // It gets to the head of its queue so late.
            (false, false) if drives == Queue::InTurn => self.waiting(other),
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
            jitter: self.waiting(index),
        })
    }

    /// How long a row may have been due and not be through; the next one takes
    /// its place.
    fn waiting(&self, index: usize) -> Duration {
        let period = self.rows[index].period;
        self.in_turn[index].map_or(period, |response| response.min(period))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{CanId, FrameKind};

    fn row(id: u16, cause: Cause, transmission_us: i64, period_us: i64) -> Row {
        let [transmission, period] = [transmission_us, period_us].map(Duration::from_micros);
        let (name, sender) = (String::new(), String::new());
        let id = CanId::Standard(id);
        Row { id, kind: FrameKind::Classic, cause, name, sender, bytes: 8, period, transmission, response: None }
    }

    fn bounds_us(rows: &[Row]) -> (Option<i64>, Vec<Option<i64>>) {
        let terms = Terms {
            period: rows[0].period,
            bit_rate_bit_s: 1_000_000,
            lateness: Duration::ZERO,
            answer: Duration::ZERO,
        };
        let micros = |time: Duration| time.as_nanos() / 1_000;
        let (exchange, responses) = bounds(rows, &terms);
        (exchange.map(micros), responses.into_iter().map(|response| response.map(micros)).collect())
    }

    #[test]
    fn what_drives_send_by_their_own_clocks_may_meet_two_exchanges_in_a_row() {
        let rows = [row(1, Cause::Beginning, 700, 1_000), row(2, Cause::OwnClock, 300, 100_000)];
        assert_eq!(bounds_us(&rows), (Some(1_000), vec![Some(1_000), Some(2 * 700 + 300)]));
        let slower = [row(1, Cause::Beginning, 700, 2_000), row(2, Cause::OwnClock, 300, 100_000)];
        assert_eq!(bounds_us(&slower), (Some(1_000), vec![Some(1_000), Some(700 + 300)]));
    }

    #[test]
    fn what_is_still_waiting_when_an_exchange_begins_is_in_its_way() {
        // The status can have waited for 300 us then, and the next one comes.
        let rows = [row(2, Cause::Beginning, 300, 4_000), row(1, Cause::OwnClock, 400, 1_000)];
        assert_eq!(bounds_us(&rows), (Some(300 + 2 * 400), vec![Some(2 * 400 + 300), Some(300 + 400)]));
    }

    #[test]
    fn the_exchange_is_prepared_for_drives_that_send_first_what_came_first() {
        let clock = |id, period_us| row(id, Cause::OwnClock, 100, period_us);
        let rows = [row(3, Cause::Beginning, 100, 2_000), clock(1, 700), clock(2, 100_000), clock(4, 100_000)];
        let (exchange, responses) = bounds_us(&rows);
        // Sorted, the most urgent waits for one frame only; in turn for all, so
        // that two of it can be in the exchange's way.
        assert_eq!((exchange, responses[1]), (Some(500), Some(200)));
    }

    #[test]
    fn steps_of_an_exchange_are_counted_once_each() {
        let causes = [Cause::Beginning, Cause::Asked, Cause::Answered];
        let rows = causes.map(|cause| row(1 + cause as u16, cause, 100, 2_000));
        assert_eq!(bounds_us(&rows).0, Some(300));
    }
}
