//! From the statements of a DBC file to messages whose signals can be read and
//! written safely, and what is wrong with them.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::findings::Findings;
use super::notes::Notes;
use super::signals::SignalReader;
use super::statements::{Message, Object, Signal as Statement, Statements};
use super::{MessageLayout, grammar, lints, multiplexing, overlaps};
use crate::config::{Problem, Source};
use crate::frame::{CanId, Frame};
use crate::schema::codec::Plan;
use crate::schema::signal::{Selector, Signal};

/// Vector's tools park signals that belong to no message in one of this name,
/// with an id that cannot be sent.
const PARKED_SIGNALS: &str = "VECTOR__INDEPENDENT_SIG_MSG";
/// Stands for a sender that nobody knows.
pub(super) const NOBODY: &str = "Vector__XXX";
/// The bit that marks a 29-bit id in a DBC.
pub(super) const EXTENDED: u32 = 1 << 31;

/// What a DBC file holds.
pub(super) struct Contents {
    /// In the order of the file.
    pub messages: Vec<MessageLayout>,
    /// Signals that belong to no message.
    pub parked: Vec<Signal>,
    /// The bus's bit rate, bit/s.
    pub bit_rate: Option<u32>,
    /// In the order of the file.
    pub findings: Vec<Problem>,
}

/// Reads a DBC file as far as it makes sense. A thorough look also finds what
/// is only unusual.
pub(super) fn contents(source: &Arc<Source>, is_thorough: bool) -> Contents {
    let mut findings = Findings { source, list: Vec::new() };
    let file = grammar::statements(&mut findings);
    let notes = Notes::new(&file, &mut findings);
    if is_thorough {
        lints::nodes(&file, &mut findings);
    }
    let bit_rate = notes.bit_rate();
    let mut reader = Reader { file: &file, notes, findings, is_thorough, messages: Vec::new(), parked: Vec::new() };
    reader.read();
    let Reader { messages, parked, findings, .. } = reader;
    let mut findings = findings.list;
    findings.sort_by_key(|problem| problem.place.as_ref().map_or(0, |(_, span)| span.start));
    Contents { messages, parked, bit_rate, findings }
}

struct Reader<'f, 's> {
    file: &'f Statements<'f>,
    notes: Notes<'f>,
    findings: Findings<'s>,
    is_thorough: bool,
    messages: Vec<MessageLayout>,
    parked: Vec<Signal>,
}

