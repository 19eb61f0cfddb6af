//! Numbers and the bounds that they keep.

use super::document::{Value, brief};
use super::reader::Section;

/// What a number must keep to; every number must be finite besides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// Any finite number.
    Finite,
    /// Zero or more.
    NotNegative,
    /// More than zero.
    Positive,
    /// From the first to the second, both included.
    Within(f64, f64),
}

impl Section<'_> {
    /// A number that must be given. Where it is missing or wrong that is
    /// reported, and NaN stands in for it.
    pub fn number(&self, key: &str, bound: Bound) -> f64 {
        self.number_or_none(key, bound).unwrap_or_else(|| {
            self.missing_unless_present(key, &bound.expected());
            f64::NAN
        })
    }

    /// A number, or `default` where it is not given.
    pub fn number_or(&self, key: &str, default: f64, bound: Bound) -> f64 {
        self.number_or_none(key, bound).unwrap_or(default)
    }

    /// A number, or nothing where it is not given.
    pub fn number_or_none(&self, key: &str, bound: Bound) -> Option<f64> {
        let entry = self.get(key)?;
        let number = as_number(&entry.node.value);
        match number.filter(|&number| bound.holds(number)) {
            Some(number) => Some(number),
            None => {
                self.complain(key, &format!("found {}, expected {}", entry.node.value.found(), bound.expected()));
                None
            }
        }
    }

    /// A fixed number of numbers, such as a point.
    pub fn numbers<const N: usize>(&self, key: &str, bound: Bound) -> [f64; N] {
        let expected = format!("an array of {N} numbers, each {}", bound.expected());
        let Some(entry) = self.get(key) else {
            self.missing_unless_present(key, &expected);
            return [f64::NAN; N];
        };
        let items: Vec<f64> = match &entry.node.value {
            Value::Array(items) => items.iter().filter_map(|item| as_number(&item.value)).collect(),
            _ => Vec::new(),
        };
        let whole = matches!(&entry.node.value, Value::Array(all) if all.len() == items.len());
        match <[f64; N]>::try_from(items) {
            Ok(numbers) if whole && numbers.iter().all(|&number| bound.holds(number)) => numbers,
            _ => {
                self.complain(key, &format!("found {}, expected {expected}", entry.node.value.found()));
                [f64::NAN; N]
            }
        }
    }

    /// A whole number from `least` to `most` that must be given.
    pub fn integer(&self, key: &str, least: i64, most: i64) -> i64 {
        if !self.has(key) {
            self.missing_unless_present(key, &format!("a whole number from {least} to {most}"));
        }
        self.integer_or(key, least, least, most)
    }

    /// A whole number from `least` to `most`, or `default` where it is not given.
    pub fn integer_or(&self, key: &str, default: i64, least: i64, most: i64) -> i64 {
        let Some(entry) = self.get(key) else { return default };
        match entry.node.value {
            Value::Integer(number) if (least..=most).contains(&number) => number,
            ref other => {
                let found = other.found();
                self.complain(key, &format!("found {found}, expected a whole number from {least} to {most}"));
                default
            }
        }
    }
}

impl Bound {
    fn holds(self, number: f64) -> bool {
        number.is_finite()
            && match self {
                Self::Finite => true,
                Self::NotNegative => number >= 0.0,
                Self::Positive => number > 0.0,
                Self::Within(least, most) => (least..=most).contains(&number),
            }
    }

    fn expected(self) -> String {
        match self {
            Self::Finite => "a finite number".to_owned(),
            Self::NotNegative => "a finite number, 0 or more".to_owned(),
            Self::Positive => "a finite number above 0".to_owned(),
            Self::Within(least, most) => format!("a number from {} to {}", brief(least), brief(most)),
        }
    }
}

fn as_number(value: &Value) -> Option<f64> {
    match *value {
        Value::Float(number) => Some(number),
        Value::Integer(number) => Some(number as f64),
        _ => None,
    }
}
