//! `canloop log`: logs buses to MCAP.

mod statistics;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;

use super::{say, seconds, stop};
use crate::bus::{self, OpenOptions};
use crate::capture::{Filter, Hearing, Recorder, Rotation, hear};
use crate::config::{Problem, Problems};
use crate::log::LogError;
use crate::run::{Clock, StopSwitch};
use crate::schema::Dbc;
use crate::time::{Duration, Instant};
use statistics::Line;

/// What `canloop log` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  canloop log --bus can0 -o drive.mcap
  canloop log --bus can0 --bus can1 --dbc robot.dbc -o drive.mcap    decoded as well
  canloop log --bus can0 --filter 180:780,700:780 -o drive.mcap      as candump's filters
  canloop log --bus can0 --rotate-mb 100 -o drive.mcap               drive-0001.mcap, ...

Everything on the buses is kept: classic and CAN FD frames, error frames, who sent
them, the kernel's stamps, how often frames were lost and how many. Foxglove,
PlotJuggler and Rerun open the file as it is, canloop convert makes others of it.
A log that was killed, or whose disk is full, lacks its last second at most: canloop
repair makes it whole. Ctrl-C ends it.
Exit status: 0 all went well, 1 a bus went away, 2 bad input, or the file takes no
more.")]
pub struct Args {
    /// Bus to log: can0, or tcp://HOST:PORT/NAME; may be given several times
    #[arg(long = "bus", value_name = "BUS", required = true)]
    buses: Vec<String>,
    /// DBC file to decode frames with; may be given several times
    #[arg(long = "dbc", value_name = "FILE.dbc")]
    dbcs: Vec<PathBuf>,
    /// Log file to write
    #[arg(short, long, value_name = "FILE.mcap")]
    output: PathBuf,
    /// Only these frames: ID:MASK, ID~MASK, #ERRORMASK, j, with commas, as candump has it
    #[arg(long, value_name = "FILTER", default_value = "")]
    filter: String,
    /// Go on in another file after so many megabytes
    #[arg(long, value_name = "MB", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    rotate_mb: Option<u64>,
    /// Go on in another file after so long, s
    #[arg(long, value_name = "SECONDS")]
    rotate_s: Option<f64>,
    /// End after so long, s
    #[arg(long, value_name = "SECONDS")]
    duration_s: Option<f64>,
    /// The buses' bit rate, bit/s, for their load, where the interface does not say
    #[arg(long, value_name = "BIT/S", value_parser = clap::value_parser!(u32).range(10_000..=1_000_000))]
    bitrate: Option<u32>,
}

/// How often to see to it that all is in the file, and to tell how it goes.
const EVERY: Duration = Duration::from_millis(1000);
/// How long to wait where nothing has come.
const PAUSE: std::time::Duration = std::time::Duration::from_millis(2);
/// The ending of a log's name.
const ENDING: &str = "mcap";

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Problems> {
    let filter = Filter::parse(&args.filter).map_err(|what| Problem::bare(format!("--filter will not do: {what}")))?;
    if args.output.extension().is_none_or(|ending| ending != ENDING) {
        let problem = Problem::bare(format!("{} is no name for an MCAP file", args.output.display()));
        return Err(problem.help("call it FILE.mcap; canloop convert makes other formats of it").into());
    }
    let rotation = Rotation {
        bytes: args.rotate_mb.map(|megabytes| megabytes * 1_000_000),
        span: args.rotate_s.map(|span_s| seconds("--rotate-s", span_s)).transpose()?,
    };
    let duration = args.duration_s.map(|span_s| seconds("--duration-s", span_s)).transpose()?;
    let dbcs = args.dbcs.iter().map(|path| Ok(Dbc::parse_leniently(&Dbc::read_source(path)?).0));
    let dbcs: Vec<Dbc> = dbcs.collect::<Result<_, Problem>>()?;
    let clock = Clock::new();
    let stop = stop::listen();
    let hearings = listen(&args.buses, &filter, clock, stop)?;
    let mut line = Line::new(&hearings, args.bitrate);
    let mut recorder = Recorder::create(&args.output, rotation, metadata(), dbcs.iter().collect(), hearings)
        .map_err(|error| cannot_log(&error))?;
    say(format_args!("logging {} to {}", args.buses.join(", "), args.output.display()));
    let until = duration.map_or(Instant::MAX, |duration| clock.now() + duration);
    let written = go_on(&mut recorder, &mut line, clock, until, stop);
    line.end(&recorder);
    let (logged, hearings) = recorder.finish();
    // The threads end by themselves, soon.
    stop.press();
    let ends: Vec<_> = hearings.into_iter().filter_map(Hearing::end).collect();
    ends.iter().for_each(|end| eprintln!("error: {end}"));
    written.map_err(|error| cannot_log(&error))?;
    let logged = logged.map_err(|error| cannot_log(&error))?;
    let files: Vec<String> = logged.files.iter().map(|file| file.display().to_string()).collect();
    say(format_args!("{} messages, {} bytes in {}", logged.messages, logged.bytes, files.join(", ")));
    Ok(ExitCode::from(u8::from(!ends.is_empty())))
}

/// Opens the buses and listens to each.
fn listen(
    addresses: &[String],
    filter: &Filter,
    clock: Clock,
    stop: &'static StopSwitch,
) -> Result<Vec<Hearing>, Problem> {
    let mut hearings: Vec<Hearing> = Vec::new();
    let options = OpenOptions { listens: true, ..OpenOptions::default() };
    for address in addresses {
        let name = bus::bus_name(address).to_owned();
        if hearings.iter().any(|other| other.name == name) {
            return Err(Problem::bare(format!("two of the buses are called {name}"))
                .help("the log tells them apart by their names"));
        }
        let bus = bus::open(address, &options, clock)?;
        let heard = hear(name.clone(), bus, filter.clone(), clock, stop);
        hearings.push(heard.map_err(|error| Problem::bare(format!("cannot listen to {name}: {error}")))?);
    }
    Ok(hearings)
}

#[allow(clippy::disallowed_methods, reason = "a runtime waits")]
fn go_on(
    recorder: &mut Recorder<'_>,
    line: &mut Line,
    clock: Clock,
    until: Instant,
    stop: &'static StopSwitch,
) -> Result<(), LogError> {
    let mut next = clock.now() + EVERY;
    loop {
        let has_any = recorder.write()?;
        let now = clock.now();
        if now >= until {
            stop.press();
        }
        if now >= next {
            next = now + EVERY;
            recorder.flush()?;
            line.show(recorder);
        }
        if !has_any {
            if recorder.has_ended() {
                return Ok(());
            }
            std::thread::sleep(PAUSE);
        }
    }
}

fn metadata() -> BTreeMap<String, String> {
    BTreeMap::from([
        ("program".to_owned(), "canloop log".to_owned()),
        ("version".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
    ])
}

fn cannot_log(error: &LogError) -> Problem {
    Problem::bare(error.to_string()).help("canloop repair makes a log that ends early one that all readers open")
}
