//! From the statements of a DBC file to messages whose signals can be read and
//! written safely, and what is wrong with them.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::multiplexing;
use super::notes::Notes;
use super::statements::{Message, Object, Signal as Statement, Statements};
use super::{MessageLayout, grammar, overlaps};
use crate::config::{Problem, Source};
use crate::frame::{CanId, Frame};
use crate::schema::bits::{Bits, ByteOrder};
use crate::schema::codec::Plan;
use crate::schema::signal::{RawKind, Selector, Signal};

/// Vector's tools park signals that belong to no message in one of this name,
/// with an id that cannot be sent.
const PARKED_SIGNALS: &str = "VECTOR__INDEPENDENT_SIG_MSG";
/// Stands for a sender that nobody knows.
const NOBODY: &str = "Vector__XXX";
/// The bit that marks a 29-bit id in a DBC.
const EXTENDED: u32 = 1 << 31;
/// Whole numbers up to this are exact in an `f64`.
const EXACT: f64 = 9_007_199_254_740_992.0;

/// What a DBC file holds.
#[derive(Default)]
pub(super) struct Contents {
    /// In the order of the file.
    pub messages: Vec<MessageLayout>,
    /// Signals that belong to no message.
    pub parked: Vec<Signal>,
    /// In the order of the file.
    pub findings: Vec<Problem>,
}

/// Reads a DBC file as far as it makes sense.
pub(super) fn contents(source: &Arc<Source>) -> Contents {
    let mut findings = Vec::new();
    let file = grammar::statements(source, &mut findings);
    let notes = Notes::new(&file, source, &mut findings);
    let mut reader = Reader { source, file: &file, notes, contents: Contents { findings, ..Contents::default() } };
    reader.read();
    let mut contents = reader.contents;
    contents.findings.sort_by_key(|problem| problem.place.as_ref().map_or(0, |(_, span)| span.start));
    contents
}

struct Reader<'f> {
    source: &'f Arc<Source>,
    file: &'f Statements<'f>,
    notes: Notes<'f>,
    contents: Contents,
}

impl<'f> Reader<'f> {
    fn read(&mut self) {
        let mut ids = Unique::new("id");
        let mut names = Unique::new("name");
        for message in &self.file.messages {
            if message.name.is == PARKED_SIGNALS {
                self.park(message);
                continue;
            }
            let Some((id, number)) = self.id(message) else { continue };
            self.unique(&mut ids, id.to_string(), message.id.span.clone());
            let name = self.notes.long_name(Object::Message(number)).unwrap_or_else(|| message.name.is.to_owned());
            self.unique(&mut names, name.clone(), message.name.span.clone());
            let layout = self.message(message, id, number, name);
            self.contents.messages.extend(layout);
        }
    }

    fn error(&mut self, span: &Range<usize>, title: String, label: String) {
        self.contents.findings.push(Problem::at(self.source, span.clone(), title, label));
    }

    fn warn(&mut self, span: &Range<usize>, title: String, label: String) {
        self.contents.findings.push(Problem::at(self.source, span.clone(), title, label).warning());
    }

    fn unique(&mut self, known: &mut Unique, key: String, span: Range<usize>) {
        if let Some(earlier) = known.met.get(&key) {
            let line = self.source.text[..earlier.start].matches('\n').count() + 1;
            let title = format!("the {} {key} is given twice", known.what);
            self.error(&span, title, format!("found {key} again, first given in line {line}"));
        } else {
            known.met.insert(key, span);
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
            let mut problem = Problem::at(self.source, message.id.span.clone(), "no frame can have this id", label);
            if let Some(id @ 0x800..=0x1FFF_FFFF) = number {
                problem = problem.help(format!("for the extended id 0x{id:X} write {}", EXTENDED | id));
            }
            self.contents.findings.push(problem);
        }
        Some((id?, number?.into()))
    }

    /// Keeps the signals of a message that is none.
    fn park(&mut self, message: &Message<'f>) {
        let id = message.id.is.parse().unwrap_or(0);
        let before = self.contents.findings.len();
        let signals: Vec<_> =
            message.signals.iter().filter_map(|signal| self.signal(message.name.is, id, signal)).collect();
        self.contents.parked.extend(signals);
        // Nobody reads or writes them, so nothing about them can go wrong.
        self.contents.findings.truncate(before);
    }

