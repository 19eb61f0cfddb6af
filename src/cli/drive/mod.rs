//! `canloop drive`: the deployed program.

mod over_budget;
mod report;

use std::path::PathBuf;
use std::process::ExitCode;

use self::report::{LogFigures, Reader, Summary, cannot_log, contents, open_log, word};
use super::{WatchArgs, say, seconds, stop};
use crate::bus::{self, Bus, OpenOptions};
use crate::config::{Problem, Problems};
use crate::event::{Event, Sink};
use crate::frame::CanId;
use crate::live::Run;
use crate::log::McapLog;
use crate::run::{self, Clock, Degraded, End, Ended, LockStep, Punctuality, RealTime, StopSwitch, tap};
use crate::safety::{Operator, State};
use crate::schema::{Profile, StepEndCodec};
use crate::stack::{RobotFile, Stack, StackConfig};
use crate::time::Instant;

/// What `canloop drive` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  canloop drive --bus can0 --config robot.toml --log run.mcap
  canloop drive --bus vcan0 --config robot.toml --pace lockstep
  canloop drive --bus can0 --config robot.toml --live             a page to look on
  hil-sim scenario dac-friction > robot.toml     a robot to begin with
  canloop drive --bus tcp://127.0.0.1:29536/can0 --config robot.toml --pace lockstep --log run.mcap

