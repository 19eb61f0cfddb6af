//! Tables of a page.

use super::markup::Markup;
use super::scale::{decimal, power_of_ten};

/// From here on a number is written with a power of ten.
const LARGE: f64 = 1e6;

/// Rows under named columns.
#[derive(Clone, Debug)]
pub struct Table {
    columns: Vec<Column>,
    rows: Vec<Vec<Cell>>,
}

/// What a column holds.
#[derive(Clone, Debug)]
pub struct Column {
    name: String,
    unit: String,
    decimals: Option<usize>,
    wraps: bool,
}

/// What a row holds in one column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number in the column's unit.
    Number(f64),
    /// A verdict.
    Badge(Badge),
}

/// A verdict, told by word, sign and colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Badge {
    /// As it should be.
    Pass,
    /// Not as it should be.
    Fail,
    /// The response grows without bound.
    Diverges,
}

impl Table {
    /// A table without rows.
    pub fn new(columns: impl IntoIterator<Item = Column>) -> Self {
        Self { columns: columns.into_iter().collect(), rows: Vec::new() }
    }

    /// Adds a row.
    ///
    /// # Panics
    /// If it has not one cell a column, which is a mistake in the program.
    pub fn row(mut self, cells: impl IntoIterator<Item = Cell>) -> Self {
        let cells: Vec<Cell> = cells.into_iter().collect();
        assert_eq!(cells.len(), self.columns.len(), "a row has one cell a column");
        self.rows.push(cells);
        self
    }

    pub(super) fn write(&self, out: &mut Markup) {
        out.open("div", &[("class", "table")]);
        out.open("table", &[]);
        out.open("thead", &[]);
        out.open("tr", &[]);
        for column in &self.columns {
            out.open("th", &[("scope", "col"), ("class", column.class())]);
            out.text(&column.name);
            if !column.unit.is_empty() {
                out.leaf("span", &[("class", "unit")], &format!(" ({})", column.unit));
            }
            out.close("th");
        }
        out.close("tr");
        out.close("thead");
        out.open("tbody", &[]);
        for row in &self.rows {
            out.open("tr", &[]);
            for (column, cell) in self.columns.iter().zip(row) {
                column.write(cell, out);
            }
            out.close("tr");
        }
        out.close("tbody");
        out.close("table");
        out.close("div");
    }
}

impl Column {
    /// A column of words or badges.
    pub fn text(name: impl Into<String>) -> Self {
        Self { name: name.into(), unit: String::new(), decimals: None, wraps: false }
    }

    /// A column of sentences, which may take several lines.
    pub fn prose(name: impl Into<String>) -> Self {
        Self { wraps: true, ..Self::text(name) }
    }

    /// A column of numbers, each with so many `decimals`; `unit` may be empty.
    /// Numbers too large or too small for that show three digits and a power of ten.
    pub fn number(name: impl Into<String>, unit: impl Into<String>, decimals: usize) -> Self {
        Self { name: name.into(), unit: unit.into(), decimals: Some(decimals), wraps: false }
    }

    fn class(&self) -> &'static str {
        match self.decimals {
            Some(_) => "number",
            None if self.wraps => "prose",
            None => "words",
        }
    }

    fn write(&self, cell: &Cell, out: &mut Markup) {
        let attributes = [("class", self.class())];
        match cell {
            Cell::Text(text) => out.leaf("td", &attributes, text),
            Cell::Number(value) => out.leaf("td", &attributes, &number(*value, self.decimals.unwrap_or(3))),
            Cell::Badge(badge) => {
                out.open("td", &attributes);
                let (class, words) = badge.look();
                out.leaf("span", &[("class", class)], words);
                out.close("td");
            }
        }
    }
}

impl Badge {
    fn look(self) -> (&'static str, &'static str) {
        match self {
            Self::Pass => ("badge pass", "✓\u{a0}pass"),
            Self::Fail => ("badge fail", "✗\u{a0}fail"),
            Self::Diverges => ("badge diverges", "↗\u{a0}diverges"),
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<Badge> for Cell {
    fn from(badge: Badge) -> Self {
        Self::Badge(badge)
    }
}

fn number(value: f64, decimals: usize) -> String {
    let magnitude = value.abs();
    if value.is_nan() {
        "–".into()
    } else if magnitude.is_infinite() {
        if value > 0.0 { "∞".into() } else { "−∞".into() }
    } else if magnitude >= LARGE || (magnitude > 0.0 && decimal(magnitude, decimals) == decimal(0.0, decimals)) {
        scientific(value)
    } else {
        decimal(value, decimals)
    }
}

/// Three digits and a power of ten.
fn scientific(value: f64) -> String {
    // Rust's own notation rounds correctly: 9.999e5 becomes 1.00e6.
    let digits = format!("{value:.2e}");
    match digits.split_once('e').map(|(mantissa, exponent)| (mantissa.parse(), exponent.parse())) {
        Some((Ok(mantissa), Ok(exponent))) => format!("{}×{}", decimal(mantissa, 2), power_of_ten(exponent)),
        _ => digits,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_aligned() {
        assert_eq!(number(0.123_456, 3), "0.123");
        assert_eq!(number(0.0, 3), "0.000");
        assert_eq!(number(-12.5, 1), "−12.5");
        assert_eq!(number(-0.000_04, 2), "−4.00×10⁻⁵");
        assert_eq!(number(1.234_5e45, 3), "1.23×10⁴⁵");
        assert_eq!(number(9.999e9, 3), "1.00×10¹⁰");
        assert_eq!(number(f64::NAN, 3), "–");
        assert_eq!(number(f64::NEG_INFINITY, 3), "−∞");
    }

    #[test]
    #[should_panic(expected = "one cell a column")]
    fn a_row_has_one_cell_a_column() {
        _ = Table::new([Column::text("a"), Column::text("b")]).row(["only one".into()]);
    }
}
