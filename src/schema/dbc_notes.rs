//! What a DBC file says of its messages and signals after it has laid them
//! out: comments, value names, number types and cycle times.

use std::collections::BTreeMap;

use can_dbc::{AttributeValue, Comment, MessageId, NumericValue, SignalExtendedValueType, ValueDescription, ValueType};

use super::signal::RawKind;
use crate::time::Duration;

/// The attribute in which Vector's tools, and all others since, keep a
/// message's period in milliseconds.
const CYCLE_TIME: &str = "GenMsgCycleTime";

/// A DBC's notes, by message and signal. The id is the DBC's own number, with
/// its mark for 29 bits.
pub(super) struct Notes<'f> {
    message_comments: BTreeMap<u32, &'f str>,
    signal_comments: BTreeMap<(u32, &'f str), &'f str>,
    value_names: BTreeMap<(u32, &'f str), &'f [can_dbc::ValDescription]>,
    floats: BTreeMap<(u32, &'f str), SignalExtendedValueType>,
    cycles: BTreeMap<u32, &'f AttributeValue>,
    default_cycle: Option<&'f AttributeValue>,
}

impl<'f> Notes<'f> {
    pub fn new(file: &'f can_dbc::Dbc) -> Self {
        let mut notes = Self {
            message_comments: BTreeMap::new(),
            signal_comments: BTreeMap::new(),
            value_names: BTreeMap::new(),
            floats: BTreeMap::new(),
            cycles: BTreeMap::new(),
            default_cycle: file.attribute_defaults.iter().find(|default| default.name == CYCLE_TIME).map(|d| &d.value),
        };
        for comment in &file.comments {
            match comment {
                Comment::Message { id, comment } => {
                    notes.message_comments.insert(id.raw(), comment);
                }
                Comment::Signal { message_id, name, comment } => {
                    notes.signal_comments.insert((message_id.raw(), name), comment);
                }
                _ => {}
            }
        }
        for description in &file.value_descriptions {
            if let ValueDescription::Signal { message_id, name, value_descriptions } = description {
                notes.value_names.insert((message_id.raw(), name), value_descriptions);
            }
        }
        for float in &file.signal_extended_value_type_list {
            notes.floats.insert((float.message_id.raw(), &float.signal_name), float.signal_extended_value_type);
        }
        for attribute in file.attribute_values_message.iter().filter(|attribute| attribute.name == CYCLE_TIME) {
            notes.cycles.insert(attribute.message_id.raw(), &attribute.value);
        }
        notes
    }

    pub fn message_comment(&self, id: MessageId) -> String {
        self.message_comments.get(&id.raw()).map_or_else(String::new, |text| unescaped(text))
    }

    pub fn signal_comment(&self, id: MessageId, signal: &str) -> String {
        self.signal_comments.get(&(id.raw(), signal)).map_or_else(String::new, |text| unescaped(text))
    }

    pub fn value_names(&self, id: MessageId, signal: &str) -> Vec<(i64, String)> {
        let names = self.value_names.get(&(id.raw(), signal)).copied().unwrap_or_default();
        names.iter().map(|value| (value.id, unescaped(&value.description))).collect()
    }

    pub fn raw_kind(&self, id: MessageId, signal: &can_dbc::Signal) -> RawKind {
        match (self.floats.get(&(id.raw(), signal.name.as_str())), signal.value_type) {
            (Some(SignalExtendedValueType::IEEEfloat32Bit), _) => RawKind::Float32,
            (Some(SignalExtendedValueType::IEEEdouble64bit), _) => RawKind::Float64,
            (_, ValueType::Signed) => RawKind::Signed,
            (_, ValueType::Unsigned) => RawKind::Unsigned,
        }
    }

    pub fn cycle(&self, id: MessageId) -> Option<Duration> {
        let millis = match self.cycles.get(&id.raw()).copied().or(self.default_cycle)? {
            AttributeValue::Uint(millis) => *millis as f64,
            AttributeValue::Int(millis) => *millis as f64,
            AttributeValue::Double(millis) => *millis,
            AttributeValue::String(_) => return None,
        };
        (millis > 0.0).then(|| Duration::from_secs_f64(millis / 1e3))
    }
}

/// A number of the DBC as the nearest `f64`.
pub(super) const fn number(value: NumericValue) -> f64 {
    match value {
        NumericValue::Uint(value) => value as f64,
        NumericValue::Int(value) => value as f64,
        NumericValue::Double(value) => value,
    }
}

fn unescaped(text: &str) -> String {
    text.replace("\\\"", "\"")
}
