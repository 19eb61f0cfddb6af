//! Which signals of a message are multiplexed by which: from `M`, `m0` and
//! `SG_MUL_VAL_` to selectors.

use std::ops::RangeInclusive;

use super::notes::Notes;
use super::statements::{At, Message};
use crate::schema::signal::Selector;

/// A mark of an `SG_` statement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Mark {
    is_switch: bool,
    selected_by: Option<u64>,
}

/// Something that is not clear, at a signal of the message.
pub(super) struct Doubt {
    pub signal: usize,
    pub title: String,
    pub label: String,
    pub hint: &'static str,
}

/// What is done in doubt.
const ALWAYS_THERE: &str = "it is taken to be there always";

/// The selectors of a message's signals, one each, and what was doubtful: a
/// signal in doubt is taken to be there always.
pub(super) fn selectors(message: &Message<'_>, id: u64, notes: &Notes<'_>) -> (Vec<Option<Selector>>, Vec<Doubt>) {
    let mut doubts = Vec::new();
    let marks: Vec<Mark> = (0..message.signals.len()).map(|index| mark(message, index, &mut doubts)).collect();
    let mut selectors = vec![None; marks.len()];
    for (index, signal) in message.signals.iter().enumerate() {
        if !marks[index].is_switch && marks[index].selected_by.is_none() {
            continue;
        }
        let found = selector(message, id, notes, &marks, index);
        if found.is_none() && marks[index].selected_by.is_some() {
            let title = format!("nothing says what switches `{}`", signal.name.is);
            let label = match marks.iter().filter(|mark| mark.is_switch).count() {
                0 => "found no multiplexer switch, `M`, in the message",
                1 => "found no SG_MUL_VAL_ for it",
                _ => "found several switches and no SG_MUL_VAL_ for it",
            };
            doubts.push(Doubt { signal: index, title, label: label.to_owned(), hint: ALWAYS_THERE });
        }
        selectors[index] = found;
    }
    break_circles(message, &mut selectors, &mut doubts);
    (selectors, doubts)
}

fn mark(message: &Message<'_>, index: usize, doubts: &mut Vec<Doubt>) -> Mark {
    let Some(At { is: text, .. }) = &message.signals[index].multiplexing else { return Mark::default() };
    let inner = text.strip_suffix('M').unwrap_or(text);
    let is_switch = inner.len() < text.len();
    let selected_by = inner.strip_prefix('m').and_then(|digits| digits.parse().ok());
    if selected_by.is_none() && !(is_switch && inner.is_empty()) {
        let title = format!("`{text}` says nothing of multiplexing");
        let label = "expected M, m0 or m0M".to_owned();
        doubts.push(Doubt { signal: index, title, label, hint: ALWAYS_THERE });
    }
    Mark { is_switch, selected_by }
}

/// With one switch in the message, `m0` is enough to say by which; with more,
/// it takes a `SG_MUL_VAL_`.
fn selector(message: &Message<'_>, id: u64, notes: &Notes<'_>, marks: &[Mark], index: usize) -> Option<Selector> {
    let mut switches = (0..marks.len()).filter(|&index| marks[index].is_switch);
    let only_switch = switches.next().filter(|_| switches.next().is_none());
    if only_switch == Some(index) {
        return None;
    }
    let name = message.signals[index].name.is;
    let mut values: Vec<RangeInclusive<u64>> = Vec::new();
    let mut switch = only_switch;
    for selection in notes.selections(id).iter().filter(|selection| selection.signal == name) {
        let named = message.signals.iter().position(|signal| signal.name.is == selection.switch.is);
        if only_switch.is_none() {
            switch = named;
        }
        if named.is_some() && named == switch {
            values.extend(selection.ranges.iter().map(|&(first, last)| first..=last));
        }
    }
    let mark = marks[index].selected_by.filter(|_| only_switch.is_some());
    values.extend(mark.filter(|mark| !values.iter().any(|range| range.contains(mark))).map(|mark| mark..=mark));
    switch.filter(|_| !values.is_empty()).map(|switch| Selector { switch, values })
}

/// Signals that in the end switch themselves are there always.
fn break_circles(message: &Message<'_>, selectors: &mut [Option<Selector>], doubts: &mut Vec<Doubt>) {
    for index in 0..selectors.len() {
        let mut at = index;
        for _ in 0..=selectors.len() {
            let Some(selector) = &selectors[at] else { break };
            at = selector.switch;
            if at == index {
                let title = format!("`{}` switches itself", message.signals[index].name.is);
                let label = "found a circle of multiplexer switches".to_owned();
                doubts.push(Doubt { signal: index, title, label, hint: ALWAYS_THERE });
                selectors[index] = None;
                break;
            }
        }
    }
}
