//! cantools, an independent implementation, reads and writes the same
//! numbers as the codec.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use canloop::config::Source;
use canloop::frame::Frame;
use canloop::schema::{Dbc, MessageLayout, Profile, Signal};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use serde::Deserialize;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// What tests/ask_cantools.py answers; numbers as the digits of a binary64.
#[derive(Deserialize)]
struct Answer {
    decode: Vec<BTreeMap<String, String>>,
    encode: Vec<String>,
}

#[test]
fn on_every_drive_that_ships() {
    for name in Profile::builtin_names() {
        let path = Path::new(ROOT).join(format!("dbc/{name}.dbc"));
        let dbc = Dbc::parse(&Dbc::read_source(&path).unwrap()).unwrap();
        assert_agreement(&path, &dbc, 50);
    }
}

#[test]
fn on_signals_of_every_size_order_and_kind() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("many.dbc");
    let text = many_signals();
    std::fs::write(&path, &text).unwrap();
    let dbc = Dbc::parse(&Source::new("many.dbc", text)).unwrap_or_else(|problems| panic!("{problems}"));
    assert_agreement(&path, &dbc, 5);
}

/// A DBC with one signal a message: all sizes, both orders, all kinds.
fn many_signals() -> String {
    let (mut text, mut floats) = ("VERSION \"\"\n\nBU_: A B\n".to_owned(), String::new());
    let mut id = 0;
    for size in 1..=64 {
        for (order, start) in [(1, 64 - size), (1, (64 - size) / 2), (0, 7), (0, 8 * ((64 - size) / 8) + 7)] {
            for (sign, factor, offset) in
                [('+', "1", "0"), ('-', "0.005", "0"), ('-', "-0.1", "12.5"), ('+', "0.25", "-40")]
            {
                id += 1;
                writeln!(
                    text,
                    "\nBO_ {id} M{id}: 8 A\n SG_ S : {start}|{size}@{order}{sign} ({factor},{offset}) [0|0] \"\" B"
                )
                .unwrap();
                if [32, 64].contains(&size) && sign == '-' {
                    writeln!(floats, "SIG_VALTYPE_ {id} S : {};", size / 32).unwrap();
                }
            }
        }
    }
    text + "\n" + &floats
}

/// Compares `count` random frames and as many random sets of values of each
/// message.
fn assert_agreement(path: &Path, dbc: &Dbc, count: usize) {
    let mut runner = TestRunner::deterministic();
    let mut frames: Vec<(&MessageLayout, Frame)> = Vec::new();
    for message in dbc.messages.iter().flat_map(|message| std::iter::repeat_n(message, count)) {
        let bytes = prop::collection::vec(any::<u8>(), message.len).new_tree(&mut runner).unwrap().current();
        let mut frame = Frame::zeroed(message.id, message.len);
        frame.payload_mut().copy_from_slice(&bytes);
        // NaN has no one way to be written.
        if message.signals.iter().all(|signal| !signal.decode(frame.storage()).is_nan()) {
            frames.push((message, frame));
        }
    }
    let values: Vec<(&MessageLayout, BTreeMap<&str, f64>)> = frames
        .iter()
        .filter(|(message, _)| message.signals.iter().all(rounds_alike))
        .map(|(message, frame)| {
            let values = message.signals.iter().map(|signal| (signal.name.as_str(), nearby(signal, frame)));
            (*message, values.collect())
        })
        .collect();
    let answer = ask(path, &frames, &values);
    assert_eq!((answer.decode.len(), answer.encode.len()), (frames.len(), values.len()));
    for ((message, frame), decoded) in frames.iter().zip(&answer.decode) {
        for signal in &message.signals {
            let number = signal.decode(frame.storage());
            assert_eq!(
                digits(number),
                decoded[&signal.name],
                "{} {} of {frame}: {number}",
                message.name,
                signal.layout()
            );
        }
    }
    for ((message, values), encoded) in values.iter().zip(&answer.encode) {
        let mut frame = Frame::zeroed(message.id, message.len);
        for signal in &message.signals {
            signal.encode(frame.payload_mut(), values[signal.name.as_str()]);
        }
        assert_eq!(&hex(frame.payload()), encoded, "{} {values:?}", message.name);
    }
}

/// A number a third of a step off what the frame holds, which rounding must
/// bring back.
fn nearby(signal: &Signal, frame: &Frame) -> f64 {
    let off = if signal.is_float() { 0.0 } else { signal.factor / 3.0 };
    signal.decode(frame.storage()) + off
}

/// Whether a third of a step off stays clear of a half in an f64. cantools
/// rounds halves to even, this codec away from zero.
fn rounds_alike(signal: &Signal) -> bool {
    signal.is_float() || signal.bit_count() <= 48
}

fn ask(path: &Path, frames: &[(&MessageLayout, Frame)], values: &[(&MessageLayout, BTreeMap<&str, f64>)]) -> Answer {
    let decode: Vec<_> = frames.iter().map(|(message, frame)| (&message.name, hex(frame.payload()))).collect();
    let in_digits = |values: &BTreeMap<&str, f64>| -> BTreeMap<String, String> {
        values.iter().map(|(name, value)| ((*name).to_owned(), digits(*value))).collect()
    };
    let encode: Vec<_> = values.iter().map(|(message, values)| (&message.name, in_digits(values))).collect();
    let question = serde_json::json!({ "dbc": path, "decode": decode, "encode": encode });
    let mut python = Command::new(format!("{ROOT}/scripts/python"))
        .arg(format!("{ROOT}/tests/ask_cantools.py"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("scripts/python runs");
    python.stdin.take().unwrap().write_all(question.to_string().as_bytes()).unwrap();
    let output = python.wait_with_output().unwrap();
    assert!(output.status.success(), "cantools refused: see above");
    serde_json::from_slice(&output.stdout).expect("ask_cantools.py answers in JSON")
}

fn digits(number: f64) -> String {
    format!("{:016x}", number.to_bits())
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
