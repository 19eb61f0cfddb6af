//! Signals over time, as rows of what they did in equal stretches of it.

use std::collections::VecDeque;

use serde::Serialize;

/// Rows of a strip, at most: more than a chart has pixels to show.
const ROWS: usize = 600;

/// So many rows; when they are full, room is made in its own way.
#[derive(Clone, Debug)]
pub(super) struct Strip {
    when_full: WhenFull,
    /// Time that a row spans, s.
    stretch_s: f64,
    rows: VecDeque<Row>,
    /// The number of the first row: it begins so many stretches after the
    /// run's beginning.
    first: u64,
    /// Counts how often all rows were made anew.
    generation: u32,
}

/// How a strip makes room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WhenFull {
    /// It forgets the oldest row: the last minute.
    Forget,
    /// Two rows become one: the whole run.
    Halve,
}

/// What happened in a stretch of time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct Row {
    /// Distance from the path.
    pub position_error_m: Range,
    pub torque_right_nm: Range,
    pub torque_left_nm: Range,
    /// That crossed the bus.
    pub bits: u64,
}

/// The least and the greatest value of a signal; none where it had none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct Range(Option<(f32, f32)>);

/// What of a strip a viewer has seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct SeenRows {
    generation: Option<u32>,
    /// The first row that may have changed since.
    next: u64,
}

/// Rows that are new to a viewer.
#[derive(Debug, Serialize)]
pub(super) struct NewRows<'s> {
    /// Another one than before: forget all rows.
    generation: u32,
    stretch_s: f64,
    /// The number of the first of these rows.
    first: u64,
    rows: Vec<&'s Row>,
}

impl Strip {
    /// An empty strip.
    pub fn new(when_full: WhenFull, stretch_s: f64) -> Self {
        Self { when_full, stretch_s, rows: VecDeque::with_capacity(ROWS), first: 0, generation: 0 }
    }

    /// The row of this moment. What comes late, or before the beginning, goes
    /// to the nearest row there is.
    pub fn row_mut(&mut self, at_s: f64) -> &mut Row {
        while self.when_full == WhenFull::Halve && at_s >= ROWS as f64 * self.stretch_s {
            self.halve();
        }
        let number = (at_s / self.stretch_s) as u64;
        if number >= self.first + 2 * ROWS as u64 {
            self.rows.clear();
            self.first = number;
        }
        while self.first + self.rows.len() as u64 <= number {
            self.rows.push_back(Row::default());
        }
        while self.rows.len() > ROWS {
            self.rows.pop_front();
            self.first += 1;
        }
        let index = number.saturating_sub(self.first) as usize;
        &mut self.rows[index]
    }

    /// Bits a second in the newest rows that are over, as many as span
    /// `span_s`; none before the first is over.
    pub fn bits_per_s(&self, span_s: f64) -> Option<f64> {
        let rows = ((span_s / self.stretch_s).round() as usize).clamp(1, ROWS);
        let over: Vec<u64> = self.rows.iter().rev().skip(1).take(rows).map(|row| row.bits).collect();
        (!over.is_empty()).then(|| over.iter().sum::<u64>() as f64 / (over.len() as f64 * self.stretch_s))
    }

    /// What is new to a viewer who has seen so much. The last row is new again
    /// next time: it may not be over.
    pub fn news(&self, seen: &mut SeenRows) -> NewRows<'_> {
        if seen.generation != Some(self.generation) {
            *seen = SeenRows { generation: Some(self.generation), next: 0 };
        }
        let first = seen.next.max(self.first);
        let rows: Vec<_> = self.rows.iter().skip((first - self.first) as usize).collect();
        seen.next = (self.first + self.rows.len() as u64).saturating_sub(1);
        NewRows { generation: self.generation, stretch_s: self.stretch_s, first, rows }
    }

    fn halve(&mut self) {
        let rows: Vec<Row> = self.rows.drain(..).collect();
        self.rows = rows.chunks(2).map(|two| two.iter().copied().reduce(Row::and).unwrap_or_default()).collect();
        self.stretch_s *= 2.0;
        self.generation += 1;
    }
}

impl Row {
    fn and(self, other: Self) -> Self {
        Self {
            position_error_m: self.position_error_m.and(other.position_error_m),
            torque_right_nm: self.torque_right_nm.and(other.torque_right_nm),
            torque_left_nm: self.torque_left_nm.and(other.torque_left_nm),
            bits: self.bits + other.bits,
        }
    }
}

