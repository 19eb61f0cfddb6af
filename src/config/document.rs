//! A TOML file as a tree in which every key and value knows its place, so
//! that overrides from elsewhere can be laid over it without losing any.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::problem::{Problem, Source};

/// A configuration file and the overrides laid over it.
#[derive(Debug)]
pub struct Document {
    pub(super) source: Arc<Source>,
    pub(super) root: Node,
    /// All texts that went into it, the ones laid over others last.
    pub(super) layers: Vec<Arc<Source>>,
}

/// A value and where it stands.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub place: Place,
    pub value: Value,
}

#[derive(Clone, Debug)]
pub(super) struct Place {
    pub source: Arc<Source>,
    pub span: Range<usize>,
}

#[derive(Clone, Debug)]
pub(super) enum Value {
    Integer(i64),
    Float(f64),
    Boolean(bool),
    Text(String),
    Array(Vec<Node>),
    Table(BTreeMap<String, Entry>),
    /// A date or a number out of range: nothing here asks for one.
    Other(&'static str),
}

#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub key: Place,
    pub node: Node,
}

impl Document {
    /// Parses `text`, which messages call `name`.
    pub fn parse(name: impl Into<String>, text: impl Into<String>) -> Result<Self, Problem> {
        let source = Source::new(name, text);
        let root = parse(&source)?;
        Ok(Self { layers: vec![Arc::clone(&source)], source, root })
    }

    /// Reads and parses a file.
    pub fn read(path: &Path) -> Result<Self, Problem> {
        Self::parse(path.display().to_string(), read_text(path)?)
    }

    /// All that is wrong with the TOML of `text`, where parsing stops at the
    /// first.
    pub fn syntax_problems(source: &Arc<Source>) -> Vec<Problem> {
        let (_, errors) = DeTable::parse_recoverable(&source.text);
        errors.iter().map(|error| syntax_problem(source, error)).collect()
    }

    /// Lays `KEY=VALUE` over the document: KEY a dotted path, VALUE as TOML.
    pub fn set(&mut self, assignment: &str) -> Result<(), Problem> {
        let source = Source::new("--set", assignment);
        self.layers.push(Arc::clone(&source));
        let whole = 0..assignment.len();
        let Some((key, _)) = assignment.split_once('=') else {
            return Err(Problem::at(&source, whole, "an override without a value", "expected KEY=VALUE"));
        };
        let tree = parse(&source).map_err(|problem| {
            problem.help("VALUE is written as TOML: a string needs quotes, as in --set 'controller.law=\"dac\"'")
        })?;
        let path = dotted_path(key);
        let mut node = tree;
        let mut key_place = node.place.clone();
        for part in &path {
            let Value::Table(mut table) = node.value else { break };
            let only = table.remove(part).filter(|_| table.is_empty());
            let Some(entry) = only else {
                return Err(Problem::at(&source, whole, "an override must be one KEY=VALUE", "found more than that"));
            };
            (key_place, node) = (entry.key, entry.node);
        }
        self.root.put(&path, key_place, node)
    }

    /// Fills what this document leaves open from `base`. Tables are joined key
    /// by key, except that one which says its own `kind` or `law` stands alone:
    /// the base's other keys are another kind's.
    pub fn lay_over(&mut self, base: Self) {
        self.layers.splice(0..0, base.layers);
        self.root.lay_over(base.root);
    }

