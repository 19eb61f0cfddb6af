//! Logs of buses, a target for each format: whatever is in a file, its reader
//! ends, points at places that are there, and gives records that every writer
//! takes.

use std::io::Cursor;
use std::path::Path;

use canloop::traffic::{self, Content, Format, Place, Record, TrcVersion};

use crate::harness::{Target, digest, seeds_in};

const WORDS: [&str; 48] = [
    "(1436509052.249713) ",
    "can0 ",
    "123#",
    "##1",
    "#R8",
    "_9",
    " T\n",
    " R\n",
    "[8]",
    "[08]",
    "{C}",
    "  remote request",
    "20000080#",
    "DROPCOUNT: dropped 1 CAN frame on 'can0'",
    "<0x123> [2] 01 02\n",
    "date Sam Sep 30 15:06:13.191 2017\n",
    "base dec  timestamps relative\n",
    "0.5 1  1ABx Rx d 2 01 02\n",
    "CANFD 1 Rx 123 1 0 9 12 ",
    "ErrorFrame",
    "// bus 2 = ",
    ";$FILEVERSION=2.1\n",
    ";$FILEVERSION=1.3\n",
    ";$STARTTIME=",
    ";$COLUMNS=N,O,T,B,I,d,R,L,D\n",
    " DT 1 0300 Rx -  2 ",
    "Warng",
    "RTR",
    "time_s,bus,direction,kind,id,id_bits,bit_rate_switch,error_passive,dlc,data\n",
    "timestamp,arbitration_id,extended,remote,error,dlc,data\n",
    "Time Stamp,ID,Extended,Dir,Bus,LEN,D1\n",
    "***START DATE AND TIME 26:3:2020 14:19:36:625***\n",
    "14:19:36:6265 Rx 1 0x21A s 2 01 02\n",
    "@ TEXT @\r46,016\t1\t0004\t45A\t1\t5A\t0\r",
    "LOGG",
    "LOBJ",
    "LOBJ\u{10}\0\u{1}\0\u{30}\0\0\0\u{a}\0\0\0",
    "LOBJ\u{20}\0\u{1}\0\u{30}\0\0\0\u{1}\0\0\0",
    "\u{6}\0\0\0",
    "\u{4}\0\0\0zstd",
    "\0\0\0\0",
    "\u{7f}\u{7f}\u{7f}\u{7f}",
    "\"",
    ",",
    "\t",
    "\r",
    "\n",
    "\u{1b}[34m",
];

#[test]
fn log_candump() {
    fuzz("log_candump", Format::Candump);
}

#[test]
fn log_asc() {
    fuzz("log_asc", Format::Asc);
}

#[test]
fn log_blf() {
    fuzz("log_blf", Format::Blf);
}

#[test]
fn log_trc() {
    fuzz("log_trc", Format::Trc(TrcVersion::V2_1));
}

#[test]
fn log_pcap() {
    fuzz("log_pcap", Format::Pcap);
}

#[test]
fn log_csv() {
    fuzz("log_csv", Format::Csv);
}

#[test]
fn log_mcap() {
    fuzz("log_mcap", Format::Mcap);
}

#[test]
fn log_busmaster() {
    fuzz("log_busmaster", Format::Busmaster);
}

#[test]
fn log_carbus() {
    fuzz("log_carbus", Format::CarBus);
}

fn fuzz(name: &str, format: Format) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().expect("a folder");
    let mut seeds = seeds_in(&root.join("tests/fuzz/seeds/logs"));
    seeds.extend(written_seeds(&seeds, folder.path()));
    Target { name, seeds, words: &WORDS, share: 1.0 / 3.0 }.fuzz(|input| {
        let reading = traffic::read(Cursor::new(input.to_vec()), Path::new("fuzz"), Some(format));
        let (_, mut reader) = reading.expect("a reader");
        let (mut kinds, mut records, mut most_lines) = (0, Vec::new(), input.len() as u64 + 2);
        while let Some(item) = reader.next() {
            match item {
                Ok(record) => {
                    assert!(!reader.buses().name(record.bus).is_empty() || reader.buses().names().len() <= 256);
                    records.push(record);
                }
                Err(finding) => {
                    assert!(is_there(finding.place, input.len() as u64) && !finding.title.is_empty(), "{finding:?}");
                    kinds |= 1_u64 << (digest(words_of(&finding.title).as_bytes()) % 64);
                }
            }
            // A deflated byte is at most some thousand inflated ones.
            most_lines += 1;
            assert!(most_lines < 10_000_000, "it does not end");
        }
        write_all(&records, reader.buses(), folder.path());
        let shapes = records.iter().fold(0, |shapes, record| shapes | shape(record));
        digest(format!("{kinds} {shapes} {}", records.len().min(4)).as_bytes())
    });
}

/// The seeds in the formats that are not text, too.
fn written_seeds(texts: &[Vec<u8>], folder: &Path) -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for text in texts {
        let reading = traffic::read(Cursor::new(text.clone()), Path::new("seed.log"), None);
        let Ok((_, mut reader)) = reading else { continue };
        let records: Vec<Record> = reader.by_ref().filter_map(Result::ok).collect();
        for format in [
            Format::Asc,
            Format::Blf,
            Format::Trc(TrcVersion::V2_1),
            Format::Pcap,
            Format::Pcapng,
            Format::Csv,
            Format::Mcap,
        ] {
            let path = folder.join("seed");
            let mut writer = traffic::create(&path, format).expect("a file");
            records.iter().for_each(|record| writer.put(record, reader.buses()).expect("it is written"));
            writer.finish().expect("it is ended");
            all.push(std::fs::read(&path).expect("it is there"));
        }
    }
    all
}

/// Whatever was read can be written in every format of text.
fn write_all(records: &[Record], buses: &traffic::Buses, folder: &Path) {
    let format =
        [Format::Candump, Format::Asc, Format::Trc(TrcVersion::V1_1), Format::Csv, Format::Blf, Format::Pcapng];
    let format = format[records.len() % format.len()];
    let mut writer = traffic::create(&folder.join("out"), format).expect("a file");
    for record in records.iter().take(64) {
        writer.put(record, buses).expect("it is written");
    }
    writer.finish().expect("it is ended");
}

fn is_there(place: Place, len: u64) -> bool {
    match place {
        Place::Line { line, column } => line >= 1 && line <= len + 1 && column >= 1 && column <= len + 2,
        Place::Byte(byte) => byte <= len,
        Place::Inside { chunk, .. } => chunk <= len,
    }
}

/// A title without what was found.
fn words_of(title: &str) -> String {
    title.split(' ').filter(|word| word.chars().all(|c| c.is_ascii_lowercase())).collect::<Vec<_>>().join(" ")
}

fn shape(record: &Record) -> u64 {
    match &record.content {
        Content::Frame(recorded) => 1 << (recorded.is_fd() as u64 + 2 * u64::from(recorded.dlc_above_8.is_some())),
        Content::Error(_) => 16,
        Content::Lost(_) => 32,
    }
}
