//! What is varied: a key of the scenario and the values that it takes.

use canloop::config::{Bound, Section};

use super::{Kind, normal};

/// A key and its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// A dotted key of the scenario.
    pub key: String,
    /// Its values.
    pub spread: Spread,
}

/// The values of a key.
#[derive(Clone, Debug, PartialEq)]
pub enum Spread {
    /// These, each as TOML has it.
    List(Vec<String>),
    /// So many from the first to the last, all steps alike.
    Linear(f64, f64, u64),
    /// So many from the first to the last, all ratios alike.
    Logarithmic(f64, f64, u64),
    /// Any between the two, all alike.
    Uniform(f64, f64),
    /// Any between the two, all ratios alike.
    LogUniform(f64, f64),
    /// A normal distribution: mean and standard deviation.
    Normal(f64, f64),
}

/// Values that a range has at most.
const MOST_VALUES: i64 = 1_000_000;

impl Axis {
    /// Reads a `[[vary]]` table; what is wrong is reported to its reader.
    pub fn read(section: &Section<'_>) -> Self {
        Self { key: section.text("key"), spread: Spread::read(section) }
    }
}

impl Spread {
    fn read(section: &Section<'_>) -> Self {
        const ANY: Bound = Bound::Within(-1e300, 1e300);
        let ways = ["values", "from", "uniform", "log_uniform", "normal"];
        let given: Vec<&str> = ways.into_iter().filter(|way| section.has(way)).collect();
        let [way] = given[..] else {
            let found = if given.is_empty() { "nothing".to_owned() } else { given.join(" and ") };
            section.complain("key", &format!("found {found} for its values, expected one of {}", ways.join(", ")));
            section.allow(&["values", "from", "to", "count", "scale", "uniform", "log_uniform", "normal"]);
            return Self::List(Vec::new());
        };
        match way {
            "values" => Self::list(section),
            "from" => Self::range(section),
            "normal" => {
                let [mean, deviation] = section.numbers("normal", ANY);
                if deviation <= 0.0 {
                    section.complain("normal", &format!("found the deviation {deviation}, expected one above 0"));
                }
                Self::Normal(mean, deviation)
            }
            _ => {
                let [low, high] = section.numbers(way, ANY);
                if low >= high {
                    section.complain(way, &format!("found an empty range, {low} to {high}"));
                }
                if way == "uniform" {
                    return Self::Uniform(low, high);
                }
                positive(section, way, low);
                Self::LogUniform(low, high)
            }
        }
    }

    fn list(section: &Section<'_>) -> Self {
        let values = section.literals("values");
        if values.is_empty() {
            section.complain("values", "found no value, expected at least one");
        }
        Self::List(values)
    }

    fn range(section: &Section<'_>) -> Self {
        const ANY: Bound = Bound::Within(-1e300, 1e300);
        let (from, to) = (section.number("from", ANY), section.number("to", ANY));
        let count = section.integer("count", 2, MOST_VALUES) as u64;
        let is_logarithmic = section.choice("scale", &[("linear", false), ("logarithmic", true)], false);
        if from == to {
            section.complain("to", &format!("found an empty range, {from} to {to}"));
        }
        if !is_logarithmic {
            return Self::Linear(from, to, count);
        }
        positive(section, "from", from);
        positive(section, "to", to);
        Self::Logarithmic(from, to, count)
    }

    /// How many values there are; none where any number may come.
    pub const fn count(&self) -> Option<u64> {
        match self {
            Self::List(values) => Some(values.len() as u64),
            Self::Linear(.., count) | Self::Logarithmic(.., count) => Some(*count),
            _ => None,
        }
    }

    /// What all of its values are.
    pub fn kind(&self) -> Kind {
        let Self::List(values) = self else { return Kind::Number };
        let all = |is: fn(&String) -> bool| values.iter().all(is);
        if all(|value| value.parse::<i64>().is_ok()) {
            Kind::Whole
        } else if all(|value| value.parse::<f64>().is_ok()) {
            Kind::Number
        } else {
            Kind::Words
        }
    }

    /// The `nth` of its values, as TOML has it.
    pub fn nth(&self, nth: u64) -> String {
        match self {
            Self::List(values) => values[nth as usize].clone(),
            Self::Linear(from, to, count) => number(from + (to - from) * nth as f64 / (count - 1) as f64),
            Self::Logarithmic(from, to, count) => {
                number(from * libm::exp(libm::log(to / from) * nth as f64 / (count - 1) as f64))
            }
            _ => self.quantile(0.5),
        }
    }

    /// The value below which this share of them lies, between 0 and 1, as TOML
    /// has it.
    pub fn quantile(&self, share: f64) -> String {
        match self {
            Self::Uniform(low, high) => number(low + (high - low) * share),
            Self::LogUniform(low, high) => number(low * libm::exp(libm::log(high / low) * share)),
            Self::Normal(mean, deviation) => number(mean + deviation * normal::quantile(share)),
            _ => {
                let count = self.count().unwrap_or(1);
                self.nth(((share * count as f64) as u64).min(count - 1))
            }
        }
    }
}

/// A logarithm needs something to take it of.
fn positive(section: &Section<'_>, key: &str, value: f64) {
    if value <= 0.0 {
        section.complain(key, &format!("found {value} on a logarithmic scale, expected a number above 0"));
    }
}

/// The shortest decimal that is this number again, with a point in it.
fn number(value: f64) -> String {
    format!("{value:?}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_begin_and_end_where_they_are_said_to() {
        let linear = Spread::Linear(0.0, 1.0, 5);
        assert_eq!([0, 1, 4].map(|nth| linear.nth(nth)), ["0.0", "0.25", "1.0"]);
        let logarithmic = Spread::Logarithmic(0.001, 0.1, 3);
        let values = [0, 1, 2].map(|nth| logarithmic.nth(nth).parse::<f64>().expect("a number"));
        assert!(
            (values[0] - 0.001).abs() < 1e-12 && (values[1] - 0.01).abs() < 1e-12 && (values[2] - 0.1).abs() < 1e-12
        );
    }

    #[test]
    fn values_are_of_a_kind_that_holds_each_of_them() {
        let kind = |values: &[&str]| Spread::List(values.iter().map(|&value| value.to_owned()).collect()).kind();
        assert_eq!(kind(&["1", "-2"]), Kind::Whole);
        assert_eq!(kind(&["1", "0.5", "1e300"]), Kind::Number);
        assert_eq!(kind(&["1", "0.5", "\"off\""]), Kind::Words);
        // Words that look like numbers are words all the same.
        assert_eq!(kind(&["\"1\"", "\"2\""]), Kind::Words);
        assert_eq!(Spread::Linear(0.0, 2.0, 3).kind(), Kind::Number);
    }

    #[test]
    fn a_share_leads_to_its_value() {
        let quantile = |spread: &Spread, share| spread.quantile(share).parse::<f64>().expect("a number");
        assert!((quantile(&Spread::Uniform(2.0, 4.0), 0.25) - 2.5).abs() < 1e-12);
        assert!((quantile(&Spread::LogUniform(1.0, 100.0), 0.5) - 10.0).abs() < 1e-12);
        assert!((quantile(&Spread::Normal(5.0, 2.0), 0.5) - 5.0).abs() < 1e-12);
        let list = Spread::List(vec!["\"a\"".to_owned(), "\"b\"".to_owned()]);
        assert_eq!([0.0, 0.49, 0.5, 0.999].map(|share| list.quantile(share)), ["\"a\"", "\"a\"", "\"b\"", "\"b\""]);
    }
}
