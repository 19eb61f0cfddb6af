//! `canloop report`: a page of a log, for people.

mod buses;
mod signals;
mod stack;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::log_file::{complain, named, open_log};
use super::say;
use crate::config::{Problem, Problems, Source};
use crate::replay::attachments;
use crate::report::Page;
use crate::schema::Dbc;
use crate::traffic::Conversion;
use buses::Buses;
use signals::Signals;
use stack::Stack;

/// What `canloop report` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  canloop report drive.mcap                      writes drive.html
  canloop report candump.log --dbc robot.dbc --bitrate 500000 -o robot.html

One page that opens offline: what is on each bus and how much of it is taken, what
happened, and every signal that a DBC file knows over time; of a log of canloop drive
or hil-sim run also the way of the robot, its torques and states, and how punctual
the loop was. A DBC in the log is used without being asked for.
Exit status: 0 the page is written, 2 not all of the log could be read, or nothing.")]
pub struct Args {
    /// The log, in any format that canloop convert reads
    #[arg(value_name = "FILE")]
    log: PathBuf,
    /// DBC file to decode frames with; may be given several times
    #[arg(long = "dbc", value_name = "FILE.dbc")]
    dbcs: Vec<PathBuf>,
    /// The buses' bit rate, bit/s, for their load
    #[arg(long, value_name = "BIT/S", value_parser = clap::value_parser!(u32).range(10_000..=1_000_000))]
    bitrate: Option<u32>,
    /// Where to write the page; without it, beside the log
    #[arg(short, long, value_name = "FILE.html")]
    output: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Problems> {
    let path = &args.log;
    let (format, mut reader) = open_log(path, None)?;
    let of_stack = if format.to_string() == "MCAP" { Some(read_whole(path)?) } else { None };
    let mut dbcs = args.dbcs.iter().map(|path| Ok(Dbc::parse_leniently(&Dbc::read_source(path)?).0));
    let mut dbcs: Vec<Dbc> = dbcs.by_ref().collect::<Result<_, Problem>>()?;
    let attached = of_stack.as_deref().map(attached_texts).unwrap_or_default();
    let of_log = attached.iter().filter(|(name, _)| name.ends_with(".dbc"));
    dbcs.extend(of_log.map(|(name, text)| Dbc::parse_leniently(&Source::new(name, text.as_str())).0));
    let (mut buses, mut signals, mut done) = (Buses::new(args.bitrate), Signals::of(&dbcs), Conversion::default());
    for item in &mut *reader {
        match item {
            Ok(record) => {
                done.records += 1;
                buses.take(&record);
                signals.take(&record, buses.seconds(record.at));
            }
            Err(finding) => done.note(finding),
        }
    }
    let mut page = Page::new(path.display().to_string());
    page = page.lead(format!("{format}, {} records over {:.3} s.", done.records, buses.span_s()));
    let stack = of_stack
        .as_deref()
        .map(|log| Stack::read(log, &attached))
        .transpose()
        .map_err(|what| unreadable(path, &what))?;
    if let Some(stack) = stack.filter(Stack::has_any) {
        page = stack.sections(page, |at| buses.seconds(at));
    }
    page = buses.sections(page, reader.buses(), &dbcs);
    page = signals.sections(page);
    page = page.footer(format!("Made by canloop {} report.", env!("CARGO_PKG_VERSION")));
    let output = args.output.clone().unwrap_or_else(|| path.with_extension("html"));
    std::fs::write(&output, page.to_html())
        .map_err(|error| Problem::bare(format!("cannot write {}: {error}", output.display())))?;
    complain(&named(path), &done);
    say(format_args!("{}: {} records -> {}", path.display(), done.records, output.display()));
    Ok(ExitCode::from(if done.errors > 0 { super::BAD_INPUT } else { 0 }))
}

fn read_whole(path: &Path) -> Result<Vec<u8>, Problem> {
    std::fs::read(path).map_err(|error| Problem::bare(format!("cannot read {}: {error}", path.display())))
}

fn unreadable(path: &Path, what: &str) -> Problem {
    Problem::bare(format!("cannot go on reading {}: {what}", path.display()))
}

/// Files attached to a log, as texts; what cannot be read so far has none.
fn attached_texts(log: &[u8]) -> Vec<(String, String)> {
    let attached = attachments(log).unwrap_or_default();
    attached.into_iter().map(|(name, data)| (name, String::from_utf8_lossy(&data).into_owned())).collect()
}
