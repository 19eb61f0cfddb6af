//! What each column of the results holds, in whichever file they are.

use super::Axis;
use super::row::{ALWAYS_FILLED, COLUMNS};

/// A column of the results.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Its name, units last.
    pub name: String,
    /// What its cells are.
    pub kind: Kind,
    /// Whether a cell may be empty because there is nothing to say.
    pub may_be_empty: bool,
}

/// What the cells of a column are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Whole numbers.
    Whole,
    /// Any numbers.
    Number,
    /// `true` or `false`.
    Truth,
    /// Words.
    Words,
}

/// The columns of a plan's results: the run's number, the keys that are varied,
/// and what came out.
pub fn columns(axes: &[Axis]) -> Vec<Column> {
    let filled = |name: &str, kind| Column { name: name.to_owned(), kind, may_be_empty: false };
    let key = |axis: &Axis| filled(&axis.key, axis.spread.kind());
    let figure = |(nth, (name, kind))| Column { may_be_empty: nth >= ALWAYS_FILLED, ..filled(name, kind) };
    let figures = COLUMNS.into_iter().enumerate().map(figure);
    [filled("run", Kind::Whole)].into_iter().chain(axes.iter().map(key)).chain(figures).collect()
}