Ctrl-C and SIGTERM brake the robot to rest and disable the drives; once more
takes the torque away at once.
Where the configuration has bus.bitrate_bit_s, an interface with another bit
rate is refused. By the clock, so is a robot whose traffic a bus of that rate
cannot carry in time: see canloop budget.
Exit status: 0 the run ended as it should, 1 the stack tripped or the other
side fell silent, 2 bad input or no bus.")]
pub struct Args {
    /// can0, vcan0, or tcp://HOST:PORT/NAME
    #[arg(long)]
    bus: String,
    /// The robot: a TOML file; a scenario will do
    #[arg(long, value_name = "ROBOT.toml")]
    config: PathBuf,
    /// Lay KEY=VALUE over the configuration: KEY a dotted path, VALUE as TOML
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// What the stack's time goes by
    #[arg(long, value_enum, default_value_t = Pace::Realtime)]
    pace: Pace,
    /// In real time: how long to run, s; without it, until Ctrl-C
    #[arg(long, value_name = "SECONDS")]
    duration_s: Option<f64>,
    /// Log all traffic and the stack's state to this MCAP file
    #[arg(long, value_name = "FILE.mcap")]
    log: Option<PathBuf>,
    /// Write the run's figures to this file
    #[arg(long, value_name = "FILE.json")]
    summary: Option<PathBuf>,
    /// First clear a fault that holds a drive
    #[arg(long)]
    clear_fault: bool,
    /// Drive even when the bus cannot carry all messages in time
    #[arg(long)]
    over_budget: bool,
    /// In lock-step: how long the other side may be silent, s
    #[arg(long, default_value_t = 10.0, value_name = "SECONDS")]
    dead_man_s: f64,
    #[command(flatten)]
    watch: WatchArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Pace {
    /// The clock: for real drives, and for `hil-sim serve --time wall`
    Realtime,
    /// The far side's marker ends each period: for `hil-sim serve`
    Lockstep,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Problems> {
    let robot = RobotFile::load(&args.config.display().to_string(), &args.overrides)?;
    let config = &robot.stack;
    let patience = seconds("--dead-man-s", args.dead_man_s)?;
    let duration = args.duration_s.map(|duration_s| seconds("--duration-s", duration_s)).transpose()?;
    // In lock-step time waits for the bus.
    if args.pace == Pace::Realtime && !args.over_budget {
        over_budget::refuse(&robot, &args.bus)?;
    }
    let watched = args.watch.open()?;
    let clock = Clock::new();
    let mut bus = open_bus(args, &robot, clock)?;
    let contents = contents(&args.bus, config, &robot.text);
    let log = args.log.as_deref().map(|path| open_log(path, &contents)).transpose()?;
    let start = if args.pace == Pace::Lockstep { Instant::ZERO } else { clock.now() + config.period };
    let punctuality = Punctuality::new(config.period.as_secs_f64());
    let live = watched.is_watched().then(|| {
        let name = args.config.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        watched.begin(&Run {
            name: &name,
            program: "canloop drive",
            start,
            duration_s: args.duration_s.filter(|_| args.pace == Pace::Realtime),
            stack: config,
            bit_rate_bit_s: robot.bit_rate_bit_s,
            contents: &contents,
        })
    });
    let mut reader = Reader { log, live, punctuality, start, periods: 0, said: None };
    let mut stack = Stack::new(config, start);
    if reader.log.is_some() {
        stack.tell_exchange();
    }
    if args.clear_fault {
        stack.operate(Operator::Reset);
    }
    stack.operate(Operator::Enable);
    say_unwatched(config);
    let stop = stop::listen();
    let (ended, degraded) = match args.pace {
        Pace::Lockstep => (LockStep::new(stack, bus.as_mut(), &mut reader, clock, patience).run(stop), Vec::new()),
        Pace::Realtime => {
            let until = duration.map_or(Instant::MAX, |duration| start + duration);
            let ended = realtime(stack, bus.as_mut(), &mut reader, clock, stop, until);
            say(reader.punctuality.figures());
            ended
        }
    };
    say_counts(&ended);
    if let Some(live) = reader.live.take() {
        live.end(&verdict(&ended));
    }
    finish(args, reader, &ended, &degraded)?;
    Ok(conclude(args, &ended))
}

fn open_bus(args: &Args, robot: &RobotFile, clock: Clock) -> Result<Box<dyn Bus + Send>, Problem> {
    // A log holds all of the bus's traffic, so then all of it is received; so do those who look on.
    let receive_all = args.log.is_some() || args.watch.is_watched();
    let receive = if receive_all { Vec::new() } else { ids_to_receive(&robot.stack.profile) };
    let options = OpenOptions { receive: &receive, bit_rate_bit_s: robot.bit_rate_bit_s, ..OpenOptions::default() };
    bus::open(&args.bus, &options, clock)
}

/// Closes the log and writes the summary, where they are wanted.
fn finish(args: &Args, reader: Reader, ended: &Ended, degraded: &[String]) -> Result<(), Problem> {
    let Reader { log, punctuality, periods, .. } = reader;
    let logged = log.map(McapLog::finish).transpose().map_err(cannot_log)?;
    let Some(path) = &args.summary else { return Ok(()) };
    let summary = Summary {
        version: env!("CARGO_PKG_VERSION"),
        config: &args.config.display().to_string(),
        overrides: &args.overrides,
        bus_address: &args.bus,
        pace: if args.pace == Pace::Lockstep { "lockstep" } else { "realtime" },
        end: word(&ended.end),
        state: ended.state.name(),
        state_text: ended.state.text(),
        period_s: punctuality.period_s(),
        periods,
        bus: ended.bus,
        punctuality: (args.pace == Pace::Realtime).then(|| punctuality.figures()),
        degraded,
        log: logged.map(|report| LogFigures { messages: report.messages, lost: report.events_lost }),
    };
    summary.write(path)
}

/// Says how a run ended, and gives the exit status.
fn conclude(args: &Args, Ended { end, state, .. }: &Ended) -> ExitCode {
    let (code, words) = match end {
        End::Over if args.pace == Pace::Lockstep => (ended_in(*state), "the other side ended the run".to_owned()),
        End::Over => (ended_in(*state), "the run is over; the drives were told to let go".to_owned()),
        End::Stopped => (ended_in(*state), "stopped; the drives were told to let go".to_owned()),
        End::Tripped => (1, "tripped; the drives were told to let go".to_owned()),
        End::Silent => (1, format!("nothing came from the other side for {} s", args.dead_man_s)),
        End::Lost(error) => (1, error.to_string()),
    };
    say(words);
    ExitCode::from(code)
}

/// How a run ended, in a word for those who look on.
fn verdict(Ended { end, state, .. }: &Ended) -> String {
    let word = word(end);
    if matches!(state, State::Tripped(_)) { state.text().to_owned() } else { word.to_owned() }
}

/// What could go wrong unseen is not left unsaid.
fn say_unwatched(config: &StackConfig) {
    let keys: Vec<&str> = config.safety.unwatched().collect();
    if !keys.is_empty() {
        say(format_args!("not watched, because [safety] gives no limit: {}", keys.join(", ")));
    }
}

fn say_counts(Ended { bus, .. }: &Ended) {
    let run::BusCounts { sent, received, delayed, given_up, lost } = bus;
    let mut line = format!("bus: {sent} frames sent, {received} received, {lost} lost");
    if *delayed > 0 {
        line += &format!("; the queue had no room {delayed} times, and {given_up} frames were given up");
    }
    say(line);
}

/// The loop on this thread, its reader on another. Tells, too, what the machine
/// did not allow the loop.
fn realtime(
    stack: Stack,
    bus: &mut dyn Bus,
    reader: &mut Reader,
    clock: Clock,
    stop: &StopSwitch,
    until: Instant,
) -> (Ended, Vec<String>) {
    let (mut tap, mut drain) = tap();
    std::thread::scope(|scope| {
        // Before the priority is raised: the reader must not inherit it.
        let reading = scope.spawn(move || {
            while drain.drain_into(reader) {
                pause();
            }
            if drain.lost() > 0 {
                say(format_args!("{} events are not in the log: it was written slower than they came", drain.lost()));
            }
        });
        let degraded = run::raise().into_iter().map(|Degraded { notice, refusal }| {
            say(format_args!("degraded: {refusal}"));
            tap.event(clock.now(), &Event::Notice(notice));
            refusal
        });
        let degraded = degraded.collect();
        let ended = RealTime::new(stack, bus, &mut tap, clock).run(stop, until);
        drop(tap);
        // A reader that panicked has said so itself.
        let _ = reading.join();
        (ended, degraded)
    })
}

#[allow(clippy::disallowed_methods, reason = "the reader waits for the loop, by the wall clock")]
fn pause() {
    std::thread::sleep(std::time::Duration::from_millis(5));
}

/// What a stack with these drives listens to, in lock-step too.
fn ids_to_receive(profile: &Profile) -> Vec<CanId> {
    profile.drive_ids().chain([StepEndCodec::builtin().id()]).collect()
}

/// The exit status of a run that ended in this state, all else being well.
fn ended_in(state: State) -> u8 {
    u8::from(matches!(state, State::Tripped(_)))
}
