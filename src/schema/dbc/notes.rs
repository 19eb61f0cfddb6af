//! What a DBC file says of its nodes, messages and signals after it has laid
//! them out: comments, attributes, value names and number types.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use super::findings::Findings;
use super::statements::{AttributeValue, Note, Object, Selection, Statements, ValueList, ValueNames};
use crate::time::Duration;

/// A message's period in milliseconds, as Vector's tools and all others since
/// call it.
const CYCLE_TIME: &str = "GenMsgCycleTime";
/// A signal's raw value before anybody has set one.
const START_VALUE: &str = "GenSigStartValue";
/// The bus's bit rate, in bit/s or kbit/s.
const BIT_RATE: &str = "Baudrate";
/// Classic or FD.
const FRAME_FORMAT: &str = "VFrameFormat";
/// What the values of [`FRAME_FORMAT`] mean where the DBC defines it as a number.
const FD_FORMATS: [f64; 2] = [14.0, 15.0];

/// A DBC's notes, by what they speak of. Ids are the DBC's own numbers, with
/// their mark for 29 bits.
pub(super) struct Notes<'f> {
    comments: BTreeMap<Object<'f>, &'f str>,
    attributes: BTreeMap<(&'f str, Object<'f>), &'f AttributeValue>,
    defaults: BTreeMap<&'f str, &'f AttributeValue>,
    /// Words of attributes that are one of a list.
    words: BTreeMap<&'f str, &'f [String]>,
    values: BTreeMap<Object<'f>, &'f ValueNames>,
    number_types: BTreeMap<Object<'f>, u64>,
    selections: BTreeMap<u64, Vec<&'f Selection<'f>>>,
}

impl<'f> Notes<'f> {
    /// Sorts the notes of `file`; those of things that are not there, and of
    /// things that were noted before, are reported.
    pub fn new(file: &'f Statements<'f>, findings: &mut Findings<'_>) -> Self {
        let mut reporter = Reporter { known: objects(file), findings };
        let tables: BTreeMap<_, _> = file.tables.iter().map(|(name, names)| (name.is, names)).collect();
        let mut values = BTreeMap::new();
        for note in file.values.iter().filter(|note| matches!(note.of.is, Object::Signal(..))) {
            reporter.check_exists("VAL_", note);
            let names = match &note.is {
                ValueList::Names(names) => names,
                ValueList::Table(name) => match tables.get(name.is) {
                    Some(names) => *names,
                    None => {
                        let title = format!("there is no value table `{}`", name.is);
                        let (label, hint) = ("found no VAL_TABLE_ of this name", "the values stay without names");
                        reporter.findings.warn(&name.span, title, label, hint);
                        continue;
                    }
                },
            };
            if !names.is_empty() && values.insert(note.of.is, names).is_some() {
                let (label, hint) = ("found a second VAL_ for it", "it takes the place of the first: keep one of them");
                reporter.findings.warn(&note.of.span, "values of a signal are named twice", label, hint);
            }
        }
        file.comments.iter().for_each(|note| reporter.check_exists("CM_", note));
        file.attributes.iter().for_each(|note| reporter.check_exists("BA_", note));
        file.number_types.iter().for_each(|note| reporter.check_exists("SIG_VALTYPE_", note));
        let mut selections: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for selection in &file.selections {
            reporter.check_selection(selection);
            selections.entry(selection.message).or_default().push(selection);
        }
        Self {
            comments: file.comments.iter().map(|note| (note.of.is, note.is.as_str())).collect(),
            attributes: file.attributes.iter().map(|note| ((note.is.0, note.of.is), &note.is.1)).collect(),
            defaults: file.defaults.iter().map(|(name, value)| (*name, value)).collect(),
            words: file.definitions.iter().map(|definition| (definition.name, definition.words.as_slice())).collect(),
            values,
            number_types: file.number_types.iter().map(|note| (note.of.is, note.is)).collect(),
            selections,
        }
    }

    pub fn comment(&self, of: Object<'_>) -> String {
        self.comments.get(&of).map_or_else(String::new, |text| (*text).to_owned())
    }

    /// The long name of something that short names are too short for.
    pub fn long_name(&self, of: Object<'_>) -> Option<String> {
        let attribute = match of {
            Object::Message(_) => "SystemMessageLongSymbol",
            Object::Signal(..) => "SystemSignalLongSymbol",
            Object::Node(_) => "SystemNodeLongSymbol",
            Object::Network | Object::EnvironmentVariable(_) => return None,
        };
        match self.attributes.get(&(attribute, of))? {
            AttributeValue::Text(name) if !name.is_empty() => Some(name.clone()),
            _ => None,
        }
    }

