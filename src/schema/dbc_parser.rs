//! From the text of a DBC file to checked messages. The grammar is the
//! `can-dbc` crate's, which takes any meaning; the checks are ours.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::bits::{Bits, ByteOrder, touched_bytes};
use super::dbc::MessageLayout;
use super::dbc_notes::{Notes, number};
use super::dbc_syntax;
use super::signal::{RawKind, Signal};
use super::statements::{self, MessageStatement};
use crate::config::{Problem, Problems, Source};
use crate::frame::{CanId, Frame};

/// Vector's tools park signals that belong to no message in one of this name,
/// with an id that cannot be sent.
const PARKED_SIGNALS: &str = "VECTOR__INDEPENDENT_SIG_MSG";
/// The bit that marks a 29-bit id in a DBC.
const EXTENDED: u32 = 1 << 31;

/// All messages of a DBC file, in its order.
pub(super) fn messages(source: &Arc<Source>) -> Result<Vec<MessageLayout>, Problems> {
    let text = dbc_syntax::without_byte_order_mark(&source.text);
    let file = dbc_syntax::parse(source, &text)?;
    let statements = statements::messages(&text);
    if !in_step(&statements, &file.messages) {
        let label = "expected each BO_ and each SG_ at the beginning of a line of its own";
        return Err(Problem::at(source, 0..0, "two statements share a line", label).into());
    }
    let notes = Notes::new(&file);
    let mut checker = Checker { source, problems: Vec::new() };
    let mut ids = Unique::new("id");
    let mut names = Unique::new("name");
    let mut messages = Vec::new();
    for (statement, message) in statements.iter().zip(&file.messages) {
        if message.name == PARKED_SIGNALS {
            continue;
        }
        checker.unique(&mut names, message.name.clone(), statement.span.clone());
        let Some(id) = checker.id(statement) else { continue };
        checker.unique(&mut ids, id.to_string(), statement.span.clone());
        messages.extend(checker.message(statement, id, message, &notes));
    }
    if checker.problems.is_empty() { Ok(messages) } else { Err(Problems(checker.problems)) }
}

/// Whether the statements found by line are those found by grammar.
fn in_step(statements: &[MessageStatement<'_>], messages: &[can_dbc::Message]) -> bool {
    statements.len() == messages.len()
        && statements.iter().zip(messages).all(|(statement, message)| statement.signals.len() == message.signals.len())
}

/// What has been met of a kind that must not be met twice, and where.
struct Unique {
    what: &'static str,
    met: BTreeMap<String, Range<usize>>,
}

struct Checker<'s> {
    source: &'s Arc<Source>,
    problems: Vec<Problem>,
}

impl Checker<'_> {
    fn report(&mut self, span: &Range<usize>, title: String, label: String) {
        self.problems.push(Problem::at(self.source, span.clone(), title, label));
    }

    fn unique(&mut self, known: &mut Unique, key: String, span: Range<usize>) {
        if let Some(earlier) = known.met.get(&key) {
            let line = self.source.text[..earlier.start].matches('\n').count() + 1;
            let title = format!("the {} {key} is given twice", known.what);
            self.report(&span, title, format!("found {key} again, first given in line {line}"));
        } else {
            known.met.insert(key, span);
        }
    }

    fn id(&mut self, statement: &MessageStatement<'_>) -> Option<CanId> {
        let id = match statement.id.parse::<u32>() {
            Ok(id @ 0..=0x7FF) => Some(CanId::Standard(id as u16)),
            Ok(id) if (EXTENDED..=EXTENDED | 0x1FFF_FFFF).contains(&id) => Some(CanId::Extended(id & 0x1FFF_FFFF)),
            _ => None,
        };
        if id.is_none() {
            let label = format!("found {}, expected 0 to 2047, or 2147483648 plus an extended id", statement.id);
            self.report(&statement.span, "no frame can have this id".to_owned(), label);
        }
        id
    }

    /// The checked message, or nothing when a problem was reported.
    fn message(
        &mut self,
        statement: &MessageStatement<'_>,
        id: CanId,
        message: &can_dbc::Message,
        notes: &Notes<'_>,
    ) -> Option<MessageLayout> {
        let Some(len) = usize::try_from(message.size).ok().filter(|len| *len <= Frame::CAPACITY) else {
            let title = format!("{} is longer than a frame", message.name);
            self.report(&statement.span, title, format!("found {} bytes, expected at most 64", message.size));
            return None;
        };
        let mut names = Unique::new("signal name");
        let mut signals = Vec::new();
        for (span, signal) in statement.signals.iter().zip(&message.signals) {
            self.unique(&mut names, signal.name.clone(), span.clone());
            signals.extend(self.signal(span, len, message, signal, notes));
        }
        Some(MessageLayout {
            id,
            name: message.name.clone(),
            len,
            comment: notes.message_comment(message.id),
            cycle: notes.cycle(message.id),
            sender: message.transmitter.clone().unwrap_or_default(),
            signals,
        })
    }

    /// The checked signal, or nothing when a problem was reported.
    fn signal(
        &mut self,
        span: &Range<usize>,
        message_len: usize,
        message: &can_dbc::Message,
        signal: &can_dbc::Signal,
        notes: &Notes<'_>,
    ) -> Option<Signal> {
        let name = format!("{}.{}", message.name, signal.name);
        let byte_order = match signal.byte_order {
            can_dbc::ByteOrder::LittleEndian => ByteOrder::Intel,
            can_dbc::ByteOrder::BigEndian => ByteOrder::Motorola,
        };
        if !(1..=64).contains(&signal.size) {
            self.report(
                span,
                format!("{name} has no usable size"),
                format!("found {} bits, expected 1 to 64", signal.size),
            );
            return None;
        }
        let start_bit = usize::try_from(signal.start_bit).unwrap_or(usize::MAX);
        let size = signal.size as usize;
        let end = touched_bytes(start_bit, size, byte_order).map_or(usize::MAX, |bytes| bytes.end);
        let Some(bits) = Bits::new(start_bit, size, byte_order).filter(|_| end <= message_len) else {
            let label = format!("found bits in byte {end} (from 1), expected none past byte {message_len}");
            self.report(span, format!("{name} does not fit its message"), label);
            return None;
        };
        if !signal.factor.is_finite() || signal.factor == 0.0 || !signal.offset.is_finite() {
            let label =
                format!("found ({},{}), expected finite numbers, the factor not 0", signal.factor, signal.offset);
            self.report(span, format!("{name} has no usable factor and offset"), label);
            return None;
        }
        let kind = notes.raw_kind(message.id, signal);
        let width = match kind {
            RawKind::Float32 => 32,
            RawKind::Float64 => 64,
            RawKind::Unsigned | RawKind::Signed => size,
        };
        if size != width {
            self.report(
                span,
                format!("{name} is floating-point of the wrong size"),
                format!("found {size} bits, expected {width} as SIG_VALTYPE_ says"),
            );
            return None;
        }
        Some(Signal {
            name: signal.name.clone(),
            unit: signal.unit.clone(),
            comment: notes.signal_comment(message.id, &signal.name),
            minimum: number(signal.min),
            maximum: number(signal.max),
            factor: signal.factor,
            offset: signal.offset,
            value_names: notes.value_names(message.id, &signal.name),
            start_bit,
            byte_order,
            kind,
            bits,
        })
    }
}

impl Unique {
    const fn new(what: &'static str) -> Self {
        Self { what, met: BTreeMap::new() }
    }
}
