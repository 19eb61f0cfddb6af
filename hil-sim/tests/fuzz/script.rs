//! A text as a sequence of things that happen. Every text is one: a word that is
//! no verb stands for some verb, what is no number for some number. So an input
//! that was changed at random still does something on every line.

use crate::harness::digest;

/// Lines that are carried out: the rest would only take time.
const LONGEST_LINES: usize = 300;

/// A text taken apart.
pub struct Script<'t> {
    name: &'t str,
    lines: Vec<(&'t str, i64)>,
}

impl<'t> Script<'t> {
    /// Reads any text.
    pub fn read(text: &'t str) -> Self {
        let mut lines = text.lines();
        let name = lines.next().unwrap_or("").trim();
        Self { name, lines: lines.filter_map(read_line).take(LONGEST_LINES).collect() }
    }

    /// The one of `items` that the first line names.
    pub fn chosen<'i, T>(&self, items: &'i [T], name: impl Fn(&T) -> &str) -> &'i T {
        let named = items.iter().find(|item| name(item) == self.name);
        named.unwrap_or_else(|| &items[digest(self.name.as_bytes()) as usize % items.len()])
    }

    /// What the lines after the first say, by this table of verbs.
    pub fn acts<V: Copy>(&self, verbs: &[(&str, V)]) -> impl Iterator<Item = (V, i64)> {
        self.lines.iter().map(|&(word, number)| {
            let known = verbs.iter().find(|(verb, _)| *verb == word);
            (known.unwrap_or_else(|| &verbs[digest(word.as_bytes()) as usize % verbs.len()]).1, number)
        })
    }
}

/// A verb, and the number behind it: 1 if there is none.
fn read_line(line: &str) -> Option<(&str, i64)> {
    let mut words = line.split_whitespace();
    let verb = words.next().filter(|word| !word.starts_with('#'))?;
    let number = words.next().map_or(1, |word| word.parse().unwrap_or_else(|_| digest(word.as_bytes()) as i64));
    Some((verb, number))
}
