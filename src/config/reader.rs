//! Asking a document for its keys.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::document::{Document, Entry, Node, Place, Value};
use super::problem::{Problem, Problems};

/// Hands out sections and collects every problem they meet.
pub struct Reader<'d> {
    document: &'d Document,
    problems: RefCell<Vec<Problem>>,
    /// Keys asked for, by the path of their table: what is not in here when
    /// reading ends is a key that means nothing.
    asked: RefCell<BTreeMap<String, BTreeSet<String>>>,
    /// Paths below which nothing is looked at.
    passed_over: RefCell<BTreeSet<String>>,
}

/// A table of the document, or the place where it would stand.
pub struct Section<'r> {
    pub(super) reader: &'r Reader<'r>,
    pub(super) path: String,
    place: Place,
    table: Option<&'r BTreeMap<String, Entry>>,
    /// Something else stands where the table should: that was reported, and
    /// that it has no keys goes without saying.
    is_no_table: bool,
}

impl<'d> Reader<'d> {
    /// Starts reading `document`.
    pub fn new(document: &'d Document) -> Self {
        Self { document, problems: RefCell::default(), asked: RefCell::default(), passed_over: RefCell::default() }
    }

    /// The table that is the whole document.
    pub fn root(&self) -> Section<'_> {
        Section::new(self, String::new(), &self.document.root)
    }

    /// Reports a problem found by the caller; one that is known already, only
    /// once.
    pub fn report(&self, problem: Problem) {
        let mut problems = self.problems.borrow_mut();
        let is_same = |known: &Problem| {
            known.place.is_some()
                && (&known.place, &known.title, &known.label) == (&problem.place, &problem.title, &problem.label)
        };
        if !problems.iter().any(is_same) {
            problems.push(problem);
        }
    }

    /// Ends reading: `value` if nothing was wrong, else all that was, keys
    /// that nobody asked for included.
    pub fn finish<T>(self, value: T) -> Result<T, Problems> {
        self.report_unknown("", &self.document.root);
        self.finish_in_part(value)
    }

    /// The same where keys that nobody asked for are another reader's.
    pub fn finish_in_part<T>(self, value: T) -> Result<T, Problems> {
        let problems = self.problems.into_inner();
        if problems.is_empty() { Ok(value) } else { Err(Problems(problems)) }
    }

    fn report_unknown(&self, path: &str, node: &Node) {
        if self.passed_over.borrow().contains(path) {
            return;
        }
        match &node.value {
            Value::Table(table) => {
                for (name, entry) in table {
                    let asked = self.asked.borrow();
                    // A table that nobody opened was reported as a wrong value.
                    let Some(known) = asked.get(path) else { continue };
                    if known.contains(name) {
                        drop(asked);
                        self.report_unknown(&join(path, name), &entry.node);
                    } else {
                        let problem = unknown_key(path, name, &entry.key, known);
                        drop(asked);
                        self.report(problem);
                    }
                }
            }
            Value::Array(items) => {
                for (index, item) in items.iter().enumerate() {
                    self.report_unknown(&format!("{path}[{index}]"), item);
                }
            }
            _ => {}
        }
    }
}

impl<'r> Section<'r> {
    pub(super) fn new(reader: &'r Reader<'r>, path: String, node: &'r Node) -> Self {
        let table = match &node.value {
            Value::Table(table) => Some(table),
            other => {
                let title = format!("`{path}` must be a table");
                let label = format!("found {}, expected a table", other.found());
                reader.report(Problem::at(&node.place.source, node.place.span.clone(), title, label));
                None
            }
        };
        if table.is_some() {
            reader.asked.borrow_mut().entry(path.clone()).or_default();
        }
        Self { reader, path, place: node.place.clone(), table, is_no_table: table.is_none() }
    }

    /// Whether the key is there.
    pub fn has(&self, key: &str) -> bool {
        self.get(key).is_some()
    }

