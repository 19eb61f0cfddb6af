//! cantools, an independent implementation, finds the same messages in DBC
//! files from anywhere, and reads and writes the same numbers.
//!
//! Files are those of tests/dbc, and those of a corpus where there is one:
//! ../shared/corpus/dbc, or the folder in CANLOOP_CORPUS.

#[path = "dbc_files/mod.rs"]
mod dbc_files;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use canloop::frame::Frame;
use canloop::schema::{ByteOrder, Dbc, Encoding, MessageLayout, OutOfRange, RawKind, Signal, Value};
use serde::Deserialize;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// Random payloads a message.
const PAYLOADS: usize = 100;

/// What tests/dbc_agrees_with_cantools.py says of a message.
#[derive(Deserialize)]
struct TheirMessage {
    name: String,
    id: u32,
    extended: bool,
    fd: bool,
    length: usize,
    cycle_ms: Option<f64>,
    signals: Vec<TheirSignal>,
    exchanges: Option<Vec<Exchange>>,
}

/// Payload, decoded unless the switches select nothing, encoded unless that
/// fails. Numbers are the digits of a binary64, unless there is none.
#[derive(Deserialize)]
struct Exchange(String, Option<BTreeMap<String, Option<String>>>, Option<String>);

#[derive(Debug, Deserialize, PartialEq)]
struct TheirSignal {
    name: String,
    start: usize,
    length: u32,
    motorola: bool,
    signed: bool,
    float: bool,
    factor: String,
    offset: String,
    range: Option<(String, String)>,
    unit: String,
    start_value: Option<String>,
    names: Vec<(String, String)>,
    switch: Option<String>,
    switch_values: Vec<u64>,
}

#[test]
fn on_files_of_our_own() {
    assert_agreement(&dbc_files::below(&Path::new(ROOT).join("tests/dbc")));
}

#[test]
fn on_the_shipped_files() {
    assert_agreement(&dbc_files::below(&Path::new(ROOT).join("dbc")));
}

#[test]
fn on_the_corpus() {
    if let Some(files) = dbc_files::corpus() {
        assert_agreement(&files);
    }
}

