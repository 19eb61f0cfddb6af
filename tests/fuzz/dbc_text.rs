//! The text of a DBC file, and frames of the messages in it.

use std::path::Path;

use canloop::config::{Problem, Source};
use canloop::schema::{Dbc, Encoding, MessageLayout, Raw, Signal, Value};

use crate::harness::{Chance, Target, digest, seeds_in};

const WORDS: [&str; 40] = [
    "VERSION \"\"\n",
    "NS_ :\n",
    "BS_:",
    "BU_:",
    "BO_ 1 M: 8 A\n",
    "SG_ S : 0|8@1+ (1,0) [0|0] \"\" A\n",
    "SG_ M M : 0|8@0- (1,0) [0|0] \"\" A\n",
    "SG_ N m0M : 7|8@0- (0.1,5) [1|9] \"V\" A,B\n",
    "CM_ ",
    "CM_ BO_ ",
    "CM_ SG_ ",
    "BA_ \"GenSigStartValue\" SG_ ",
    "BA_ \"SystemSignalLongSymbol\" SG_ ",
    "BA_DEF_ ",
    "BA_DEF_DEF_ ",
    "VAL_ ",
    "VAL_TABLE_ ",
    "SIG_VALTYPE_ ",
    "SG_MUL_VAL_ ",
    "SIG_GROUP_ ",
    "EV_ ",
    "VECTOR__INDEPENDENT_SIG_MSG",
    "Vector__XXX",
    "\"",
    "\\\"",
    "//",
    ";",
    ":",
    "|",
    "@",
    "(1,0)",
    "[0|0]",
    "\u{FEFF}",
    "\r\n",
    " M ",
    " m0 ",
    "m1M",
    "-",
    "\0",
    "é",
];

#[test]
fn dbc_text() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut seeds = seeds_in(&root.join("tests/fuzz/seeds/dbc"));
    seeds.extend(seeds_in(&root.join("tests/dbc")));
    seeds.push(std::fs::read(root.join("dbc/sim.dbc")).expect("a seed"));
    Target { name: "dbc_text", seeds, words: &WORDS, share: 1.0 }.fuzz(|input| {
        let source = Source::new("fuzz.dbc", String::from_utf8_lossy(input));
        let (dbc, findings) = Dbc::check(&source);
        let _ = dbc.markdown_table();
        let mut chance = Chance(digest(input));
        dbc.messages.iter().for_each(|message| exercise(message, &mut chance));
        outcome(&dbc, &findings)
    });
}

/// Reads random payloads of a message, and writes what was read.
fn exercise(message: &MessageLayout, chance: &mut Chance) {
    let mut payload: Vec<u8> = (0..message.len.min(300)).map(|_| chance.below(256) as u8).collect();
    payload.truncate(chance.below(2 * payload.len() + 1));
    let values: Vec<_> = message.decode_payload(&payload).collect();
    assert_eq!(values.len() + message.absent(&payload).count(), message.signals.len());
    let given: Vec<(&str, Value<'_>)> = values
        .iter()
        .map(|(signal, value)| {
            (signal.name.as_str(), if value.is_nan() { raw(signal, &payload) } else { (*value).into() })
        })
        .collect();
    let mut written = vec![0x5A; message.len + 8];
    let end = written.len();
    match message.encode_payload(&mut written[..message.len], &given, Encoding::default()) {
        Ok(()) => assert_eq!(written[message.len..end], [0x5A; 8]),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    let _ = message.encode(&given, Encoding::default());
}

fn raw<'v>(signal: &Signal, payload: &[u8]) -> Value<'v> {
    match signal.decode_raw(payload) {
        Raw::Real(_) => Value::Raw(Raw::Real(0.0)),
        raw => Value::Raw(raw),
    }
}

/// Which findings there are, and roughly what else.
fn outcome(dbc: &Dbc, findings: &[Problem]) -> u64 {
    let mut kinds: Vec<String> = findings.iter().map(kind).collect();
    kinds.sort();
    kinds.dedup();
    if let Some(first) = findings.first() {
        assert!(first.position().is_some() && !first.to_string().is_empty());
    }
    for problem in findings {
        let (source, span) = problem.place.as_ref().expect("a finding in a text has a place");
        assert!(span.start <= span.end && source.text.get(span.clone()).is_some(), "{span:?} of {problem:?}");
    }
    let signals: usize = dbc.messages.iter().map(|message| message.signals.len()).sum();
    digest(format!("{kinds:?} {} {}", dbc.messages.len().min(3), signals.min(5)).as_bytes())
}

/// A title without the names in it.
fn kind(problem: &Problem) -> String {
    problem.title.split(' ').filter(|word| word.chars().all(|c| c.is_ascii_lowercase())).collect::<Vec<_>>().join(" ")
}
