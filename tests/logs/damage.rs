//! Logs that were cut short or damaged: what can be read is, what cannot is
//! said with its place, and nothing panics.

use std::io::Cursor;
use std::path::Path;

use canloop::traffic::{self, Format, Record};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;

use crate::rig::{Log, WRITTEN, folder, path_for, read, try_text};
use crate::traffic::log;

/// A log of some records, and the bytes of it in a format.
fn small_log(format: Format, extension: &str) -> (Vec<Record>, Vec<u8>) {
    let mut runner = TestRunner::deterministic();
    let some: Log =
        log(24).prop_filter("some records", |log| log.records.len() > 16).new_tree(&mut runner).unwrap().current();
    let folder = folder();
    let path = path_for(folder.path(), "log", format, extension);
    some.write(&path, format);
    (read(&path, Some(format)).log.records, std::fs::read(&path).unwrap())
}

/// The records and findings of bytes.
fn records(bytes: &[u8], format: Format) -> (Vec<Record>, Vec<String>) {
    let reading = traffic::read(Cursor::new(bytes.to_vec()), Path::new("x"), Some(format));
    let (_, reader) = reading.unwrap_or_else(|problem| panic!("{problem}"));
    let (mut records, mut findings) = (Vec::new(), Vec::new());
    for item in reader {
        match item {
            Ok(record) => records.push(record),
            Err(finding) => findings.push(format!("{}: {}", finding.place, finding.title)),
        }
        assert!(records.len() + findings.len() < 100_000, "it does not end");
    }
    (records, findings)
}

#[test]
fn a_log_cut_anywhere_is_read_up_to_there() {
    for (format, extension) in WRITTEN {
        let (all, bytes) = small_log(format, extension);
        for cut in 0..bytes.len() {
            let (read, findings) = records(&bytes[..cut], format);
            // Of a candump line nobody knows whether it goes on.
            let said = findings.iter().any(|finding| finding.contains("may be cut short"));
            let doubtful = said || format == Format::Candump && cut > 0 && bytes[cut - 1] != b'\n';
            let sure = read.len().saturating_sub(usize::from(doubtful));
            assert_eq!(read[..sure], all[..sure], "{format} cut at {cut}");
            // A log knows that it is not whole where its format ends with something.
            if matches!(format, Format::Blf | Format::Mcap) && cut > 0 && cut + 8 < bytes.len() {
                assert!(!findings.is_empty(), "{format} cut at {cut} of {}", bytes.len());
            }
        }
    }
}

#[test]
fn a_cut_line_or_packet_is_said_with_its_place() {
    let says = |name: &str, text: &str, wanted: &str| {
        let (log, findings) = try_text(name, text);
        assert_eq!((log.records.len(), findings.len()), (1, 1), "{findings:?}");
        assert!(findings[0].contains(wanted), "{findings:?}");
    };
    says(
        "x.log",
        "(1.5) can0 123#AABB\n(1.6) can0 123#A",
        "2:17: the data ends in the middle of a byte, and the file ends in the middle of this line",
    );
    says("x.log", "(1.5) can0 123#AABB\n(1.6) ca", "2:9: the line ends where a frame, as in 123#DEADBEEF was expected");
    says(
        "x.asc",
        "base hex\n1.0 1 123 Rx d 1 AA\n1.1 1 123 Rx d 2 A",
        "3:19: the line ends where another byte of data was expected",
    );
    says("x.trc", "; a\n 1) 1 0001 1 AA\n 2) 2 0001 2 AA", "3:16: the line ends where another byte of data");
    let (all, bytes) = small_log(Format::Pcap, "pcap");
    let (read, findings) = records(&bytes[..bytes.len() - 1], Format::Pcap);
    assert_eq!(read[..], all[..all.len() - 1]);
    assert!(
        findings[0].starts_with("byte ") && findings[0].contains("the file ends in the middle of this packet"),
        "{findings:?}"
    );
}

#[test]
fn the_line_after_a_damaged_one_is_read() {
    let (log, findings) =
        try_text("x.log", "(1.5) can0 123#AABB\n(1.6) can0 12X#AABB\n\u{0}\u{0}\n(1.7) can0 123#CC\n");
    assert_eq!(log.lines(), ["1500000000 can0 Received 123#AABB", "1700000000 can0 Received 123#CC"]);
    assert_eq!(findings.len(), 2, "{findings:?}");
    assert!(findings[0].starts_with("2:12: found `12X`, expected an id"), "{findings:?}");
}

#[test]
fn a_damaged_byte_never_panics_and_costs_few_records_of_a_text() {
    for (format, extension) in WRITTEN {
        let (all, bytes) = small_log(format, extension);
        let is_text = matches!(format, Format::Candump | Format::Csv);
        let body = bytes.iter().position(|&byte| byte == b'\n').unwrap_or(0);
        for at in 0..bytes.len() {
            for flip in [0x01, 0x10, 0x80, 0xFF] {
                let mut damaged = bytes.clone();
                damaged[at] ^= flip;
                let (read, findings) = records(&damaged, format);
                if is_text && at > body {
                    let untouched = all
                        .iter()
                        .filter(|record| read.iter().any(|read| read.at == record.at && read.content == record.content))
                        .count();
                    assert!(untouched + 2 >= all.len(), "{format} with byte {at} damaged: {findings:?}");
                }
                if format == Format::Mcap {
                    // Everything in a chunk has a checksum.
                    assert!(read == all || !findings.is_empty(), "byte {at} of an MCAP is damaged and nobody says so");
                }
            }
        }
    }
}

#[test]
fn a_damaged_container_costs_that_container_only() {
    let mut runner = TestRunner::deterministic();
    let mut many: Log =
        log(30).prop_filter("some", |log| log.records.len() > 20).new_tree(&mut runner).unwrap().current();
    let some = many.records.clone();
    many.records = some.iter().cycle().take(20_000).copied().collect();
    let folder = folder();
    for (format, extension) in [(Format::Blf, "blf"), (Format::Mcap, "mcap")] {
        let path = path_for(folder.path(), "log", format, extension);
        many.write(&path, format);
        let all = read(&path, None).log.records.len();
        let mut bytes = std::fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle..middle + 8].fill(0x55);
        let (kept, findings) = records(&bytes, format);
        assert!(!findings.is_empty());
        assert!(kept.len() > all / 2 && kept.len() < all, "{format}: {} of {all}: {findings:?}", kept.len());
    }
}

#[test]
fn lengths_in_a_file_are_not_believed() {
    // A packet, an object and a record that say they are huge.
    let mut pcap = b"\x4D\x3C\xB2\xA1\x02\0\x04\0\0\0\0\0\0\0\0\0\0\0\x04\0\xE3\0\0\0".to_vec();
    pcap.extend_from_slice(&[0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0x7F, 0xFF, 0xFF, 0xFF, 0x7F]);
    let mut blf = b"LOGG\x90\0\0\0".to_vec();
    blf.resize(144, 0);
    blf.extend_from_slice(b"LOBJ\x10\0\x01\0\xFF\xFF\xFF\xFF\x0A\0\0\0\x02\0\0\0\0\0\0\0\xFF\xFF\xFF\xFF\0\0\0\0");
    let mut mcap = mcap::MAGIC.to_vec();
    mcap.extend_from_slice(b"\x06\xFF\xFF\xFF\xFF\xFF\xFF\xFF\x7F");
    for (format, bytes) in [(Format::Pcap, pcap), (Format::Blf, blf), (Format::Mcap, mcap)] {
        let (records, findings) = records(&bytes, format);
        assert_eq!((records.len(), findings.len()), (0, 1), "{findings:?}");
    }
}