impl Range {
    /// Takes a value; what is no number is none.
    pub fn take(&mut self, value: f64) {
        if value.is_finite() {
            *self = self.and(Self(Some((value as f32, value as f32))));
        }
    }

    fn and(self, other: Self) -> Self {
        match (self.0, other.0) {
            (Some((low, high)), Some((other_low, other_high))) => {
                Self(Some((low.min(other_low), high.max(other_high))))
            }
            (one, none) => Self(one.or(none)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(when_full: WhenFull, rows: u64) -> Strip {
        let mut strip = Strip::new(when_full, 0.1);
        for number in 0..rows {
            let row = strip.row_mut((number as f64 + 0.5) * 0.1);
            row.position_error_m.take(number as f64);
            row.bits += 10;
        }
        strip
    }

    #[test]
    fn a_strip_that_forgets_keeps_the_newest_rows() {
        let strip = filled(WhenFull::Forget, 1000);
        assert_eq!((strip.rows.len(), strip.first), (ROWS, 400));
        assert_eq!(strip.rows[0].position_error_m, Range(Some((400.0, 400.0))));
    }

    #[test]
    fn a_strip_that_halves_keeps_the_whole_run_and_every_spike() {
        let strip = filled(WhenFull::Halve, 1000);
        assert_eq!((strip.rows.len(), strip.first, strip.generation), (500, 0, 1));
        assert_eq!(strip.rows[0].position_error_m, Range(Some((0.0, 1.0))));
        assert_eq!(strip.rows[499].position_error_m, Range(Some((998.0, 999.0))));
        assert_eq!(strip.rows.iter().map(|row| row.bits).sum::<u64>(), 10_000);
    }

    #[test]
    fn a_viewer_is_told_each_row_once_and_the_last_one_until_it_is_over() {
        let mut strip = filled(WhenFull::Forget, 3);
        let mut seen = SeenRows::default();
        let told = |news: NewRows<'_>| (news.first, news.rows.len());
        assert_eq!(told(strip.news(&mut seen)), (0, 3));
        assert_eq!(told(strip.news(&mut seen)), (2, 1));
        strip.row_mut(0.45);
        assert_eq!(told(strip.news(&mut seen)), (2, 3));
    }

    #[test]
    fn a_viewer_who_was_away_for_long_is_told_what_there_still_is() {
        let mut strip = filled(WhenFull::Forget, 3);
        let mut seen = SeenRows::default();
        strip.news(&mut seen);
        strip.row_mut(100.0);
        let news = strip.news(&mut seen);
        assert_eq!((news.first, news.rows.len()), (401, ROWS));
        strip.row_mut(1e6);
        assert_eq!((strip.rows.len(), strip.first), (1, 10_000_000));
        let mut whole = filled(WhenFull::Halve, 3);
        let mut seen = SeenRows::default();
        whole.news(&mut seen);
        whole.row_mut(1e6);
        assert_eq!(whole.news(&mut seen).first, 0);
        assert!(whole.rows.len() <= ROWS && whole.generation > 10);
    }

    #[test]
    fn a_moment_before_the_beginning_or_long_ago_goes_to_the_nearest_row() {
        let mut strip = filled(WhenFull::Forget, 1000);
        strip.row_mut(-5.0).bits += 1;
        assert_eq!(strip.rows[0].bits, 11);
    }

    #[test]
    fn the_load_is_that_of_rows_that_are_over() {
        let mut strip = filled(WhenFull::Forget, 30);
        strip.row_mut(2.95).bits += 1_000_000;
        assert_eq!(strip.bits_per_s(1.0).map(f64::round), Some(100.0));
        assert_eq!(Strip::new(WhenFull::Forget, 0.1).bits_per_s(1.0), None);
    }

    #[test]
    fn what_is_no_number_is_no_value() {
        let mut range = Range::default();
        [f64::NAN, f64::INFINITY].into_iter().for_each(|value| range.take(value));
        assert_eq!(range, Range(None));
        [2.0, f64::NAN, -1.0].into_iter().for_each(|value| range.take(value));
        assert_eq!(range, Range(Some((-1.0, 2.0))));
        assert_eq!(serde_json::to_string(&Range(None)).unwrap(), "null");
    }
}
