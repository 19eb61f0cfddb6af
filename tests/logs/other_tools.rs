//! Independent readers read what we write, and we read what they write:
//! python-can, tshark, and log2asc of can-utils.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use canloop::traffic::{Content, Direction, Format, Record};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;
use serde_json::{Value, json};

use crate::rig::{Log, folder, read};
use crate::traffic::log;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// python-can keeps stamps as `f64`.
const TOLERANCE_S: f64 = 2e-6;

/// Traffic whose stamps go forward, on buses that have numbers.
fn traffic() -> Log {
    let mut runner = TestRunner::deterministic();
    let mut some: Log =
        log(200).prop_filter("much", |log| log.records.len() > 120).new_tree(&mut runner).unwrap().current();
    some.records.retain(|record| !matches!(record.content, Content::Lost(_)));
    some.records.iter_mut().for_each(|record| record.bus = 0);
    let mut at = canloop::time::Instant::from_nanos(1_436_509_052_249_713_000);
    for record in &mut some.records {
        at += canloop::time::Duration::from_micros(1_357);
        record.at = at;
    }
    let buses = canloop::traffic::Buses::default();
    some.buses = buses;
    some.buses.index("can0").unwrap();
    some
}

/// What python-can should say of a record.
fn expected(record: &Record) -> Option<Value> {
    let Content::Frame(recorded) = &record.content else { return None };
    let frame = &recorded.frame;
    let is_remote = frame.kind == canloop::frame::FrameKind::Remote;
    let data: String =
        if is_remote { String::new() } else { frame.payload().iter().map(|byte| format!("{byte:02x}")).collect() };
    Some(json!({
        "id": frame.id.raw(),
        "extended": frame.id.is_extended(),
        "remote": is_remote,
        "fd": recorded.is_fd(),
        "switch": frame.kind == canloop::frame::FrameKind::FdBitRateSwitch,
        "passive": recorded.error_passive,
        "received": record.direction == Direction::Received,
        "data": data,
    }))
}

fn python(args: &[&Path], mode: &str, input: &str) -> String {
    let mut child = Command::new(Path::new(ROOT).join("scripts/python"))
        .arg(Path::new(ROOT).join("tests/logs/python_can.py"))
        .arg(mode)
        .args(args)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("scripts/python runs");
    child.stdin.take().expect("a pipe").write_all(input.as_bytes()).expect("it takes all");
    let done = child.wait_with_output().expect("it ends");
    assert!(done.status.success());
    String::from_utf8(done.stdout).expect("UTF-8")
}

#[test]
fn python_can_reads_what_we_write() {
    let (folder, log) = (folder(), traffic());
    let files = [
        ("x.asc", Format::Asc),
        ("x.blf", Format::Blf),
        ("x.log", Format::Candump),
        ("x.csv", Format::CsvPython),
        ("x.trc", Format::Trc(canloop::traffic::TrcVersion::V2_1)),
    ];
    // It stumbles over length codes above 8, and over CAN FD frames without data.
    let mut plain = log.clone();
    plain.records.retain(|record| match &record.content {
        Content::Frame(recorded) => recorded.dlc_above_8.is_none() && !(recorded.is_fd() && recorded.frame.is_empty()),
        _ => true,
    });
    let paths: Vec<_> = files.iter().map(|(name, _)| folder.path().join(name)).collect();
    for ((_, format), path) in files.iter().zip(&paths) {
        plain.write(path, *format);
    }
    let said = python(&paths.iter().map(|path| path.as_path()).collect::<Vec<_>>(), "read", "");
    let mut by_file: BTreeMap<String, Vec<Value>> = BTreeMap::new();
    for line in said.lines() {
        let value: Value = serde_json::from_str(line).expect("JSON");
        by_file.entry(value["file"].as_str().unwrap().to_owned()).or_default().push(value);
    }
    for (name, format) in files {
        let holds = |record: &&Record| match &record.content {
            Content::Frame(recorded) => format != Format::CsvPython || !recorded.is_fd(),
            // Error frames in TRC files it passes over.
            _ => !matches!(format, Format::Trc(_)),
        };
        let wanted: Vec<&Record> = plain.records.iter().filter(holds).collect();
        let found = &by_file[name];
        assert_eq!(found.len(), wanted.len(), "{format}");
        for (record, found) in wanted.iter().zip(found) {
            let line = plain.line(record);
            let late = found["time"].as_f64().unwrap() - record.at.as_secs_f64();
            assert!(late.abs() < TOLERANCE_S, "{format}: {late} s late: {line}");
            let Some(expected) = expected(record) else {
                // Of a candump log it knows errors of the bus only.
                let known = format != Format::Candump
                    || matches!(record.content, Content::Error(error) if error.class & 0x80 != 0);
                assert!(found["error"] == true || !known, "{format}: {line}");
                continue;
            };
            for (key, value) in expected.as_object().unwrap() {
                // A direction its CSV has no column for; of TRC it reads data of CAN FD, but no length of it.
                if format != Format::CsvPython || key != "received" {
                    assert_eq!(&found[key], value, "{format}: {key} of {line}");
                }
            }
        }
    }
}

