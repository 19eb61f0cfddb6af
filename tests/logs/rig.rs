//! Files to try things on, and what is in them.

use std::path::{Path, PathBuf};

use canloop::traffic::{self, Buses, Content, Finding, Format, Losses, Record, TrcVersion};

/// Every format that is written, with the extension of its files.
pub const WRITTEN: [(Format, &str); 13] = [
    (Format::Candump, "log"),
    (Format::Asc, "asc"),
    (Format::Blf, "blf"),
    (Format::Trc(TrcVersion::V1_0), "trc"),
    (Format::Trc(TrcVersion::V1_1), "trc"),
    (Format::Trc(TrcVersion::V1_3), "trc"),
    (Format::Trc(TrcVersion::V2_0), "trc"),
    (Format::Trc(TrcVersion::V2_1), "trc"),
    (Format::Pcap, "pcap"),
    (Format::Pcapng, "pcapng"),
    (Format::Csv, "csv"),
    (Format::CsvPython, "csv"),
    (Format::Mcap, "mcap"),
];

/// A log in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    pub records: Vec<Record>,
    pub buses: Buses,
}

/// What is in a file, and what is wrong with it.
pub struct Read {
    pub log: Log,
    pub findings: Vec<Finding>,
}

impl Log {
    /// The name of a record's bus.
    pub fn bus(&self, record: &Record) -> &str {
        self.buses.name(record.bus)
    }

    /// A line for each record, as candump would write it; errors and losses too.
    pub fn lines(&self) -> Vec<String> {
        self.records.iter().map(|record| self.line(record)).collect()
    }

    pub fn line(&self, record: &Record) -> String {
        let what = match &record.content {
            Content::Frame(recorded) => {
                let passive = if recorded.error_passive { " ESI" } else { "" };
                let dlc = recorded.dlc_above_8.map_or(String::new(), |dlc| format!("_{dlc:X}"));
                format!("{}{dlc}{passive}", recorded.frame)
            }
            Content::Error(error) => format!("error {:X} {:02X?}", error.class, error.data),
            Content::Lost(count) => format!("lost {count}"),
        };
        format!("{} {} {:?} {what}", record.at.as_nanos(), self.bus(record), record.direction)
    }

    /// Writes it to a file.
    pub fn write(&self, path: &Path, format: Format) -> Losses {
        let mut writer = traffic::create(path, format).expect("the file can be made");
        self.records.iter().for_each(|record| writer.put(record, &self.buses).expect("it is written"));
        writer.finish().expect("it is ended")
    }
}

/// All that a file gives.
pub fn read(path: &Path, format: Option<Format>) -> Read {
    let (_, mut reader) = traffic::open(path, format).unwrap_or_else(|problem| panic!("{problem}"));
    let (mut records, mut findings) = (Vec::new(), Vec::new());
    for item in reader.by_ref() {
        match item {
            Ok(record) => records.push(record),
            Err(finding) => findings.push(finding),
        }
    }
    let buses = reader.buses().clone();
    Read { log: Log { records, buses }, findings }
}

/// All that a text gives, which must be without a mistake.
pub fn read_text(name: &str, text: impl AsRef<[u8]>) -> Log {
    let (log, findings) = try_text(name, text);
    assert!(findings.is_empty(), "{findings:?}");
    log
}

/// All that a text gives, and its findings in words.
pub fn try_text(name: &str, text: impl AsRef<[u8]>) -> (Log, Vec<String>) {
    let text = text.as_ref().to_vec();
    let read = traffic::read(std::io::Cursor::new(text), Path::new(name), None);
    let (_, mut reader) = read.unwrap_or_else(|problem| panic!("{problem}"));
    let (mut records, mut findings) = (Vec::new(), Vec::new());
    for item in reader.by_ref() {
        match item {
            Ok(record) => records.push(record),
            Err(finding) => findings.push(format!("{}: {}", finding.place, finding.title)),
        }
    }
    let buses = reader.buses().clone();
    (Log { records, buses }, findings)
}

/// A folder for files, gone at the end.
pub fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder for logs")
}

/// A path in it that no other format uses.
pub fn path_for(folder: &Path, name: &str, format: Format, extension: &str) -> PathBuf {
    let format: String = format.to_string().chars().filter(char::is_ascii_alphanumeric).collect();
    folder.join(format!("{name}-{format}.{extension}"))
}
