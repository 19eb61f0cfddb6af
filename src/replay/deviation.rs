//! By how much the signals of a replayed stack deviate from the recorded ones.

use std::collections::VecDeque;

use crate::event::{Event, Sink, Tick};
use crate::time::Instant;

/// How one signal of the stack fared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// By how much it may differ.
    pub tolerance: f64,
    /// The most by which it differs.
    pub most: f64,
    /// In which period that is.
    pub most_tick: u64,
    /// The first period in which it differs at all.
    pub first_tick: Option<u64>,
    /// The first period in which it differs by more than its tolerance.
    pub beyond_tick: Option<u64>,
}

/// Compares the ticks of two stacks, signal by signal.
///
/// What the replayed one tells comes in as events, what the recorded one told
/// through [`Self::recorded`]; of each tick the replayed one comes first.
#[derive(Clone, Debug)]
pub struct Deviations {
    /// In the order of [`Tick::NAMES`].
    signals: [Deviation; Tick::NAMES.len()],
    replayed: VecDeque<[f64; Tick::NAMES.len()]>,
    compared: u64,
}

impl Deviations {
    /// Nothing compared yet. `tolerance` says by how much each signal may differ.
    pub fn new(tolerance: impl Fn(&str) -> f64) -> Self {
        let signals = Tick::NAMES.map(|name| Deviation { tolerance: tolerance(name), ..Deviation::default() });
        Self { signals, replayed: VecDeque::new(), compared: 0 }
    }

    /// Takes a tick of the recorded stack, as in [`Tick::values`]; gives back
    /// that of the replayed one, if there is one.
    pub fn recorded(&mut self, recorded: &[f64; Tick::NAMES.len()]) -> Option<[f64; Tick::NAMES.len()]> {
        let tick = recorded[0];
        while self.replayed.front().is_some_and(|replayed| replayed[0] < tick) {
            self.replayed.pop_front();
        }
        let replayed = self.replayed.front().copied().filter(|replayed| replayed[0] == tick)?;
        self.replayed.pop_front();
        self.compared += 1;
        for ((signal, recorded), replayed) in self.signals.iter_mut().zip(recorded).zip(&replayed) {
            signal.take(tick as u64, *recorded, *replayed);
        }
        Some(replayed)
    }

    /// How each signal fared, with its name.
    pub fn signals(&self) -> impl Iterator<Item = (&'static str, &Deviation)> {
        Tick::NAMES.into_iter().zip(&self.signals)
    }

    /// Ticks compared.
    pub const fn compared(&self) -> u64 {
        self.compared
    }
}

impl Sink for Deviations {
    fn event(&mut self, _at: Instant, event: &Event) {
        if let Event::Tick(tick) = event {
            self.replayed.push_back(tick.values());
        }
    }
}

impl Deviation {
    fn take(&mut self, tick: u64, recorded: f64, replayed: f64) {
        let by = (replayed - recorded).abs();
        // Two that are no numbers are the same; one that is and one that is not differ without measure.
        let by = match (recorded.is_nan(), replayed.is_nan()) {
            (true, true) => 0.0,
            (false, false) => by,
            _ => f64::INFINITY,
        };
        if by > 0.0 {
            self.first_tick.get_or_insert(tick);
        }
        if by > self.tolerance {
            self.beyond_tick.get_or_insert(tick);
        }
        if by > self.most {
            (self.most, self.most_tick) = (by, tick);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(tick: u64, state: u8) -> Tick {
        Tick { tick, state, ..Tick::default() }
    }

    #[test]
    fn a_signal_is_followed_to_its_first_and_its_largest_deviation() {
        let mut deviations = Deviations::new(|name| if name == "state" { 1.0 } else { 0.0 });
        for (nth, state) in [3, 3, 4, 6, 5].into_iter().enumerate() {
            deviations.event(Instant::ZERO, &Event::Tick(tick(nth as u64, state)));
            deviations.recorded(&tick(nth as u64, 3).values());
        }
        let (_, state) = deviations.signals().find(|(name, _)| *name == "state").expect("there is one");
        let expected = Deviation { tolerance: 1.0, most: 3.0, most_tick: 3, first_tick: Some(2), beyond_tick: Some(3) };
        assert_eq!((*state, deviations.compared()), (expected, 5));
        assert!(deviations.signals().filter(|(name, _)| *name != "state").all(|(_, other)| other.first_tick.is_none()));
    }

    #[test]
    fn ticks_are_matched_by_their_number() {
        let mut deviations = Deviations::new(|_| 0.0);
        for nth in [1, 2, 4] {
            deviations.event(Instant::ZERO, &Event::Tick(tick(nth, 3)));
        }
        let found = [0, 2, 3, 4].map(|nth| deviations.recorded(&tick(nth, 3).values()).is_some());
        assert_eq!(found, [false, true, false, true]);
    }
}