    /// The string under a key of the outermost table, if there is one.
    pub fn text_of(&self, key: &str) -> Option<&str> {
        let Value::Table(table) = &self.root.value else { return None };
        match &table.get(key)?.node.value {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// Whether the outermost table has a key.
    pub fn has(&self, key: &str) -> bool {
        matches!(&self.root.value, Value::Table(table) if table.contains_key(key))
    }

    /// A problem with the value of a key of the outermost table.
    pub fn problem_at(&self, key: &str, title: impl Into<String>, label: impl Into<String>) -> Problem {
        let place = match &self.root.value {
            Value::Table(table) => table.get(key).map_or(&self.root.place, |entry| &entry.node.place),
            _ => &self.root.place,
        };
        Problem::at(&place.source, place.span.clone(), title, label)
    }

    /// The whole as one TOML text that is based on nothing: what it was based on
    /// and the overrides laid over it are in their places.
    pub fn resolved(&self) -> String {
        let mut whole = self.root.value.plain();
        if let Some(table) = whole.as_table_mut() {
            table.remove("base");
        }
        toml::to_string(&whole).expect("what was TOML can be TOML again")
    }

    /// The file's text, as read.
    pub fn text(&self) -> &str {
        &self.source.text
    }

    /// The file's name in messages.
    pub fn name(&self) -> &str {
        &self.source.name
    }
}

/// Reads a text file; the problem says which and why.
pub(crate) fn read_text(path: &Path) -> Result<String, Problem> {
    let bytes =
        std::fs::read(path).map_err(|error| Problem::bare(format!("cannot read {}: {error}", path.display())))?;
    String::from_utf8(bytes).map_err(|error| Problem::bare(format!("{} is not UTF-8 text: {error}", path.display())))
}

impl Node {
    fn lay_over(&mut self, base: Self) {
        let (Value::Table(own), Value::Table(base)) = (&mut self.value, base.value) else { return };
        if own.contains_key("kind") || own.contains_key("law") {
            return;
        }
        for (key, entry) in base {
            match own.get_mut(&key) {
                Some(mine) => mine.node.lay_over(entry.node),
                None => {
                    own.insert(key, entry);
                }
            }
        }
    }

    fn put(&mut self, path: &[String], key: Place, node: Node) -> Result<(), Problem> {
        let Some((first, rest)) = path.split_first() else {
            *self = node;
            return Ok(());
        };
        let kind = self.value.kind();
        let Value::Table(table) = &mut self.value else {
            let title = format!("`{first}` cannot be set inside {kind}");
            return Err(Problem::at(&key.source, key.span, title, format!("found {kind} there, expected a table")));
        };
        let place = key.clone();
        let entry = table.entry(first.clone()).or_insert_with(|| Entry {
            key: place.clone(),
            node: Node { place, value: Value::Table(BTreeMap::new()) },
        });
        if rest.is_empty() {
            entry.key = key.clone();
        }
        entry.node.put(rest, key, node)
    }
}

impl Value {
    fn plain(&self) -> toml::Value {
        match self {
            Self::Integer(value) => (*value).into(),
            Self::Float(value) => (*value).into(),
            Self::Boolean(value) => (*value).into(),
            Self::Text(text) => text.as_str().into(),
            Self::Array(items) => items.iter().map(|item| item.value.plain()).collect::<Vec<_>>().into(),
            Self::Table(table) => {
                let entries = table.iter().map(|(key, entry)| (key.clone(), entry.node.value.plain()));
                entries.collect::<toml::Table>().into()
            }
            Self::Other(kind) => (*kind).into(),
        }
    }

    /// The value as TOML has it; none where it is nothing that is asked for.
    pub fn literal(&self) -> Option<String> {
        self.is_usable().then(|| self.plain().to_string())
    }

    fn is_usable(&self) -> bool {
        match self {
            Self::Float(number) => number.is_finite(),
            Self::Array(items) => items.iter().all(|item| item.value.is_usable()),
            Self::Table(table) => table.values().all(|entry| entry.node.value.is_usable()),
            Self::Integer(_) | Self::Boolean(_) | Self::Text(_) => true,
            Self::Other(_) => false,
        }
    }

    /// For messages: what it is.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Integer(_) => "an integer",
            Self::Float(_) => "a number",
            Self::Boolean(_) => "a boolean",
            Self::Text(_) => "a string",
            Self::Array(_) => "an array",
            Self::Table(_) => "a table",
            Self::Other(kind) => kind,
        }
    }

    /// For messages: the value itself where it is short, else its kind.
    pub fn found(&self) -> String {
        match self {
            Self::Integer(value) => value.to_string(),
            Self::Float(value) => brief(*value),
            Self::Boolean(value) => value.to_string(),
            Self::Text(text) if text.len() <= 40 => format!("the string {text:?}"),
            other => other.kind().to_owned(),
        }
    }
}

/// For messages: a number without a row of zeros.
pub(super) fn brief(number: f64) -> String {
    let is_plain = number == 0.0 || (1e-4..1e7).contains(&number.abs());
    if is_plain { number.to_string() } else { format!("{number:e}") }
}

fn parse(source: &Arc<Source>) -> Result<Node, Problem> {
    match DeTable::parse(&source.text) {
        Ok(table) => {
            let span = table.span();
            Ok(Node { place: place(source, span), value: table_value(source, table.get_ref()) })
        }
        Err(error) => Err(syntax_problem(source, &error)),
    }
}

fn syntax_problem(source: &Arc<Source>, error: &toml::de::Error) -> Problem {
    Problem::at(source, error.span().unwrap_or(0..0), "this is not valid TOML", error.message())
}

fn place(source: &Arc<Source>, span: Range<usize>) -> Place {
    Place { source: Arc::clone(source), span }
}

fn table_value(source: &Arc<Source>, table: &DeTable<'_>) -> Value {
    let entries = table.iter().map(|(key, value)| {
        let entry = Entry { key: place(source, key.span()), node: node(source, value) };
        (key.get_ref().to_string(), entry)
    });
    Value::Table(entries.collect())
}

fn node(source: &Arc<Source>, value: &Spanned<DeValue<'_>>) -> Node {
    let converted = match value.get_ref() {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Integer(number) => i64::from_str_radix(number.as_str(), number.radix())
            .map_or(Value::Other("an integer of more than 64 bits"), Value::Integer),
        DeValue::Float(number) => {
            number.as_str().parse().map_or(Value::Other("a number beyond the range of f64"), Value::Float)
        }
        DeValue::Boolean(value) => Value::Boolean(*value),
        DeValue::Datetime(_) => Value::Other("a date"),
        DeValue::Array(items) => Value::Array(items.iter().map(|item| node(source, item)).collect()),
        DeValue::Table(table) => table_value(source, table),
    };
    Node { place: place(source, value.span()), value: converted }
}

/// The parts of a dotted key; quotes around a part are taken off.
fn dotted_path(key: &str) -> Vec<String> {
    key.split('.').map(|part| part.trim().trim_matches(['"', '\'']).to_owned()).collect()
}
