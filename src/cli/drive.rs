//! `canloop drive`: the deployed program.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use super::{say, stop};
use crate::bus::{self, Bus, OpenOptions};
use crate::config::{Problem, Problems};
use crate::event::{Event, Sink};
use crate::log::{LogContents, LogError, LoggedBus, McapLog, WhenFull};
use crate::run::{self, Clock, End, LockStep, Priority, Punctuality, RealTime, tap};
use crate::safety::State;
use crate::stack::{Operator, Stack, StackConfig};
use crate::time::{Duration, Instant};

/// What `canloop drive` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  canloop drive --bus can0 --config robot.toml --log run.mcap
  canloop drive --bus vcan0 --config robot.toml --pace lockstep
  canloop drive --bus tcp://127.0.0.1:29536/can0 --config robot.toml --pace lockstep --log run.mcap

Ctrl-C sends zero torque and disables the drives before anything else.
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
    /// Log everything to this MCAP file
    #[arg(long, value_name = "FILE.mcap")]
    log: Option<PathBuf>,
    /// In lock-step: how long the other side may be silent, s
    #[arg(long, default_value_t = 10.0, value_name = "SECONDS")]
    dead_man_s: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Pace {
    /// The clock: for real drives, and for `hil-sim serve --time wall`
    Realtime,
    /// The far side's marker ends each period: for `hil-sim serve`
    Lockstep,
}

/// Reads the stack's events: tells people what they should know, and logs and
/// measures all.
struct Reader {
    log: Option<McapLog>,
    punctuality: Punctuality,
    start: Instant,
    /// The last thing said.
    said: Option<&'static str>,
}

impl Sink for Reader {
    fn event(&mut self, at: Instant, event: &Event) {
        if let Event::Notice(notice) = event {
            // What happens frame after frame is said once; the log has it all.
            if self.said != Some(notice.text) {
                say(format_args!("{:>12.6} s  {}", (at - self.start).as_secs_f64(), notice.text));
            }
            self.said = Some(notice.text);
        }
        self.punctuality.event(at, event);
        if let Some(log) = &mut self.log {
            log.event(at, event);
        }
    }
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Problems> {
    let (config, text) = StackConfig::load(&args.config.display().to_string(), &args.overrides)?;
    let patience = patience(args.dead_man_s)?;
    let clock = Clock::new();
    let mut bus = bus::open(&args.bus, &OpenOptions::default(), clock)?;
    let log = args.log.as_deref().map(|path| open_log(path, &args.bus, &config, &text)).transpose()?;
    let start = if args.pace == Pace::Lockstep { Instant::ZERO } else { clock.now() + config.period };
    let mut reader = Reader { log, punctuality: Punctuality::new(config.period.as_secs_f64()), start, said: None };
    let mut stack = Stack::new(&config, start);
    stack.operate(Operator::Enable);
    let stop = stop::listen();
    let (end, state) = match args.pace {
        Pace::Lockstep => LockStep::new(stack, bus.as_mut(), &mut reader, clock, patience).run(stop),
        Pace::Realtime => {
            let until = args.duration_s.map_or(Instant::MAX, |seconds| start + Duration::from_secs_f64(seconds));
            let ended = realtime(stack, bus.as_mut(), &mut reader, clock, stop, until);
            say(reader.punctuality.figures());
            ended
        }
    };
    if let Some(log) = reader.log {
        log.finish().map_err(cannot_log)?;
    }
    let (code, words) = match end {
        End::Over if args.pace == Pace::Lockstep => (ended_in(state), "the other side ended the run".to_owned()),
        End::Over => (ended_in(state), "the run is over".to_owned()),
        End::Stopped => (ended_in(state), "stopped; the drives were told to let go".to_owned()),
        End::Tripped => (1, "tripped; the drives were told to let go".to_owned()),
        End::Silent => (1, format!("nothing came from the other side for {} s", args.dead_man_s)),
        End::Lost(error) => (1, error.to_string()),
    };
    say(words);
    Ok(ExitCode::from(code))
}

/// The loop on this thread, its reader on another.
fn realtime(
    stack: Stack,
    bus: &mut dyn Bus,
    reader: &mut Reader,
    clock: Clock,
    stop: &AtomicBool,
    until: Instant,
) -> (End, State) {
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
        let Priority { scheduling, memory } = run::raise();
        for degraded in [scheduling, memory].into_iter().filter_map(Result::err) {
            say(format_args!("degraded: {degraded}"));
        }
        let end = RealTime::new(stack, bus, &mut tap, clock).run(stop, until);
        drop(tap);
        // A reader that panicked has said so itself.
        let _ = reading.join();
        end
    })
}

#[allow(clippy::disallowed_methods, reason = "the reader waits for the loop, by the wall clock")]
fn pause() {
    std::thread::sleep(std::time::Duration::from_millis(5));
}

/// The exit status of a run that ended in this state, all else being well.
fn ended_in(state: State) -> u8 {
    u8::from(matches!(state, State::Tripped(_)))
}

fn patience(seconds: f64) -> Result<Duration, Problem> {
    if (0.001..=86_400.0).contains(&seconds) {
        return Ok(Duration::from_secs_f64(seconds));
    }
    Err(Problem::bare(format!("--dead-man-s will not do: found {seconds}, expected 0.001 to 86400")))
}

/// A log that holds what it takes to understand and repeat the run.
fn open_log(path: &Path, bus: &str, config: &StackConfig, text: &str) -> Result<McapLog, Problem> {
    let profile = &config.profile;
    let file = |name: String, media_type: &str, text: &str| (name, media_type.to_owned(), text.into());
    let contents = LogContents {
        buses: vec![LoggedBus { name: bus.rsplit('/').next().unwrap_or(bus), dbcs: vec![&profile.dbc] }],
        attachments: vec![
            file("robot.toml".to_owned(), "application/toml", text),
            file(format!("{}.toml", profile.name), "application/toml", &profile.toml_text),
            file(format!("{}.dbc", profile.name), "text/plain", &profile.dbc.source.text),
        ],
        metadata: BTreeMap::from([
            ("program".to_owned(), "canloop drive".to_owned()),
            ("version".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
        ]),
    };
    McapLog::create(path, &contents, WhenFull::Wait).map_err(cannot_log)
}

fn cannot_log(error: LogError) -> Problem {
    Problem::bare(error.to_string())
}
