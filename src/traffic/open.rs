//! Readers and writers by format.

use std::fs::File;
use std::io::{self, BufWriter, Read};
use std::path::Path;

use super::line_reader::{LineFormat, LineReader};
use super::{Buses, Finding, Format, Losses, Record, asc, blf, busmaster, candump, carbus, csv, mcap, pcap, trc};
use crate::config::Problem;

/// Gives the records of a file in its order, and what is wrong with it. After
/// a finding it goes on where it can.
pub trait Reader: Iterator<Item = Result<Record, Finding>> {
    /// The buses heard of so far.
    fn buses(&self) -> &Buses;
}

/// Takes records and makes a file of them.
pub trait Writer {
    /// Writes a record.
    ///
    /// # Errors
    /// The file takes no more.
    fn put(&mut self, record: &Record, buses: &Buses) -> io::Result<()>;

    /// Ends the file; returns what it could not hold.
    ///
    /// # Errors
    /// The file takes no more.
    fn finish(self: Box<Self>) -> io::Result<Losses>;
}

/// Bytes that are looked at to tell the format and its dialect.
const HEAD_BYTES: u64 = 64 << 10;

/// Opens a file: in `format`, or what its content and its name show.
///
/// # Errors
/// It cannot be opened, or nothing shows what it is.
pub fn open(path: &Path, format: Option<Format>) -> Result<(Format, Box<dyn Reader>), Problem> {
    let file = File::open(path).map_err(|error| Problem::bare(format!("cannot open {}: {error}", path.display())))?;
    read(file, path, format)
}

/// Reads `input`, the content of the file at `path`, as [`open`] does.
///
/// # Errors
/// It cannot be read, or nothing shows what it is.
pub fn read(
    mut input: impl Read + 'static,
    path: &Path,
    format: Option<Format>,
) -> Result<(Format, Box<dyn Reader>), Problem> {
    let mut head = Vec::new();
    let begun = input.by_ref().take(HEAD_BYTES).read_to_end(&mut head);
    begun.map_err(|error| Problem::bare(format!("cannot read {}: {error}", path.display())))?;
    let known = format.or_else(|| Format::of_content(&head)).or_else(|| Format::of_path(path));
    let format = known.ok_or_else(|| {
        Problem::bare(format!("{}: neither its content nor its name shows what it is", path.display()))
            .help("say it with --from candump, asc, blf, trc, pcap, pcapng, csv or mcap")
    })?;
    let all = io::Cursor::new(head.clone()).chain(input);
    Ok((format, reader(format, &head, all)))
}

fn reader(format: Format, head: &[u8], input: impl Read + 'static) -> Box<dyn Reader> {
    fn lines<F: LineFormat + 'static>(input: impl Read + 'static, format: F) -> Box<dyn Reader> {
        Box::new(LineReader::new(input, format))
    }
    match format {
        Format::Candump => lines(input, candump::Candump::new(head)),
        Format::Asc => lines(input, asc::Asc::default()),
        Format::Blf => Box::new(blf::BlfReader::new(input)),
        Format::Trc(_) => lines(input, trc::Trc::default()),
        Format::Pcap | Format::Pcapng => Box::new(pcap::PcapReader::new(input)),
        Format::Csv | Format::CsvPython => lines(input, csv::Csv::default()),
        Format::Mcap => Box::new(mcap::McapReader::new(input)),
        Format::Busmaster => lines(input, busmaster::Busmaster::default()),
        Format::CarBus => lines(input, carbus::CarBus),
    }
}

/// Makes or empties a file for records.
///
/// # Errors
/// It cannot be made, or the format is one that is only read.
pub fn create(path: &Path, format: Format) -> Result<Box<dyn Writer>, Problem> {
    let cannot = |error: &dyn std::fmt::Display| Problem::bare(format!("cannot create {}: {error}", path.display()));
    if !format.is_written() {
        return Err(Problem::bare(format!("{format} files are read, but not written"))
            .help("write candump, asc, blf, trc, pcap, pcapng, csv or mcap"));
    }
    if format == Format::Mcap {
        return Ok(Box::new(mcap::McapWriter::create(path).map_err(|error| cannot(&error))?));
    }
    let out = BufWriter::with_capacity(64 << 10, File::create(path).map_err(|error| cannot(&error))?);
    Ok(match format {
        Format::Candump => Box::new(candump::CandumpWriter::new(out)),
        Format::Asc => Box::new(asc::AscWriter::new(out)),
        Format::Blf => Box::new(blf::BlfWriter::new(out).map_err(|error| cannot(&error))?),
        Format::Trc(version) => Box::new(trc::TrcWriter::new(out, version)),
        Format::Pcap => Box::new(pcap::PcapWriter::new(out)),
        Format::Pcapng => Box::new(pcap::PcapngWriter::new(out)),
        Format::CsvPython => Box::new(csv::PythonCsvWriter::new(out)),
        _ => Box::new(csv::CsvWriter::new(out)),
    })
}