impl<'f> Reader<'f, '_> {
    fn read(&mut self) {
        let mut ids = Unique::new("id");
        let mut names = Unique::new("name");
        for message in &self.file.messages {
            if message.name.is == PARKED_SIGNALS {
                self.park(message);
                continue;
            }
            let Some((id, number)) = self.id(message) else { continue };
            self.unique(&mut ids, id.to_string(), &message.id.span);
            let name = self.notes.long_name(Object::Message(number)).unwrap_or_else(|| message.name.is.to_owned());
            self.unique(&mut names, name.clone(), &message.name.span);
            let layout = self.message(message, id, number, name);
            self.messages.extend(layout);
        }
    }

    fn unique(&mut self, known: &mut Unique, key: String, span: &Range<usize>) {
        if let Some(earlier) = known.met.get(&key) {
            let line = self.findings.source.text[..earlier.start].matches('\n').count() + 1;
            let title = format!("the {} {key} is given twice", known.what);
            let label = format!("found {key} again, first given in line {line}");
            self.findings.error(span, title, label, "nobody can tell the two apart: change one of them");
        } else {
            known.met.insert(key, span.clone());
        }
    }

    /// The id, and the number that the DBC calls it by.
    fn id(&mut self, message: &Message<'_>) -> Option<(CanId, u64)> {
        let number = message.id.is.parse::<u32>().ok();
        let id = match number {
            Some(id @ 0..=0x7FF) => Some(CanId::Standard(id as u16)),
            Some(id) if (EXTENDED..=EXTENDED | 0x1FFF_FFFF).contains(&id) => Some(CanId::Extended(id & 0x1FFF_FFFF)),
            _ => None,
        };
        if id.is_none() {
            let label = format!("found {}, expected 0 to 2047, or 2147483648 plus an extended id", message.id.is);
            let hint = match number {
                Some(id @ 0x800..=0x1FFF_FFFF) => format!("for the extended id 0x{id:X} write {}", EXTENDED | id),
                _ => "the message is passed over".to_owned(),
            };
            self.findings.error(&message.id.span, "no frame can have this id", label, &hint);
        }
        Some((id?, number?.into()))
    }

    /// Keeps the signals of a message that is none. Nobody reads or writes
    /// them, so nothing about them can go wrong.
    fn park(&mut self, message: &Message<'f>) {
        let id = message.id.is.parse().unwrap_or(0);
        let mut findings = Findings { source: self.findings.source, list: Vec::new() };
        let mut reader = SignalReader { notes: &self.notes, findings: &mut findings, message: message.name.is, id };
        self.parked.extend(message.signals.iter().filter_map(|signal| reader.read(signal)));
    }

    fn message(&mut self, message: &'f Message<'f>, id: CanId, number: u64, name: String) -> Option<MessageLayout> {
        let len = self.len(message, &name)?;
        let (statements, signals) = self.signals(message, number, &name, len);
        let layout = MessageLayout {
            id,
            short_name: message.name.is.to_owned(),
            name,
            len,
            is_fd: self.notes.is_fd(number),
            comment: self.notes.comment(Object::Message(number)),
            cycle: self.notes.cycle(number),
            sender: self.sender(message.sender.is),
            signals,
            plan: Plan::default(),
        }
        .compiled();
        for (first, second) in overlaps::overlaps(&layout) {
            let (first_name, second_name) = (&layout.signals[first].name, &layout.signals[second].name);
            let title = format!("{first_name} and {second_name} of {} overlap", layout.name);
            let label = format!("found bits that {first_name} has too, and both can be in one frame");
            let hint = "move one of them, or let a multiplexer switch keep them apart";
            self.findings.error(&statements[second].layout, title, label, hint);
        }
        if self.is_thorough {
            lints::message(&layout, message, self.file, &mut self.findings);
            layout.signals.iter().zip(statements).for_each(|(signal, statement)| {
                lints::signal(&layout, signal, statement, &mut self.findings);
            });
        }
        Some(layout)
    }

    fn len(&mut self, message: &Message<'_>, name: &str) -> Option<usize> {
        let Ok(len) = message.len.is.parse::<u16>() else {
            let label = format!("found {}, expected a number of bytes", message.len.is);
            let hint = "the message is passed over: it is written as BO_ 256 Name: 8 Sender";
            self.findings.error(&message.len.span, format!("{name} has no length"), label, hint);
            return None;
        };
        let len = usize::from(len);
        if len > Frame::CAPACITY {
            let label = format!("found {len} bytes, expected at most 64");
            let hint = "it takes a transport protocol such as ISO-TP or J1939's";
            self.findings.warn(&message.len.span, format!("{name} is longer than a frame"), label, hint);
        }
        Some(len)
    }

    /// The signals of a message, and the statement that each comes from.
    fn signals(
        &mut self,
        message: &'f Message<'f>,
        id: u64,
        name: &str,
        len: usize,
    ) -> (Vec<&'f Statement<'f>>, Vec<Signal>) {
        let (mut selectors, doubts) = multiplexing::selectors(message, id, &self.notes);
        for doubt in doubts {
            self.findings.warn(&message.signals[doubt.signal].span, doubt.title, doubt.label, doubt.hint);
        }
        let mut names = Unique::new("signal name");
        let (mut statements, mut signals) = (Vec::new(), Vec::new());
        // Where each statement's signal is in `signals`.
        let mut places = vec![None; message.signals.len()];
        for (index, statement) in message.signals.iter().enumerate() {
            let mut reader = SignalReader { notes: &self.notes, findings: &mut self.findings, message: name, id };
            let Some(signal) = reader.read(statement) else { continue };
            self.unique(&mut names, signal.name.clone(), &statement.name.span);
            self.check_fit(name, len, &signal, statement);
            places[index] = Some(signals.len());
            signals.push(Signal { selector: selectors[index].take(), ..signal });
            statements.push(statement);
        }
        for signal in &mut signals {
            let moved = |selector: Selector| places[selector.switch].map(|switch| Selector { switch, ..selector });
            signal.selector = signal.selector.take().and_then(moved);
        }
        (statements, signals)
    }

    fn check_fit(&mut self, message: &str, len: usize, signal: &Signal, statement: &Statement<'_>) {
        let end = signal.end_byte();
        if end > len {
            let title = format!("{message}.{} does not fit its message", signal.name);
            let label = format!("found bits in byte {end} (from 1), expected none past byte {len}");
            let hint = "move or shorten the signal, or lengthen the message";
            self.findings.error(&statement.layout, title, label, hint);
        }
    }

    fn sender(&self, node: &str) -> String {
        if node == NOBODY {
            return node.to_owned();
        }
        self.notes.long_name(Object::Node(node)).unwrap_or_else(|| node.to_owned())
    }
}

/// What has been met of a kind that must not be met twice, and where.
struct Unique {
    what: &'static str,
    met: BTreeMap<String, Range<usize>>,
}

impl Unique {
    const fn new(what: &'static str) -> Self {
        Self { what, met: BTreeMap::new() }
    }
}
