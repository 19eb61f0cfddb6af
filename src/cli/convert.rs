//! `canloop convert`: a log in another format.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::BAD_INPUT;
use super::log_file::{complain, named, open_log};
use crate::config::{Problem, Problems};
use crate::traffic::{self, Format};

/// What `canloop convert` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  canloop convert drive.mcap drive.asc         for CANalyzer
  canloop convert candump.log candump.mcap     for Foxglove
  canloop convert trace.trc trace.pcapng       for Wireshark
  canloop convert old.txt new.csv --from candump
  candump -L can0 | canloop convert - can0.blf
  canloop convert drive.mcap drive.trc --to trc-1.1

Formats: candump (.log, .txt; each of candump's forms is read), asc and blf of
Vector, trc of PEAK (read in all versions; trc-1.0, -1.1, -1.3, -2.0, -2.1 are
written), pcap, pcapng, csv (csv-python for python-can's columns), mcap. Read
only: busmaster, carbus. What IN is, is seen by its content and its extension;
what OUT is to be, by its extension.
What OUT cannot hold is said, and how much of it there was. What is damaged in
IN is said with its place; all else is converted.
Exit status: 0 all of IN was read, 2 not all of it, or nothing could be written.")]
pub struct Args {
    /// Log to read; - is standard input
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// Log to write
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// Format of IN, whatever it is called
    #[arg(long, value_name = "FORMAT")]
    from: Option<String>,
    /// Format of OUT, whatever it is called
    #[arg(long, value_name = "FORMAT")]
    to: Option<String>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Problems> {
    let to = match &args.to {
        Some(name) => Format::parse(name)?,
        None => Format::of_path(&args.output).ok_or_else(|| unknown_format(&args.output))?,
    };
    refuse_to_overwrite_the_input(args)?;
    let (from, mut reader) = open_log(&args.input, args.from.as_deref())?;
    let writer = traffic::create(&args.output, to)?;
    let cannot_write = |error| Problem::bare(format!("cannot go on writing {}: {error}", args.output.display()));
    let done = traffic::convert(reader.as_mut(), writer).map_err(cannot_write)?;

    let name = named(&args.input);
    complain(&name, &done);
    for message in done.losses.messages(&to.to_string()) {
        eprintln!("warning: {message}");
    }
    let buses = reader.buses().names().join(", ");
    let what = if buses.is_empty() { String::new() } else { format!(" of {buses}") };
    super::say(format_args!("{name} ({from}): {} records{what} -> {} ({to})", done.records, args.output.display()));
    Ok(if done.errors > 0 { ExitCode::from(BAD_INPUT) } else { ExitCode::SUCCESS })
}

fn unknown_format(output: &Path) -> Problem {
    Problem::bare(format!("{}: the name does not show what it is to be", output.display()))
        .help("say it with --to, or call it .log, .asc, .blf, .trc, .pcap, .pcapng, .csv or .mcap")
}

fn refuse_to_overwrite_the_input(args: &Args) -> Result<(), Problem> {
    let (input, output) = (args.input.canonicalize(), args.output.canonicalize());
    match (input, output) {
        (Ok(input), Ok(output)) if input == output => {
            Err(Problem::bare(format!("{} would be written over itself", args.input.display()))
                .help("give OUT another name"))
        }
        _ => Ok(()),
    }
}
