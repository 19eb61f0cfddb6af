//! Between what a value must lie.

use canloop::safety::{Reason, State};

/// A lower and an upper bound, both included; a bound that is not given holds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    /// Lower bound.
    pub min: Option<f64>,
    /// Upper bound.
    pub max: Option<f64>,
}

/// Numbers of states from here on stand for trips.
const FIRST_TRIP: u8 = 10;

impl Bounds {
    /// The numbers of the state with this name: a state, `tripped` for any
    /// trip, or the name of a reason to trip.
    pub fn of_state(name: &str) -> Option<Self> {
        let only = |code: u8| Self { min: Some(f64::from(code)), max: Some(f64::from(code)) };
        if name == "tripped" {
            return Some(Self { min: Some(f64::from(FIRST_TRIP)), max: None });
        }
        let state = UNTRIPPED.into_iter().find(|state| state.name() == name);
        let trip = Reason::ALL.into_iter().find(|reason| reason.name() == name).map(State::Tripped);
        state.or(trip).map(|state| only(state.code()))
    }

    /// All names that [`Self::of_state`] knows.
    pub fn state_names() -> impl Iterator<Item = &'static str> {
        let states = UNTRIPPED.into_iter().map(State::name);
        states.chain(["tripped"]).chain(Reason::ALL.into_iter().map(Reason::name))
    }

    /// How far inside the bounds a value is; negative when outside. What is no
    /// number is outside, as far as can be.
    pub fn margin(&self, value: f64) -> f64 {
        let above = self.min.map_or(f64::INFINITY, |min| value - min);
        let below = self.max.map_or(f64::INFINITY, |max| max - value);
        if value.is_finite() { above.min(below) } else { f64::NEG_INFINITY }
    }

    /// `0.0013 too high`, for a value outside.
    pub fn excess(&self, value: f64) -> String {
        let margin = -self.margin(value);
        match self.max {
            _ if !value.is_finite() => "no finite number".to_owned(),
            Some(max) if value > max => format!("{} too high", brief(margin)),
            _ => format!("{} too low", brief(margin)),
        }
    }
}

/// A value with as many digits as people want to read.
pub(super) fn brief(value: f64) -> String {
    let size = value.abs();
    match size {
        _ if !value.is_finite() || value == 0.0 => value.to_string(),
        size if !(1e-6..1e9).contains(&size) => format!("{value:.3e}"),
        _ => {
            let digits = format!("{value:.6}");
            digits.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
    }
}

/// The name of the state with this number.
pub(super) fn state_name(code: f64) -> &'static str {
    let known = UNTRIPPED.into_iter().chain(Reason::ALL.into_iter().map(State::Tripped));
    let found = known.into_iter().find(|state| f64::from(state.code()) == code);
    match found {
        Some(State::Tripped(reason)) => reason.name(),
        Some(state) => state.name(),
        None => "unknown",
    }
}

const UNTRIPPED: [State; 5] = [State::Boot, State::Stopped, State::Enabling, State::Running, State::Stopping];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_state_and_every_reason_has_a_name_of_its_own_and_bounds() {
        let names: Vec<_> = Bounds::state_names().collect();
        for (nth, name) in names.iter().enumerate() {
            let bounds = Bounds::of_state(name).expect("a known name");
            assert!(!names[..nth].contains(name), "{name} twice");
            assert!(*name == "tripped" || state_name(bounds.min.expect("a number")) == *name, "{name}");
        }
        let tripped = Bounds::of_state("tripped").expect("known");
        assert!(Reason::ALL.into_iter().all(|reason| tripped.margin(f64::from(State::Tripped(reason).code())) >= 0.0));
        assert!(UNTRIPPED.into_iter().all(|state| tripped.margin(f64::from(state.code())) < 0.0));
    }

    #[test]
    fn bounds_are_included_and_no_number_is_inside() {
        let bounds = Bounds { min: Some(-1.0), max: Some(2.0) };
        assert_eq!([-1.0, 2.0, 0.0, 2.5].map(|value| bounds.margin(value)), [0.0, 0.0, 1.0, -0.5]);
        assert_eq!(Bounds::default().margin(f64::NAN), f64::NEG_INFINITY);
        assert_eq!(bounds.excess(2.5), "0.5 too high");
        assert_eq!(bounds.excess(-2.0), "1 too low");
        assert_eq!(bounds.excess(f64::NAN), "no finite number");
    }
}