#[test]
fn we_read_what_python_can_writes() {
    let (folder, log) = (folder(), traffic());
    let mut input = String::new();
    let mut written = Vec::new();
    for record in &log.records {
        let Content::Frame(recorded) = &record.content else { continue };
        // It has no place for a length code above 8, and writes no length of remote requests.
        if recorded.dlc_above_8.is_some()
            || recorded.frame.kind == canloop::frame::FrameKind::Remote && !recorded.frame.is_empty()
        {
            continue;
        }
        let mut message = expected(record).unwrap();
        message["time"] = record.at.as_secs_f64().into();
        message["channel"] = 0.into();
        message["error"] = false.into();
        input += &format!("{message}\n");
        written.push(*record);
    }
    python(&[folder.path()], "write", &input);
    for name in ["p.asc", "p.blf", "p.trc", "p.log", "p.csv"] {
        let is_plain_only = matches!(name, "p.trc" | "p.csv");
        let is_plain = |record: &&Record| matches!(record.frame(), Some(frame) if frame.kind == canloop::frame::FrameKind::Classic);
        let wanted: Vec<&Record> = written.iter().filter(|record| !is_plain_only || is_plain(record)).collect();
        let back = read(&folder.path().join(name), None);
        assert!(back.findings.is_empty(), "{name}: {:?}", back.findings);
        assert_eq!(back.log.records.len(), wanted.len(), "{name}");
        for (record, found) in wanted.iter().zip(&back.log.records) {
            let lines = format!("{name}: {}\n{}", log.line(record), back.log.line(found));
            assert_eq!(record.content, found.content, "{lines}");
            assert!(name == "p.csv" || record.direction == found.direction, "{lines}");
            // The date in its ASC has milliseconds, its stamps count from within one.
            let tolerance_s = if name == "p.asc" { 1e-3 } else { TOLERANCE_S };
            assert!(((record.at - found.at).as_secs_f64()).abs() < tolerance_s, "{lines}");
        }
        assert_eq!(back.log.buses.names(), ["can0"], "{name}");
    }
}

#[test]
fn tshark_reads_our_captures() {
    let (folder, log) = (folder(), traffic());
    for (name, format) in [("x.pcap", Format::Pcap), ("x.pcapng", Format::Pcapng)] {
        let path = folder.path().join(name);
        log.write(&path, format);
        let done = Command::new("tshark")
            .args(["-r", path.to_str().unwrap(), "-T", "fields", "-E", "separator=;"])
            .args(["-e", "frame.time_epoch", "-e", "can.id", "-e", "can.flags.xtd", "-e", "can.flags.rtr"])
            .args(["-e", "can.flags.err", "-e", "can.len", "-e", "canfd.flags.brs", "-e", "canfd.flags.esi"])
            .stderr(Stdio::null())
            .output()
            .expect("tshark runs (Debian: apt-get install tshark)");
        assert!(done.status.success());
        let text = String::from_utf8(done.stdout).expect("UTF-8");
        let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split(';').collect()).collect();
        assert_eq!(lines.len(), log.records.len(), "{name}");
        for (record, fields) in log.records.iter().zip(lines) {
            let line = format!("{name}: {} {fields:?}", log.line(record));
            let at = record.at.as_nanos();
            assert_eq!(fields[0], format!("{}.{:09}", at / 1_000_000_000, at % 1_000_000_000), "{line}");
            match &record.content {
                Content::Frame(recorded) => {
                    let frame = &recorded.frame;
                    let is = |field: &str| matches!(field, "1" | "True");
                    assert_eq!(fields[1].parse::<u32>().unwrap(), frame.id.raw(), "{line}");
                    assert_eq!(is(fields[2]), frame.id.is_extended(), "{line}");
                    assert_eq!(is(fields[3]), frame.kind == canloop::frame::FrameKind::Remote, "{line}");
                    assert_eq!(fields[5].parse::<usize>().unwrap(), frame.len(), "{line}");
                    assert_eq!(is(fields[6]), frame.kind == canloop::frame::FrameKind::FdBitRateSwitch, "{line}");
                    assert_eq!(is(fields[7]), recorded.error_passive, "{line}");
                }
                _ => assert!(matches!(fields[4], "1" | "True"), "{line}"),
            }
        }
    }
}

#[test]
fn log2asc_and_asc2log_agree() {
    let (folder, mut log) = (folder(), traffic());
    // Those of Debian's can-utils know neither directions nor length codes above 8, and lose CAN FD.
    log.records.retain(|record| matches!(&record.content, Content::Frame(recorded) if !recorded.is_fd() && recorded.dlc_above_8.is_none()));
    log.records.iter_mut().for_each(|record| record.direction = Direction::Received);
    let (ours, theirs) = (folder.path().join("ours.log"), folder.path().join("theirs.asc"));
    log.write(&ours, Format::Candump);
    let done =
        Command::new("log2asc").args(["-I", ours.to_str().unwrap(), "-O", theirs.to_str().unwrap(), "can0"]).status();
    assert!(done.expect("log2asc runs (Debian: apt-get install can-utils)").success());
    let back = read(&theirs, None);
    assert!(back.findings.is_empty(), "{:?}", back.findings);
    let contents = |log: &Log| log.records.iter().map(|record| record.content).collect::<Vec<_>>();
    assert!(contents(&log) == contents(&back.log));
    // Its date has whole seconds; ours has milliseconds, so that they differ by less than that.
    let first = log.records[0].at.as_nanos() - back.log.records[0].at.as_nanos();
    assert!((0..1_000_000_000).contains(&first), "{first}");

    let (asc, again) = (folder.path().join("ours.asc"), folder.path().join("theirs.log"));
    log.write(&asc, Format::Asc);
    let done = Command::new("asc2log")
        .args(["-I", asc.to_str().unwrap(), "-O", again.to_str().unwrap()])
        .env("TZ", "UTC")
        .status();
    assert!(done.expect("asc2log runs").success());
    assert!(contents(&log) == contents(&read(&again, None).log));
}
