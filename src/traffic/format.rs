//! The formats, and how one is told from another.

use std::fmt;
use std::path::Path;

use crate::config::{Problem, nearest};

/// A format of logs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// candump of can-utils; its log form is written.
    Candump,
    /// Vector's text, `.asc`.
    Asc,
    /// Vector's binary, `.blf`.
    Blf,
    /// PEAK's text, `.trc`; what is read may be of any version.
    Trc(TrcVersion),
    /// libpcap with SocketCAN frames.
    Pcap,
    /// Its successor.
    Pcapng,
    /// Comma-separated values: ours, python-can's and SavvyCAN's are read.
    Csv,
    /// Comma-separated values in python-can's columns.
    CsvPython,
    /// As canloop logs; `can_msgs/msg/Frame` of ROS 2 is read too.
    Mcap,
    /// BUSMASTER's text; read only.
    Busmaster,
    /// CarBus Analyzer's text; read only.
    CarBus,
}

/// A version of PEAK's format to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TrcVersion {
    /// Whole milliseconds, no directions, no date.
    V1_0,
    /// One bus.
    V1_1,
    /// Several buses, no CAN FD.
    V1_3,
    /// CAN FD, one bus.
    V2_0,
    /// All that there is.
    V2_1,
}

/// By the name that options take.
const NAMES: [(&str, Format); 17] = [
    ("candump", Format::Candump),
    ("asc", Format::Asc),
    ("blf", Format::Blf),
    ("trc", Format::Trc(TrcVersion::V2_1)),
    ("trc-1.0", Format::Trc(TrcVersion::V1_0)),
    ("trc-1.1", Format::Trc(TrcVersion::V1_1)),
    ("trc-1.3", Format::Trc(TrcVersion::V1_3)),
    ("trc-2.0", Format::Trc(TrcVersion::V2_0)),
    ("trc-2.1", Format::Trc(TrcVersion::V2_1)),
    ("pcap", Format::Pcap),
    ("pcapng", Format::Pcapng),
    ("csv", Format::Csv),
    ("csv-python", Format::CsvPython),
    ("mcap", Format::Mcap),
    ("busmaster", Format::Busmaster),
    ("carbus", Format::CarBus),
    ("log", Format::Candump),
];

impl Format {
    /// The format that an option calls by `name`.
    ///
    /// # Errors
    /// There is none of that name; the problem lists those that there are.
    pub fn parse(name: &str) -> Result<Self, Problem> {
        if let Some((_, format)) = NAMES.iter().find(|(known, _)| *known == name) {
            return Ok(*format);
        }
        let names: Vec<&str> = NAMES.iter().map(|(name, _)| *name).filter(|name| *name != "log").collect();
        let help = match nearest(name, names.iter().copied()) {
            Some(near) => format!("did you mean {near}? There are {}", names.join(", ")),
            None => format!("there are {}", names.join(", ")),
        };
        Err(Problem::bare(format!("there is no format called {name}")).help(help))
    }

    /// The format that a file of that name is to have.
    pub fn of_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "log" | "txt" | "candump" => Some(Self::Candump),
            "cap" => Some(Self::Pcap),
            "asc" | "blf" | "trc" | "pcap" | "pcapng" | "csv" | "mcap" => Self::parse(&extension).ok(),
            _ => None,
        }
    }

    /// The format of a file that begins with `head`, as far as that shows.
    pub fn of_content(head: &[u8]) -> Option<Self> {
        let magics: [(&[u8], Self); 8] = [
            (b"LOGG", Self::Blf),
            (b"\x89MCAP0\r\n", Self::Mcap),
            (b"\x0A\x0D\x0D\x0A", Self::Pcapng),
            (b"\xA1\xB2\xC3\xD4", Self::Pcap),
            (b"\xD4\xC3\xB2\xA1", Self::Pcap),
            (b"\xA1\xB2\x3C\x4D", Self::Pcap),
            (b"\x4D\x3C\xB2\xA1", Self::Pcap),
            (b"LOBJ", Self::Blf),
        ];
        let magic = magics.iter().find(|(magic, _)| head.starts_with(magic));
        magic.map(|(_, format)| *format).or_else(|| text_format(head))
    }

    /// Whether a file in it can be written.
    pub const fn is_written(self) -> bool {
        !matches!(self, Self::Busmaster | Self::CarBus)
    }
}

/// The first line that says something decides.
fn text_format(head: &[u8]) -> Option<Format> {
    let head = head.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(head);
    let mut lines = head.split(|byte| matches!(byte, b'\n' | b'\r')).map(<[u8]>::trim_ascii);
    let line = lines.find(|line| !line.is_empty() && !line.starts_with(b"#"))?;
    let begins = |word: &[u8]| line.len() >= word.len() && line[..word.len()].eq_ignore_ascii_case(word);
    if begins(b"***") {
        Some(Format::Busmaster)
    } else if begins(b"@ TEXT @") {
        Some(Format::CarBus)
    } else if begins(b";") {
        Some(Format::Trc(TrcVersion::V2_1))
    } else if begins(b"date ") || begins(b"base hex") || begins(b"base dec") || begins(b"//") {
        Some(Format::Asc)
    } else if begins(b"time_s,") || begins(b"timestamp,") || begins(b"Time Stamp,") {
        Some(Format::Csv)
    } else if begins(b"(") || begins(b"<0x") || begins(b"interface = ") {
        Some(Format::Candump)
    } else {
        None
    }
}

impl fmt::Display for Format {
    /// Its name in messages.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::Candump => "candump",
            Self::Asc => "ASC",
            Self::Blf => "BLF",
            Self::Trc(TrcVersion::V1_0) => "TRC 1.0",
            Self::Trc(TrcVersion::V1_1) => "TRC 1.1",
            Self::Trc(TrcVersion::V1_3) => "TRC 1.3",
            Self::Trc(TrcVersion::V2_0) => "TRC 2.0",
            Self::Trc(TrcVersion::V2_1) => "TRC 2.1",
            Self::Pcap => "pcap",
            Self::Pcapng => "pcapng",
            Self::Csv => "CSV",
            Self::CsvPython => "python-can's CSV",
            Self::Mcap => "MCAP",
            Self::Busmaster => "BUSMASTER",
            Self::CarBus => "CarBus Analyzer",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_beginning_of_a_file_shows_its_format() {
        let shown = |head: &str| Format::of_content(head.as_bytes());
        assert_eq!(shown("# a comment\n\n (1.5) can0 123#\n"), Some(Format::Candump));
        assert_eq!(shown("date Sam Sep 30 15:06:13.191 2017\n"), Some(Format::Asc));
        assert_eq!(shown(";$FILEVERSION=1.1\r\n"), Some(Format::Trc(TrcVersion::V2_1)));
        assert_eq!(shown("timestamp,arbitration_id,"), Some(Format::Csv));
        assert_eq!(shown("***BUSMASTER Ver 3.2.2***\n"), Some(Format::Busmaster));
        assert_eq!(shown("LOGG\0\0"), Some(Format::Blf));
        assert_eq!(shown("  can0  123   [0]"), None);
        assert_eq!(shown(""), None);
    }
}