    /// The table under `key`; where there is none, one in which every key is
    /// missing.
    pub fn section(&self, key: &str) -> Section<'r> {
        let path = join(&self.path, key);
        match self.get(key) {
            Some(entry) => Section::new(self.reader, path, &entry.node),
            None => {
                let (place, is_no_table) = (self.place.clone(), self.is_no_table);
                Section { reader: self.reader, path, place, table: None, is_no_table }
            }
        }
    }

    /// The array of tables under `key`; empty where there is none.
    pub fn sections(&self, key: &str) -> Vec<Section<'r>> {
        let path = join(&self.path, key);
        let Some(entry) = self.get(key) else { return Vec::new() };
        match &entry.node.value {
            Value::Array(items) => items
                .iter()
                .enumerate()
                .map(|(index, item)| Section::new(self.reader, format!("{path}[{index}]"), item))
                .collect(),
            other => {
                self.complain(key, &format!("found {}, expected an array of tables, [[{path}]]", other.found()));
                Vec::new()
            }
        }
    }

    /// `true` or `false`, or `default` where it is not given.
    pub fn boolean_or(&self, key: &str, default: bool) -> bool {
        let Some(entry) = self.get(key) else { return default };
        match entry.node.value {
            Value::Boolean(value) => value,
            ref other => {
                self.complain(key, &format!("found {}, expected true or false", other.found()));
                default
            }
        }
    }

    /// A string that must be given.
    pub fn text(&self, key: &str) -> String {
        self.text_or_none(key).unwrap_or_else(|| {
            self.missing_unless_present(key, "a string");
            String::new()
        })
    }

    /// A string, or nothing where it is not given.
    pub fn text_or_none(&self, key: &str) -> Option<String> {
        match &self.get(key)?.node.value {
            Value::Text(text) => Some(text.clone()),
            other => {
                self.complain(key, &format!("found {}, expected a string", other.found()));
                None
            }
        }
    }

    /// One of a few words, each with its meaning; the first is the default
    /// where `key` is not required.
    pub fn choice<T: Copy>(&self, key: &str, words: &[(&str, T)], required: bool) -> T {
        let list = words.iter().map(|(word, _)| format!("{word:?}")).collect::<Vec<_>>().join(", ");
        let (_, default) = words[0];
        let Some(entry) = self.get(key) else {
            if required {
                self.missing_unless_present(key, &format!("one of {list}"));
            }
            return default;
        };
        let chosen = match &entry.node.value {
            Value::Text(text) => words.iter().find(|(word, _)| word == text),
            _ => None,
        };
        chosen.map_or_else(
            || {
                self.complain(key, &format!("found {}, expected one of {list}", entry.node.value.found()));
                default
            },
            |&(_, meaning)| meaning,
        )
    }

    /// Takes note that these keys mean something, though not to what is
    /// configured now, so that a law or a kind can be swapped by one override.
    pub fn allow(&self, keys: &[&str]) {
        keys.iter().for_each(|key| {
            self.get(key);
        });
    }

    /// Takes a key and all that is in it as known, whatever it is.
    pub fn pass_over(&self, key: &str) {
        self.get(key);
        self.reader.passed_over.borrow_mut().insert(join(&self.path, key));
    }

    /// The path that `key` holds: as it is, or from the folder of the file in
    /// which it stands; an override's counts from the working directory.
    pub fn path_of(&self, key: &str, path: &str) -> PathBuf {
        let entry = self.table.and_then(|table| table.get(key));
        let file = entry.map(|entry| Path::new(entry.node.place.source.name.as_str()));
        let folder = file.and_then(Path::parent).filter(|_| Path::new(path).is_relative());
        folder.map_or_else(|| PathBuf::from(path), |folder| folder.join(path))
    }

    /// Whether `key` of `other` was laid over the text in which this section
    /// stands, by an override or a file based on it.
    pub fn is_overlaid_by(&self, other: &Self, key: &str) -> bool {
        let layer = |place: &Place| {
            self.reader.document.layers.iter().position(|layer| Arc::ptr_eq(layer, &place.source)).unwrap_or(0)
        };
        let entry = other.table.and_then(|table| table.get(key));
        entry.is_some_and(|entry| layer(&entry.node.place) > layer(&self.place))
    }

    /// Names of the keys that are given, without asking for any.
    pub fn keys(&self) -> Vec<&'r str> {
        self.table.map(|table| table.keys().map(String::as_str).collect()).unwrap_or_default()
    }

    /// Where the section stands: the name of its text and the line, from 1.
    pub fn line(&self) -> (&str, usize) {
        let source = &self.place.source;
        (&source.name, source.line_and_column(self.place.span.start).0)
    }

    /// Reports that the value of `key` will not do; `label` says what was
    /// found and what was expected.
    pub fn complain(&self, key: &str, label: &str) {
        self.reader.report(self.problem(key, &format!("`{}` will not do", join(&self.path, key)), label));
    }

    /// A problem at the value of `key`, or at the section where it is missing.
    pub fn problem(&self, key: &str, title: &str, label: &str) -> Problem {
        let place = match self.table.and_then(|table| table.get(key)) {
            Some(entry) => &entry.node.place,
            None => &self.place,
        };
        Problem::at(&place.source, place.span.clone(), title, label)
    }

    /// Reports a problem made with [`Self::problem`].
    pub fn report(&self, problem: Problem) {
        self.reader.report(problem);
    }

    pub(super) fn get(&self, key: &str) -> Option<&'r Entry> {
        let mut asked = self.reader.asked.borrow_mut();
        asked.entry(self.path.clone()).or_default().insert(key.to_owned());
        self.table?.get(key)
    }

    pub(super) fn missing_unless_present(&self, key: &str, expected: &str) {
        if !self.has(key) && !self.is_no_table {
            let title = format!("`{}` is missing", join(&self.path, key));
            let start = self.place.span.start;
            let problem = Problem::at(
                &self.place.source,
                start..self.place.span.end.min(start + 1),
                title,
                format!("found no `{key}` in {}, expected {expected}", table_name(&self.path)),
            );
            self.reader.report(problem);
        }
    }
}

fn unknown_key(path: &str, name: &str, key: &Place, known: &BTreeSet<String>) -> Problem {
    let title = format!("unknown key `{}`", join(path, name));
    let list = known.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    let label = format!("found `{name}`, expected one of {list}");
    let problem = Problem::at(&key.source, key.span.clone(), title, label);
    match nearest(name, known.iter().map(String::as_str)) {
        Some(name) => problem.help(format!("did you mean `{name}`?")),
        None => problem,
    }
}

/// The name most like `wanted`, if one is like it at all.
pub fn nearest<'n>(wanted: &str, names: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    names
        .map(|name| (strsim::jaro_winkler(wanted, name), name))
        .filter(|(likeness, _)| *likeness > 0.8)
        .max_by(|(a, _), (b, _)| a.total_cmp(b))
        .map(|(_, name)| name)
}

pub(super) fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

fn table_name(path: &str) -> String {
    if path.is_empty() { "the file".to_owned() } else { format!("[{path}]") }
}