fn assert_agreement(files: &[PathBuf]) {
    let script = format!("{ROOT}/tests/dbc_agrees_with_cantools.py");
    let mut python = Command::new(format!("{ROOT}/scripts/python"));
    let output = python.arg(script).arg(PAYLOADS.to_string()).args(files).output().expect("scripts/python runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines = String::from_utf8(output.stdout).unwrap();
    assert_eq!(lines.lines().count(), files.len());
    let mut disagreements = Vec::new();
    for (file, line) in files.iter().zip(lines.lines()) {
        let theirs: Option<Vec<TheirMessage>> = serde_json::from_str(line).expect("the script answers in JSON");
        let (ours, _) = Dbc::parse_leniently(&Dbc::read_source(file).unwrap());
        if let Some(theirs) = theirs
            && let Err(disagreement) = compare(&ours, &theirs)
        {
            disagreements.push(format!("{}: {disagreement}", file.display()));
        }
    }
    assert!(disagreements.is_empty(), "{}", disagreements.join("\n"));
}

fn compare(ours: &Dbc, theirs: &[TheirMessage]) -> Result<(), String> {
    let names = |dbc: &Dbc| dbc.messages.iter().map(|message| message.name.clone()).collect::<Vec<_>>();
    same("messages", names(ours), theirs.iter().map(|message| message.name.clone()).collect())?;
    for (ours, theirs) in ours.messages.iter().zip(theirs) {
        compare_message(ours, theirs).map_err(|disagreement| format!("{}: {disagreement}", theirs.name))?;
    }
    Ok(())
}

fn compare_message(ours: &MessageLayout, theirs: &TheirMessage) -> Result<(), String> {
    same("id", (ours.id.raw(), ours.id.is_extended()), (theirs.id, theirs.extended))?;
    same("length", ours.len, theirs.length)?;
    same("fd", ours.is_fd, theirs.fd)?;
    let cycle_ms = ours.cycle.map(|cycle| cycle.as_nanos() as f64 / 1e6);
    same("cycle", cycle_ms, theirs.cycle_ms.filter(|cycle_ms| *cycle_ms > 0.0))?;
    same("signal count", ours.signals.len(), theirs.signals.len())?;
    for theirs in &theirs.signals {
        // Some files give a name twice.
        let is_it = |signal: &&Signal| signal.name == theirs.name && signal.start_bit == theirs.start;
        let signal = ours.signals.iter().find(is_it).ok_or_else(|| format!("no signal {}", theirs.name))?;
        compare_signal(described(ours, signal), theirs)?;
    }
    let names: BTreeSet<&str> = ours.signals.iter().map(|signal| signal.name.as_str()).collect();
    if names.len() < ours.signals.len() {
        return Ok(());
    }
    for exchange in theirs.exchanges.iter().flatten() {
        compare_exchange(ours, exchange).map_err(|disagreement| format!("{}: {disagreement}", exchange.0))?;
    }
    Ok(())
}

fn compare_signal(mut ours: TheirSignal, theirs: &TheirSignal) -> Result<(), String> {
    if theirs.start_value.is_none() {
        // They do not look at the default of the attribute.
        ours.start_value = None;
    }
    same("signal", &ours, theirs)
}

/// Our signal in their words.
fn described(message: &MessageLayout, signal: &Signal) -> TheirSignal {
    let has_range = signal.minimum != signal.maximum;
    let is_whole_word = signal.kind == RawKind::Unsigned && signal.bit_count() == 64;
    let number = |raw: i64| if is_whole_word { (raw as u64).to_string() } else { raw.to_string() };
    let mut names: Vec<_> = signal.value_names.iter().map(|(raw, name)| (number(*raw), name.clone())).collect();
    names.sort();
    let values = signal.selector.iter().flat_map(|selector| selector.values.iter().cloned().flatten());
    let mut switch_values: Vec<u64> = values.collect();
    switch_values.sort_unstable();
    TheirSignal {
        name: signal.name.clone(),
        start: signal.start_bit,
        length: signal.bit_count(),
        motorola: signal.byte_order == ByteOrder::Motorola,
        signed: signal.kind == RawKind::Signed,
        float: signal.is_float(),
        factor: digits(signal.factor),
        offset: digits(signal.offset),
        range: has_range.then(|| (digits(signal.minimum), digits(signal.maximum))),
        unit: signal.unit.clone(),
        start_value: signal.start_value.map(digits),
        names,
        switch: signal.selector.as_ref().map(|selector| message.signals[selector.switch].name.clone()),
        switch_values,
    }
}

fn compare_exchange(message: &MessageLayout, Exchange(payload, theirs, encoded): &Exchange) -> Result<(), String> {
    let payload = bytes(payload);
    let ours: BTreeMap<&str, f64> =
        message.decode_payload(&payload).map(|(signal, value)| (signal.name.as_str(), value)).collect();
    if payload.len() <= Frame::CAPACITY {
        let mut frame = Frame::zeroed(message.id, payload.len());
        frame.payload_mut().copy_from_slice(&payload);
        let framed = message.decode(&frame).map(|(signal, value)| (signal.name.as_str(), digits(value)));
        same(
            "frame",
            framed.collect(),
            ours.iter().map(|(name, value)| (*name, digits(*value))).collect::<BTreeMap<_, _>>(),
        )?;
    }
    // They refuse a switch value that selects nothing; we read what is there.
    let Some(theirs) = theirs else { return Ok(()) };
    let theirs: BTreeMap<&str, &String> = theirs
        .iter()
        .filter(|(name, _)| message.signal(name).is_some_and(|signal| !signal.is_wide()))
        .filter_map(|(name, value)| Some((name.as_str(), value.as_ref()?)))
        .collect();
    same("signals", ours.keys().collect::<Vec<_>>(), theirs.keys().collect())?;
    for (name, value) in &ours {
        let theirs = f64::from_bits(u64::from_str_radix(theirs[name], 16).unwrap());
        if !(value.is_nan() && theirs.is_nan()) {
            same(name, digits(*value), digits(theirs))?;
        }
    }
    // NaN has no one way to be written, and wide signals are none of ours.
    let (Some(encoded), false) = (encoded, ours.values().any(|value| value.is_nan())) else { return Ok(()) };
    if message.signals.iter().any(Signal::is_wide) {
        return Ok(());
    }
    let values: Vec<(&str, Value<'_>)> = ours
        .iter()
        .map(|(name, value)| {
            let signal = message.signal(name).unwrap();
            // Their whole numbers are as wide as need be.
            let is_whole = !signal.is_float() && signal.factor.fract() == 0.0 && signal.offset.fract() == 0.0;
            let value = if is_whole { Value::Raw(signal.decode_raw(&payload)) } else { Value::Physical(*value) };
            (*name, value)
        })
        .collect();
    let how = Encoding { out_of_range: OutOfRange::Refuse, ..Encoding::default() };
    let mut written = vec![0xA5; message.len];
    message.encode_payload(&mut written, &values, how).map_err(|error| error.to_string())?;
    same("encoded", hex(&written), encoded.clone())
}

fn same<T: PartialEq + std::fmt::Debug>(what: &str, ours: T, theirs: T) -> Result<(), String> {
    if ours == theirs { Ok(()) } else { Err(format!("{what}: {ours:?}, cantools {theirs:?}")) }
}

fn digits(number: f64) -> String {
    format!("{:016x}", number.to_bits())
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len() / 2).map(|at| u8::from_str_radix(&hex[2 * at..2 * at + 2], 16).unwrap()).collect()
}
