//! From every format to every other: the same records come back, or what is
//! missing has been said, kind by kind and to the number.

use std::collections::BTreeMap;

use canloop::traffic::{Content, Format, Loss, Losses, Record, RecordedFrame, TrcVersion, convert, create, open};
use proptest::prelude::*;
use proptest::strategy::ValueTree;

use crate::rig::{Log, WRITTEN, folder, path_for, read};
use crate::traffic::log;

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_is_read_back_or_said_to_be_lost(log in log(40)) {
        let folder = folder();
        for (format, extension) in WRITTEN {
            let path = path_for(folder.path(), "log", format, extension);
            let losses = log.write(&path, format);
            let back = read(&path, None);
            prop_assert!(back.findings.is_empty(), "{format}: {:?}", back.findings);
            same_but_for(&log, &back.log, &losses, format)?;
        }
    }

    #[test]
    fn any_format_becomes_any_other(log in log(12)) {
        let folder = folder();
        for (from, extension) in WRITTEN {
            let input = path_for(folder.path(), "in", from, extension);
            log.write(&input, from);
            let before = read(&input, None).log;
            for (to, extension) in WRITTEN {
                let output = path_for(folder.path(), "out", to, extension);
                let (_, mut reader) = open(&input, None).expect("it can be opened");
                let done = convert(reader.as_mut(), create(&output, to).expect("it can be made")).expect("it is written");
                prop_assert_eq!(done.records, before.records.len() as u64);
                prop_assert_eq!((done.errors, done.warnings), (0, 0), "{} to {}: {:?}", from, to, done.findings);
                same_but_for(&before, &read(&output, None).log, &done.losses, to)?;
            }
        }
    }
}

#[test]
fn formats_that_hold_everything_say_so() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    runner
        .run(&log(60), |log| {
            let folder = folder();
            for format in [Format::Csv, Format::Candump, Format::Mcap, Format::Pcapng, Format::Blf] {
                let losses = log.write(&folder.path().join("log"), format);
                let kinds: Vec<Loss> = losses.iter().map(|(loss, _)| loss).collect();
                let expected = |loss: &Loss| match format {
                    Format::Csv => false,
                    Format::Candump => matches!(loss, Loss::LostCounts | Loss::BusNames),
                    Format::Blf => matches!(loss, Loss::LostCounts | Loss::EarlierStamps),
                    Format::Mcap => false,
                    _ => *loss == Loss::LostCounts,
                };
                prop_assert!(kinds.iter().all(expected), "{format}: {kinds:?}");
            }
            Ok(())
        })
        .unwrap();
}

#[test]
fn what_is_lost_is_said_in_words() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let log = log(400).new_tree(&mut runner).expect("a log").current();
    let folder = folder();
    let losses = log.write(&folder.path().join("x"), Format::Trc(TrcVersion::V1_1));
    let said = losses.messages("TRC 1.1").join("\n");
    let fd = log.records.iter().filter(|record| is_fd(record)).count();
    assert!(said.contains(&format!("TRC 1.1 holds no CAN FD frames: {fd} left out")), "{said}");
    assert!(said.contains("TRC 1.1 keeps coarser stamps: "), "{said}");
}

/// That `after` is `before`, but for what `losses` name.
fn same_but_for(before: &Log, after: &Log, losses: &Losses, format: Format) -> Result<(), TestCaseError> {
    let said: BTreeMap<u8, (Loss, u64)> = losses.iter().map(|(loss, count)| (kind(loss), (loss, count))).collect();
    let mut seen: BTreeMap<u8, u64> = BTreeMap::new();
    let mut kept = Vec::new();
    for record in &before.records {
        match left_out(record, &said) {
            Some(loss) => *seen.entry(kind(loss)).or_default() += 1,
            None => kept.push(*record),
        }
    }
    let came = &after.records;
    prop_assert_eq!(kept.len(), came.len(), "{}: {:#?}\n{:#?}", format, before.lines(), after.lines());
    for (before_record, after_record) in kept.iter().zip(came) {
        let lines = format!("{format}:\n{}\n{}", before.line(before_record), after.line(after_record));
        for loss in differences(before, before_record, after, after_record)
            .map_err(|what| TestCaseError::fail(format!("{what} {lines}")))?
        {
            let kind = kind(loss);
            prop_assert!(said.contains_key(&kind), "unsaid {:?}: {}", loss, lines);
            if let (Loss::Nanoseconds(lost), Some((Loss::Nanoseconds(most), _))) = (loss, said.get(&kind)) {
                let earlier = said.contains_key(&self::kind(Loss::EarlierStamps));
                prop_assert!(earlier || (0..=*most).contains(&lost), "{} of {}: {}", lost, most, lines);
            }
            *seen.entry(kind).or_default() += 1;
        }
    }
    for (kind, (loss, count)) in said {
        let exact = !matches!(loss, Loss::Nanoseconds(_) | Loss::EarlierStamps | Loss::BusNames | Loss::Buses);
        if exact {
            prop_assert_eq!(seen.get(&kind).copied().unwrap_or(0), count, "{}: {:?}", format, loss);
        }
    }
    Ok(())
}

/// The loss that says that a record is not there.
fn left_out(record: &Record, said: &BTreeMap<u8, (Loss, u64)>) -> Option<Loss> {
    let loss = match &record.content {
        Content::Frame(_) if is_fd(record) => Loss::FdFrames,
        Content::Error(_) => Loss::ErrorFrames,
        Content::Lost(_) => Loss::LostCounts,
        Content::Frame(_) => return None,
    };
    said.contains_key(&kind(loss)).then_some(loss)
}

/// The losses that would explain how two records differ.
fn differences(before: &Log, a: &Record, after: &Log, b: &Record) -> Result<Vec<Loss>, &'static str> {
    let mut losses = Vec::new();
    if before.bus(a) != after.bus(b) {
        // Either explains it; the test asks for one that has been said.
        losses.push(Loss::BusNames);
    }
    if a.at != b.at {
        losses.push(Loss::Nanoseconds((a.at - b.at).as_nanos()));
    }
    if a.direction != b.direction {
        losses.push(Loss::Directions);
    }
    match (&a.content, &b.content) {
        (Content::Error(a), Content::Error(b)) if a != b => losses.push(Loss::ErrorDetails),
        (Content::Frame(a), Content::Frame(b)) => {
            if a.error_passive != b.error_passive {
                losses.push(Loss::ErrorPassive);
            }
            if a.dlc_above_8 != b.dlc_above_8 {
                losses.push(Loss::LengthCodes);
            }
            let frames_only = |recorded: &RecordedFrame| recorded.frame;
            if frames_only(a) != frames_only(b) {
                return Err("other frames");
            }
        }
        (a, b) if a != b => return Err("other contents"),
        _ => {}
    }
    Ok(losses)
}

fn is_fd(record: &Record) -> bool {
    matches!(&record.content, Content::Frame(recorded) if recorded.is_fd())
}

/// A number for each kind of loss; several explain the same difference.
fn kind(loss: Loss) -> u8 {
    match loss {
        Loss::FdFrames => 0,
        Loss::RemoteFrames => 1,
        Loss::ErrorFrames => 2,
        Loss::ErrorDetails => 3,
        Loss::ErrorPassive => 4,
        Loss::LengthCodes => 5,
        Loss::Directions => 6,
        Loss::Buses | Loss::BusNames => 7,
        Loss::Nanoseconds(_) | Loss::EarlierStamps => 8,
        Loss::LostCounts => 9,
    }
}
