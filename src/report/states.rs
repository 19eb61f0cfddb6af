//! Charts of what the stack does.

use super::chart::{Chart, Role, Series, Stroke};

/// The least number of a state that is a trip.
const FIRST_TRIP: f64 = 10.0;
/// What the stack does, from the bottom of the chart to its top.
const STATES: [&str; 6] = ["boot", "stopped", "enabling", "running", "stopping", "tripped"];

/// The stack's state by its name in `chart`: time, s, and number; all trips are
/// one.
pub fn stack_states(chart: Chart, states: Vec<(f64, f64)>) -> Chart {
    let level = |state: f64| if state >= FIRST_TRIP { 5.0 } else { state };
    let points = states.into_iter().map(|(at_s, state)| (at_s, level(state))).collect();
    let line = Series::new("state", Role::Response, Stroke::Solid, points);
    chart.y_range(-0.5, 5.5).y_words(levels(&STATES)).series(line)
}

/// Words at the levels 0, 1 and so on of a chart.
pub fn levels<'w>(words: &'w [&'static str]) -> impl Iterator<Item = (f64, &'static str)> + 'w {
    words.iter().enumerate().map(|(nth, word)| (nth as f64, *word))
}

/// Changes as a line that keeps its level until the next, and the last one until
/// `until_s`.
pub fn steps(changes: impl Iterator<Item = (f64, f64)>, until_s: f64) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> = Vec::new();
    for (at_s, level) in changes {
        points.extend(points.last().map(|&(_, before)| (at_s, before)));
        points.push((at_s, level));
    }
    points.extend(points.last().map(|&(_, last)| (until_s, last)));
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_is_kept_until_the_next_and_to_the_end() {
        let changes = [(0.0, 1.0), (2.0, 3.0)].into_iter();
        assert_eq!(steps(changes, 5.0), [(0.0, 1.0), (2.0, 1.0), (2.0, 3.0), (5.0, 3.0)]);
        assert!(steps(std::iter::empty(), 5.0).is_empty());
    }
}
