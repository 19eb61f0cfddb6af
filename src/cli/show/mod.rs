//! `canloop show`: what is in a log.

mod decoded;
mod signals;

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::BAD_INPUT;
use super::log_file::{complain, named, open_log};
use crate::bus::BitRates;
use crate::config::{Problem, Problems};
use crate::schema::Dbc;
use crate::traffic::{Buses, Conversion, Format, Reader, Record, Survey};

/// What `canloop show` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  canloop show drive.mcap                           what is in it
  canloop show trace.asc --bitrate 500000           and how full the buses were
  canloop show capture.pcapng --json
  canloop show candump.log --dbc my-drive.dbc       every frame, decoded
  canloop show run.mcap --dbc drive.dbc --signals Position,Torque --csv > run.csv
  candump -L can0 | canloop show - --dbc my-drive.dbc

All formats that canloop convert reads are shown. A signal that several messages
have is named Message.Signal, or stands for all of them.
Exit status: 0 all was read, 2 not all of it; what is damaged is said with its place.")]
pub struct Args {
    /// Log to look at; - is standard input
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Format of FILE, whatever it is called
    #[arg(long, value_name = "FORMAT")]
    from: Option<String>,
    /// The buses' bit rate, bit/s, for their load
    #[arg(long, value_name = "BIT/S", value_parser = clap::value_parser!(u32).range(1_000..=20_000_000))]
    bitrate: Option<u32>,
    /// The bit rate of CAN FD data where it is switched, bit/s; else that of --bitrate
    #[arg(long, value_name = "BIT/S", requires = "bitrate", value_parser = clap::value_parser!(u32).range(1_000..=20_000_000))]
    data_bitrate: Option<u32>,
    /// Decode frames with these messages; where two files know an id, the first is believed
    #[arg(long, value_name = "FILE.dbc")]
    dbc: Vec<PathBuf>,
    /// Show these signals only, with a comma between them
    #[arg(long, value_name = "A,B", value_delimiter = ',', requires = "dbc")]
    signals: Vec<String>,
    /// Print a column for each of --signals, and a row for each frame that has one
    #[arg(long, requires = "signals")]
    csv: bool,
    /// Print JSON
    #[arg(long, conflicts_with_all = ["dbc", "csv"])]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Problems> {
    let dbcs = args.dbc.iter().map(|path| read_dbc(path)).collect::<Result<Vec<_>, _>>()?;
    let (format, mut reader) = open_log(&args.file, args.from.as_deref())?;
    let name = named(&args.file);
    let done = match (dbcs.is_empty(), args.csv) {
        (true, _) => survey(args, &name, format, reader.as_mut()),
        (false, true) => {
            let columns = signals::Columns::find(&dbcs, &args.signals)?;
            print(reader.as_mut(), |out| columns.put_header(out), |out, record, _| columns.put_row(out, record))
        }
        (false, false) => {
            let lines = decoded::Lines::find(&dbcs, &args.signals)?;
            print(reader.as_mut(), |_| Ok(()), |out, record, buses| lines.put(out, record, buses))
        }
    };
    complain(&name, &done);
    Ok(if done.errors > 0 { ExitCode::from(BAD_INPUT) } else { ExitCode::SUCCESS })
}

fn survey(args: &Args, name: &str, format: Format, reader: &mut dyn Reader) -> Conversion {
    let rates = args
        .bitrate
        .map(|nominal_bit_s| BitRates { nominal_bit_s, data_bit_s: args.data_bitrate.unwrap_or(nominal_bit_s) });
    let (mut survey, mut done) = (Survey::new(rates), Conversion::default());
    for item in &mut *reader {
        match item {
            Ok(record) => {
                done.records += 1;
                survey.add(&record);
            }
            Err(finding) => done.note(finding),
        }
    }
    if args.json {
        let mut json = survey.json(reader.buses());
        json["file"] = name.into();
        json["format"] = format.to_string().into();
        json["errors_in_file"] = done.errors.into();
        super::say(format_args!("{json:#}"));
    } else {
        super::say(format_args!("{name}: {format}"));
        super::say(survey.text(reader.buses()).trim_end());
    }
    done
}

/// Prints a log record by record, as long as somebody reads it.
fn print(
    reader: &mut dyn Reader,
    begin: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    mut put: impl FnMut(&mut dyn Write, &Record, &Buses) -> io::Result<()>,
) -> Conversion {
    let mut done = Conversion::default();
    let mut out = BufWriter::new(io::stdout().lock());
    let mut written = begin(&mut out);
    while let (Ok(()), Some(item)) = (&written, reader.next()) {
        match item {
            Ok(record) => {
                done.records += 1;
                written = put(&mut out, &record, reader.buses());
            }
            Err(finding) => done.note(finding),
        }
    }
    // A reader that has gone away has seen enough.
    let _ = written.and_then(|()| out.flush());
    done
}

/// Whatever of a DBC file can be understood: one message too few is better
/// than none.
fn read_dbc(path: &Path) -> Result<Dbc, Problem> {
    let (dbc, findings) = Dbc::parse_leniently(&Dbc::read_source(path)?);
    if dbc.messages.is_empty() {
        return Err(Problem::bare(format!("{}: no message in it can be understood", path.display()))
            .help(format!("canloop check {} says what is wrong", path.display())));
    }
    if !findings.is_empty() {
        let count = findings.len();
        eprintln!("warning: {}: {count} findings; canloop check {0} lists them", path.display());
    }
    Ok(dbc)
}
