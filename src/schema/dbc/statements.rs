//! The statements of a DBC file as they are written, each with its place and
//! before anybody asks what it means.

use std::ops::Range;

/// Something and where it stands.
#[derive(Clone, Debug)]
pub(super) struct At<T> {
    pub is: T,
    pub span: Range<usize>,
}

/// All statements that are of use, in the order of the file.
#[derive(Debug, Default)]
pub(super) struct Statements<'t> {
    pub nodes: Vec<At<&'t str>>,
    pub messages: Vec<Message<'t>>,
    pub comments: Vec<Note<'t, String>>,
    pub definitions: Vec<Definition<'t>>,
    /// By the attribute's name.
    pub defaults: Vec<(&'t str, AttributeValue)>,
    pub attributes: Vec<Note<'t, (&'t str, AttributeValue)>>,
    pub tables: Vec<(At<&'t str>, ValueNames)>,
    pub values: Vec<Note<'t, ValueList<'t>>>,
    pub number_types: Vec<Note<'t, u64>>,
    pub selections: Vec<Selection<'t>>,
}

/// `BO_` and the `SG_` below it.
#[derive(Debug)]
pub(super) struct Message<'t> {
    /// With its flag bits.
    pub id: At<&'t str>,
    pub name: At<&'t str>,
    pub len: At<&'t str>,
    pub sender: At<&'t str>,
    pub signals: Vec<Signal<'t>>,
}

/// `SG_`.
#[derive(Debug)]
pub(super) struct Signal<'t> {
    pub span: Range<usize>,
    pub name: At<&'t str>,
    /// `M`, `m0`, `m0M`.
    pub multiplexing: Option<At<&'t str>>,
    pub start: usize,
    pub size: usize,
    pub is_motorola: bool,
    pub is_signed: bool,
    /// From the start bit to the sign.
    pub layout: Range<usize>,
    pub factor: f64,
    pub offset: f64,
    pub scale: Range<usize>,
    /// NaN where there is no number.
    pub minimum: f64,
    pub maximum: f64,
    pub range: Range<usize>,
    pub unit: At<String>,
}

/// Something said of an object.
#[derive(Debug)]
pub(super) struct Note<'t, T> {
    pub of: At<Object<'t>>,
    pub is: T,
}

/// What a DBC can speak of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Object<'t> {
    Network,
    Node(&'t str),
    Message(u64),
    Signal(u64, &'t str),
    EnvironmentVariable(&'t str),
}

/// `BA_DEF_`.
#[derive(Debug)]
pub(super) struct Definition<'t> {
    pub name: &'t str,
    /// The words of an ENUM.
    pub words: Vec<String>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum AttributeValue {
    Number(f64),
    Text(String),
}

/// Raw values and their names; each value with its place.
pub(super) type ValueNames = Vec<(At<i128>, String)>;

#[derive(Debug)]
pub(super) enum ValueList<'t> {
    Names(ValueNames),
    /// By the name of a `VAL_TABLE_`.
    Table(At<&'t str>),
}

/// `SG_MUL_VAL_`.
#[derive(Debug)]
pub(super) struct Selection<'t> {
    pub message: u64,
    pub signal: &'t str,
    pub switch: At<&'t str>,
    /// First and last of each range.
    pub ranges: Vec<(u64, u64)>,
    pub span: Range<usize>,
}
