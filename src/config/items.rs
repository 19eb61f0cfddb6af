//! Values of several kinds, and lists of them.

use super::document::{Node, Value};
use super::reader::{Section, join};

/// A value of one of several kinds.
pub enum Item<'r> {
    /// A string.
    Text(String),
    /// A whole number.
    Integer(i64),
    /// A finite number with a fraction, or one that could have had one.
    Number(f64),
    /// A table.
    Table(Section<'r>),
}

impl<'r> Section<'r> {
    /// The values under `key`: those of an array, or the one that stands there
    /// alone; none where it is not given.
    pub fn items(&self, key: &str) -> Vec<Item<'r>> {
        self.elements(key).into_iter().filter_map(|(path, node)| self.item(key, path, node)).collect()
    }

    /// The values under `key` as TOML has them, of whatever kind: those of an
    /// array, or the one that stands there alone.
    pub fn literals(&self, key: &str) -> Vec<String> {
        self.listed(key, |value| value.literal().ok_or("a string, a finite number, true, false or a table"))
    }

    /// The strings under `key`: those of an array, or the one that stands there
    /// alone.
    pub fn texts(&self, key: &str) -> Vec<String> {
        self.listed(key, |value| if let Value::Text(text) = value { Ok(text.clone()) } else { Err("a string") })
    }

    fn listed<T>(&self, key: &str, read: impl Fn(&Value) -> Result<T, &'static str>) -> Vec<T> {
        let item = |(_, node): (String, &Node)| {
            let read = read(&node.value);
            read.map_err(|expected| self.complain(key, &format!("found {}, expected {expected}", node.value.found())))
        };
        self.elements(key).into_iter().filter_map(|element| item(element).ok()).collect()
    }

    /// The elements of the array under `key`, or the value that stands there
    /// alone, with their paths; none where it is not given.
    fn elements(&self, key: &str) -> Vec<(String, &'r Node)> {
        let Some(entry) = self.get(key) else { return Vec::new() };
        let path = join(&self.path, key);
        match &entry.node.value {
            Value::Array(items) => {
                items.iter().enumerate().map(|(index, node)| (format!("{path}[{index}]"), node)).collect()
            }
            _ => vec![(path, &entry.node)],
        }
    }

    /// The value under `key`, if it is given; an array will not do.
    pub fn one_item(&self, key: &str) -> Option<Item<'r>> {
        let entry = self.get(key)?;
        self.item(key, join(&self.path, key), &entry.node)
    }

    fn item(&self, key: &str, path: String, node: &'r Node) -> Option<Item<'r>> {
        match &node.value {
            Value::Text(text) => Some(Item::Text(text.clone())),
            Value::Integer(number) => Some(Item::Integer(*number)),
            Value::Float(number) if number.is_finite() => Some(Item::Number(*number)),
            Value::Table(_) => Some(Item::Table(Section::new(self.reader, path, node))),
            other => {
                self.complain(key, &format!("found {}, expected a name, a number or a table", other.found()));
                None
            }
        }
    }
}
