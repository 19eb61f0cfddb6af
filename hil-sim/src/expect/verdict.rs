//! How an expectation fared.

use serde::Serialize;

use super::bounds::{Bounds, brief, state_name};
use super::subject::Subject;

/// How an expectation fared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// What its author calls it.
    pub name: Option<String>,
    /// What must hold, as a sentence.
    pub claim: String,
    /// The signal; the message or the kind of notice, where these are counted.
    pub signal: String,
    /// Beginning of the span, s; `null` where it never began.
    pub from_s: Option<f64>,
    /// End of the span, s; `null` where it never began.
    pub until_s: Option<f64>,
    /// Lower bound, if there is one.
    pub min: Option<f64>,
    /// Upper bound, if there is one.
    pub max: Option<f64>,
    /// Whether it held; false where the run ended early, true where it was
    /// never to reach the span.
    pub passed: bool,
    /// What came of it, as a sentence: when, and by how much.
    pub result: String,
    /// The value nearest to a bound or furthest beyond it; what was counted.
    pub worst: Option<f64>,
    /// When that was, s.
    pub worst_at_s: Option<f64>,
    /// The samples next to that moment, where it did not hold.
    pub around: Vec<Sample>,
    /// The text that it stands in.
    pub file: String,
    /// The line there.
    pub line: usize,
    /// More samples around the moment, for a picture: time, s, and value.
    #[serde(skip)]
    pub curve: Vec<(f64, f64)>,
}

/// One sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sample {
    /// When, s.
    pub at_s: f64,
    /// The value.
    pub value: f64,
}

/// What becomes of one whose span somebody else put out of reach.
pub(super) const NOT_REACHED: &str = "not reached, the run was made shorter";

/// What becomes of one that only the stack's own program could judge.
pub(super) const UNSEEN: &str = "not judged: the stack, which alone could tell, is another program";

/// Samples told to either side of the worst.
const TOLD_EITHER_SIDE: usize = 2;

impl Verdict {
    /// `held` or `FAILED`.
    pub const fn word(&self) -> &'static str {
        if self.passed { "held" } else { "FAILED" }
    }

    /// What people call it: its name, or what must hold.
    pub fn title(&self) -> &str {
        self.name.as_deref().unwrap_or(&self.claim)
    }

    /// The samples around the worst, a line each, the worst marked.
    pub fn lines_around(&self) -> impl Iterator<Item = String> {
        let words = Words { is_state: self.signal == "state" };
        self.around.iter().map(move |sample| {
            let sign = if Some(sample.at_s) == self.worst_at_s { '>' } else { ' ' };
            format!("{sign} {:>8.3} s  {}", sample.at_s, words.value(sample.value))
        })
    }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(name) = &self.name {
            write!(out, "{name}: ")?;
        }
        if [NOT_REACHED, UNSEEN].contains(&self.result.as_str()) {
            return write!(out, "{}: {}", self.claim, self.result);
        }
        write!(out, "{}: {}, {}", self.claim, self.word(), self.result)
    }
}

/// What a way of judging makes of a run.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Finding {
    pub passed: bool,
    pub text: String,
    /// Time, s, and value.
    pub worst: Option<(f64, f64)>,
}

impl Finding {
    /// The run was over before there was anything to judge.
    pub fn ended_before() -> Self {
        Self { passed: false, text: "the run ended before".to_owned(), worst: None }
    }
}

/// How values of a subject are called.
pub(super) struct Words {
    is_state: bool,
}

impl Words {
    pub const fn of(subject: &Subject) -> Self {
        Self { is_state: matches!(subject, Subject::State(..)) }
    }

    pub fn value(&self, value: f64) -> String {
        if self.is_state { state_name(value).to_owned() } else { brief(value) }
    }

    /// `worst 0.2`; a state is not better or worse than another.
    pub fn worst(&self, value: f64) -> String {
        format!("{}{}", if self.is_state { "" } else { "worst " }, self.value(value))
    }

    /// `, 0.2 too high`; nothing for a state, which is not more or less.
    pub fn excess(&self, bounds: &Bounds, value: f64) -> String {
        if self.is_state { String::new() } else { format!(", {}", bounds.excess(value)) }
    }
}

/// The samples of `curve` next to `at_s`.
pub(super) fn next_to(curve: &[(f64, f64)], at_s: f64) -> Vec<Sample> {
    let Some(nth) = curve.iter().position(|sample| sample.0 >= at_s) else { return Vec::new() };
    let shown = &curve[nth.saturating_sub(TOLD_EITHER_SIDE)..(nth + TOLD_EITHER_SIDE + 1).min(curve.len())];
    shown.iter().map(|&(at_s, value)| Sample { at_s, value }).collect()
}
