//! `canloop repair`: makes a log that breaks off one that all readers open.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::say;
use crate::config::{Problem, Problems};
use crate::log::{Repaired, examine, repair};

/// What `canloop repair` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  canloop repair run.mcap                 writes run.repaired.mcap
  canloop repair run.mcap -o whole.mcap
  canloop repair run.mcap --in-place      in place of the old one, once it is written

A log that a killed program or a full disk has left has no index at its end, and
most readers refuse it. All that is whole of it is copied: every chunk, that is
about every second, but for the last one, and not those that are damaged.
Exit status: 0 the log is whole, or is now; 2 it is no MCAP file, or the copy cannot
be written.")]
pub struct Args {
    /// The log
    #[arg(value_name = "FILE.mcap")]
    log: PathBuf,
    /// Where to write the copy; without it, beside the log
    #[arg(short, long, value_name = "FILE.mcap", conflicts_with = "in_place")]
    output: Option<PathBuf>,
    /// Put the copy in the log's place
    #[arg(long)]
    in_place: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Problems> {
    let path = &args.log;
    let log = std::fs::read(path).map_err(|error| Problem::bare(format!("cannot read {}: {error}", path.display())))?;
    let found = examine(&log).map_err(|error| no_log(path, &error))?;
    if found.is_whole() {
        say(format_args!("{}: whole, {} messages; there is nothing to repair", path.display(), found.messages));
        return Ok(ExitCode::SUCCESS);
    }
    let copy = match &args.output {
        Some(output) => output.clone(),
        None => path.with_extension("repaired.mcap"),
    };
    write(&log, path, &copy)?;
    if args.in_place {
        std::fs::rename(&copy, path)
            .map_err(|error| Problem::bare(format!("cannot put {} in its place: {error}", copy.display())))?;
    }
    tell(path, if args.in_place { path } else { &copy }, &found, log.len() as u64);
    Ok(ExitCode::SUCCESS)
}

fn write(log: &[u8], path: &Path, copy: &Path) -> Result<(), Problem> {
    if copy == path {
        let problem = Problem::bare(format!("{} cannot be its own copy", path.display()));
        return Err(problem.help("use --in-place, which writes the copy first"));
    }
    let refused = |error: &dyn std::fmt::Display| Problem::bare(format!("cannot write {}: {error}", copy.display()));
    let mut file = BufWriter::new(File::create(copy).map_err(|error| refused(&error))?);
    repair(log, &mut file).map_err(|error| refused(&error))?;
    file.flush().and_then(|()| file.get_ref().sync_all()).map_err(|error| refused(&error))
}

fn tell(path: &Path, copy: &Path, found: &Repaired, len: u64) {
    say(format_args!("{}: repaired", path.display()));
    let until = found.last_ns.map_or(String::new(), |ns| format!(", the last at {:.6} s", ns as f64 / 1e9));
    say(format_args!("  kept             {} messages{until}", found.messages));
    for (offset, what) in &found.damaged {
        say(format_args!("  lost             a part that is damaged, at byte {offset}: {what}"));
    }
    if let Some(offset) = found.cut_at {
        let bytes = len - offset;
        say(format_args!("  lost             {bytes} bytes of a chunk that was never finished, at byte {offset}"));
    }
    say(format_args!("  written          {}", copy.display()));
}

fn no_log(path: &Path, error: &mcap::McapError) -> Problem {
    let problem = Problem::bare(format!("{} cannot be read as an MCAP file: {error}", path.display()));
    problem.help("it must begin with the bytes 89 4D 43 41 50 30 0D 0A")
}