    pub fn value_names(&self, of: Object<'_>) -> Option<&'f ValueNames> {
        self.values.get(&of).copied()
    }

    /// As `SIG_VALTYPE_` gives it: 0 whole, 1 float, 2 double.
    pub fn number_type(&self, of: Object<'_>) -> u64 {
        self.number_types.get(&of).copied().unwrap_or(0)
    }

    /// The `SG_MUL_VAL_` of a message.
    pub fn selections(&self, message: u64) -> &[&'f Selection<'f>] {
        self.selections.get(&message).map_or(&[], Vec::as_slice)
    }

    pub fn cycle(&self, message: u64) -> Option<Duration> {
        let millis = self.number(CYCLE_TIME, Object::Message(message))?;
        (millis > 0.0 && millis < 1e9).then(|| Duration::from_secs_f64(millis / 1e3))
    }

    pub fn start_value(&self, message: u64, signal: &str) -> Option<f64> {
        self.number(START_VALUE, Object::Signal(message, signal)).filter(|value| value.is_finite())
    }

    /// The bus's bit rate, bit/s.
    pub fn bit_rate(&self) -> Option<u32> {
        let rate = self.number(BIT_RATE, Object::Network)?;
        let rate = if (1.0..=1_000.0).contains(&rate) { rate * 1_000.0 } else { rate };
        (10_000.0..=1_000_000.0).contains(&rate).then_some(rate as u32)
    }

    /// Whether the DBC says that a message is sent in CAN FD frames.
    pub fn is_fd(&self, message: u64) -> bool {
        let Some(number) = self.number(FRAME_FORMAT, Object::Message(message)) else { return false };
        match self.words.get(FRAME_FORMAT) {
            Some(words) if !words.is_empty() => words.get(number as usize).is_some_and(|word| word.ends_with("CAN_FD")),
            _ => FD_FORMATS.contains(&number),
        }
    }

    /// An attribute's value, or its default; of a list of words, the index.
    fn number(&self, attribute: &str, of: Object<'_>) -> Option<f64> {
        let value = self.attributes.get(&(attribute, of)).or_else(|| self.defaults.get(attribute))?;
        match value {
            AttributeValue::Number(number) => Some(*number),
            AttributeValue::Text(text) => {
                let words = self.words.get(attribute).copied().unwrap_or_default();
                let index = words.iter().position(|word| word == text).map(|index| index as f64);
                index.or_else(|| text.trim().parse().ok())
            }
        }
    }
}

/// All that notes can speak of.
fn objects<'f>(file: &'f Statements<'f>) -> BTreeSet<Object<'f>> {
    let mut known = BTreeSet::from([Object::Network]);
    known.extend(file.nodes.iter().map(|node| Object::Node(node.is)));
    for message in &file.messages {
        let Ok(id) = message.id.is.parse() else { continue };
        known.insert(Object::Message(id));
        known.extend(message.signals.iter().map(|signal| Object::Signal(id, signal.name.is)));
    }
    known
}

struct Reporter<'f, 's, 'p> {
    known: BTreeSet<Object<'f>>,
    findings: &'p mut Findings<'s>,
}

impl<'f> Reporter<'f, '_, '_> {
    fn check_exists<T>(&mut self, keyword: &str, note: &Note<'f, T>) {
        self.check_object(keyword, note.of.is, note.of.span.clone());
    }

    fn check_selection(&mut self, selection: &Selection<'f>) {
        let keyword = "SG_MUL_VAL_";
        for name in [selection.signal, selection.switch.is] {
            self.check_object(keyword, Object::Signal(selection.message, name), selection.span.clone());
        }
        if let Some((first, last)) = selection.ranges.iter().find(|(first, last)| first > last) {
            let label = format!("found {first}-{last}, expected the smaller number first");
            let hint = "the range is empty: turn it round";
            self.findings.warn(&selection.span, "no switch value is in this range", label, hint);
        }
    }

    fn check_object(&mut self, keyword: &str, of: Object<'_>, span: Range<usize>) {
        let missing = match of {
            of if self.known.contains(&of) => return,
            Object::Network | Object::EnvironmentVariable(_) => return,
            // Stands for nobody.
            Object::Node(name) if name.eq_ignore_ascii_case("Vector__XXX") => return,
            Object::Node(name) => format!("node `{name}`"),
            Object::Message(id) => format!("message with the id {id}"),
            Object::Signal(id, name) if self.known.contains(&Object::Message(id)) => {
                format!("signal `{name}` in the message with the id {id}")
            }
            Object::Signal(id, _) => format!("message with the id {id}"),
        };
        let title = format!("this {keyword} speaks of something that is not there");
        let hint = "it is passed over: take it out, or correct the id or the name";
        self.findings.warn(&span, title, format!("found no {missing}"), hint);
    }
}