    fn message(&mut self, message: &Message<'f>, id: CanId, number: u64, name: String) -> Option<MessageLayout> {
        let Some(len) = message.len.is.parse::<u16>().ok().map(usize::from) else {
            let title = format!("{name} has no length");
            self.error(&message.len.span, title, format!("found {}, expected a number of bytes", message.len.is));
            return None;
        };
        if len > Frame::CAPACITY {
            let title = format!("{name} is longer than a frame");
            let label = format!("found {len} bytes, expected at most 64, unless a transport protocol carries it");
            self.warn(&message.len.span, title, label);
        }
        let (mut selectors, doubts) = multiplexing::selectors(message, number, &self.notes);
        for doubt in doubts {
            self.warn(&message.signals[doubt.signal].span, doubt.title, doubt.label);
        }
        let mut names = Unique::new("signal name");
        let mut signals = Vec::new();
        // Where each statement's signal is in `signals`.
        let mut places = vec![None; message.signals.len()];
        for (index, statement) in message.signals.iter().enumerate() {
            let Some(signal) = self.signal(&name, number, statement) else { continue };
            self.unique(&mut names, signal.name.clone(), statement.name.span.clone());
            self.check_fit(&name, len, &signal, statement);
            places[index] = Some(signals.len());
            signals.push(Signal { selector: selectors[index].take(), ..signal });
        }
        for signal in &mut signals {
            signal.selector = signal
                .selector
                .take()
                .and_then(|selector| places[selector.switch].map(|switch| Selector { switch, ..selector }));
        }
        let layout = MessageLayout {
            id,
            short_name: message.name.is.to_owned(),
            name,
            len,
            is_fd: self.notes.is_fd(number),
            comment: self.notes.comment(Object::Message(number)),
            cycle: self.notes.cycle(number),
            sender: self.sender(message.sender),
            signals,
            plan: Plan::default(),
        }
        .compiled();
        let statements: Vec<_> = places.iter().zip(&message.signals).filter(|(place, _)| place.is_some()).collect();
        for (first, second) in overlaps::overlaps(&layout) {
            let (first_name, second_name) = (&layout.signals[first].name, &layout.signals[second].name);
            let title = format!("{first_name} and {second_name} of {} overlap", layout.name);
            let label = format!("found bits that {first_name} has too, and both can be in one frame");
            let span = statements[second].1.layout.clone();
            self.error(&span, title, label);
        }
        Some(layout)
    }

    fn sender(&self, node: &str) -> String {
        if node == NOBODY {
            return node.to_owned();
        }
        self.notes.long_name(Object::Node(node)).unwrap_or_else(|| node.to_owned())
    }

    fn check_fit(&mut self, message: &str, len: usize, signal: &Signal, statement: &Statement<'_>) {
        let end = signal.end_byte();
        if end > len {
            let title = format!("{message}.{} does not fit its message", signal.name);
            let label = format!("found bits in byte {end} (from 1), expected none past byte {len}");
            self.error(&statement.layout, title, label);
        }
    }

    /// The signal, or nothing when it can have no value.
    fn signal(&mut self, message: &str, id: u64, statement: &Statement<'f>) -> Option<Signal> {
        let object = Object::Signal(id, statement.name.is);
        let short_name = statement.name.is.to_owned();
        let name = self.notes.long_name(object).unwrap_or_else(|| short_name.clone());
        let shown = format!("{message}.{name}");
        let &Statement { start, size, factor, offset, minimum, maximum, .. } = statement;
        let byte_order = if statement.is_motorola { ByteOrder::Motorola } else { ByteOrder::Intel };
        let Some(bits) = Bits::new(start, size, byte_order) else {
            let label = format!("found {size} bits from bit {start}, expected 1 bit or more inside a message");
            self.error(&statement.layout, format!("{shown} has no usable size"), label);
            return None;
        };
        if !factor.is_finite() || factor == 0.0 || !offset.is_finite() {
            let label = format!("found ({factor},{offset}), expected finite numbers, the factor not 0");
            self.error(&statement.scale, format!("{shown} has no usable factor and offset"), label);
        }
        if minimum > maximum {
            let label = format!("found {minimum} above {maximum}; it is taken to have no range");
            self.warn(&statement.range, format!("the range of {shown} is upside down"), label);
        }
        let has_range = minimum <= maximum;
        let kind = self.kind(&shown, object, statement);
        Some(Signal {
            name,
            short_name,
            unit: statement.unit.is.clone(),
            comment: self.notes.comment(object),
            minimum: if has_range { minimum } else { 0.0 },
            maximum: if has_range { maximum } else { 0.0 },
            factor,
            offset,
            value_names: self.value_names(&shown, object, kind, size),
            start_value: self.notes.start_value(id, statement.name.is),
            selector: None,
            start_bit: start,
            byte_order,
            kind,
            bits,
            scale_exactly: needs_exact_scale(kind, size, factor, offset),
        })
    }

