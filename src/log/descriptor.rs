//! Protobuf descriptors made at run time: what a reader needs to understand
//! our messages without ever having heard of canloop.

use std::collections::BTreeSet;

use prost::Message as _;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{
    DescriptorProto, EnumDescriptorProto, EnumValueDescriptorProto, FieldDescriptorProto, FileDescriptorProto,
    FileDescriptorSet,
};

/// A set with the one message `package.name` of flat optional fields, numbered
/// from 1 in order, serialised.
///
/// It is proto2, where a field that was not written differs from a zero.
pub(super) fn flat_message(package: &str, name: &str, fields: &[(&str, Type)]) -> Vec<u8> {
    let field = (1..).zip(fields).map(|(number, &(name, kind))| field(name, number, kind, None)).collect();
    let message = DescriptorProto { name: Some(name.to_owned()), field, ..DescriptorProto::default() };
    let file = FileDescriptorProto {
        name: Some(format!("{}/{name}.proto", package.replace('.', "/"))),
        package: Some(package.to_owned()),
        message_type: vec![message],
        ..FileDescriptorProto::default()
    };
    FileDescriptorSet { file: vec![file] }.encode_to_vec()
}

/// `foxglove.Log`, which viewers show as a console, with the
/// `google.protobuf.Timestamp` that it needs, serialised.
pub(super) fn foxglove_log() -> Vec<u8> {
    let timestamp = FileDescriptorProto {
        name: Some("google/protobuf/timestamp.proto".to_owned()),
        package: Some("google.protobuf".to_owned()),
        message_type: vec![DescriptorProto {
            name: Some("Timestamp".to_owned()),
            field: vec![field("seconds", 1, Type::Int64, None), field("nanos", 2, Type::Int32, None)],
            ..DescriptorProto::default()
        }],
        syntax: Some("proto3".to_owned()),
        ..FileDescriptorProto::default()
    };
    let levels = ["UNKNOWN", "DEBUG", "INFO", "WARNING", "ERROR", "FATAL"];
    let level = (0..).zip(levels).map(|(number, name)| EnumValueDescriptorProto {
        name: Some(name.to_owned()),
        number: Some(number),
        options: None,
    });
    let log = FileDescriptorProto {
        name: Some("foxglove/Log.proto".to_owned()),
        package: Some("foxglove".to_owned()),
        dependency: timestamp.name.iter().cloned().collect(),
        message_type: vec![DescriptorProto {
            name: Some("Log".to_owned()),
            field: vec![
                field("timestamp", 1, Type::Message, Some(".google.protobuf.Timestamp")),
                field("level", 2, Type::Enum, Some(".foxglove.Log.Level")),
                field("message", 3, Type::String, None),
                field("name", 4, Type::String, None),
                field("file", 5, Type::String, None),
                field("line", 6, Type::Fixed32, None),
            ],
            enum_type: vec![EnumDescriptorProto {
                name: Some("Level".to_owned()),
                value: level.collect(),
                ..EnumDescriptorProto::default()
            }],
            ..DescriptorProto::default()
        }],
        syntax: Some("proto3".to_owned()),
        ..FileDescriptorProto::default()
    };
    FileDescriptorSet { file: vec![timestamp, log] }.encode_to_vec()
}

/// The name nearest to `wanted` that protobuf allows and `taken` does not
/// have; adds it there.
pub(super) fn identifier(wanted: &str, taken: &mut BTreeSet<String>) -> String {
    let mut name: String = wanted.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !name.starts_with(|first: char| first.is_ascii_alphabetic()) {
        name.insert(0, 'x');
    }
    while !taken.insert(name.clone()) {
        name.push('_');
    }
    name
}

fn field(name: &str, number: i32, kind: Type, type_name: Option<&str>) -> FieldDescriptorProto {
    FieldDescriptorProto {
        name: Some(name.to_owned()),
        number: Some(number),
        label: Some(Label::Optional.into()),
        r#type: Some(kind.into()),
        type_name: type_name.map(str::to_owned),
        // Left to a reader it would be camel case, and `Speed1` and `Speed_1` the same name, which is an error.
        json_name: Some(name.to_owned()),
        ..FieldDescriptorProto::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_becomes_a_protobuf_identifier_that_is_not_yet_taken() {
        let mut taken = BTreeSet::new();
        let names = ["Speed_1", "Drehmoment Nm", "Drehmoment-Nm", "1st", "", "Größe"];
        let identifiers = names.map(|name| identifier(name, &mut taken));
        assert_eq!(identifiers, ["Speed_1", "Drehmoment_Nm", "Drehmoment_Nm_", "x1st", "x", "Gr__e"]);
    }
}