    /// How the bits make a number. The size tells the two kinds of
    /// floating-point apart; that is what other readers go by.
    fn kind(&mut self, shown: &str, object: Object<'_>, statement: &Statement<'_>) -> RawKind {
        let size = statement.size;
        let whole = if statement.is_signed { RawKind::Signed } else { RawKind::Unsigned };
        let number_type = self.notes.number_type(object);
        match (number_type, size) {
            (_, 65..) => {
                let label = format!("found {size} bits, expected at most 64; it is passed over");
                self.warn(&statement.layout, format!("{shown} is too wide for a number"), label);
                whole
            }
            (0, _) => whole,
            (1 | 2, 32 | 64) => {
                let kind = if size == 32 { RawKind::Float32 } else { RawKind::Float64 };
                if (number_type == 1) != (size == 32) {
                    let label = format!("found {size} bits, but SIG_VALTYPE_ {number_type}; the size is believed");
                    self.warn(&statement.layout, format!("{shown} is floating-point of another size"), label);
                }
                kind
            }
            (1 | 2, _) => {
                let label = format!("found {size} bits, expected {} as SIG_VALTYPE_ says", 32 * number_type);
                self.error(&statement.layout, format!("{shown} is floating-point of the wrong size"), label);
                whole
            }
            _ => {
                let label = format!("found SIG_VALTYPE_ {number_type} for it, taken as 0, which is a whole number");
                self.warn(&statement.layout, format!("{shown} has a type that nobody knows"), label);
                whole
            }
        }
    }

    /// The names of raw values. A value that is named twice has the last name.
    fn value_names(&mut self, shown: &str, object: Object<'_>, kind: RawKind, size: usize) -> Vec<(i64, String)> {
        let Some(given) = self.notes.value_names(object) else { return Vec::new() };
        let mut names: Vec<(i64, String)> = Vec::new();
        for (value, name) in given {
            let Some(raw) = i64::try_from(value.is).ok().or_else(|| u64::try_from(value.is).ok().map(|raw| raw as i64))
            else {
                self.warn(&value.span, format!("{shown} cannot have this value"), format!("found {}", value.is));
                continue;
            };
            if !can_hold(kind, size, value.is) {
                let label = format!("found {}, which is past what {size} bits hold", value.is);
                self.warn(&value.span, format!("{shown} cannot have this value"), label);
            }
            match names.iter_mut().find(|(known, _)| *known == raw) {
                Some((_, known)) => {
                    let label = format!("found {}, which is `{known}` already; the last name is believed", value.is);
                    *known = name.clone();
                    self.warn(&value.span, format!("a value of {shown} is named twice"), label);
                }
                None => names.push((raw, name.clone())),
            }
        }
        names
    }
}

/// Whether a signal can have this raw value.
fn can_hold(kind: RawKind, size: usize, value: i128) -> bool {
    let size = size.min(64);
    match kind {
        RawKind::Unsigned => (0..1_i128 << size).contains(&value),
        RawKind::Signed => (-(1_i128 << (size - 1))..1_i128 << (size - 1)).contains(&value),
        RawKind::Float32 | RawKind::Float64 => true,
    }
}

/// Whether whole numbers on the way from raw to physical may be too large for
/// an `f64`.
fn needs_exact_scale(kind: RawKind, size: usize, factor: f64, offset: f64) -> bool {
    let is_whole = |number: f64| number.trunc() == number && number.abs() < EXACT;
    let largest = libm::ldexp(factor.abs(), size.min(64) as i32) + offset.abs();
    matches!(kind, RawKind::Unsigned | RawKind::Signed)
        && is_whole(factor)
        && is_whole(offset)
        && largest > EXACT
        && (factor, offset) != (1.0, 0.0)
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
