//! `canloop drive`: the deployed program.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::{say, stop};
use crate::bus::{self, OpenOptions};
use crate::config::{Problem, Problems};
use crate::event::{Event, Sink};
use crate::log::{LogContents, LogError, LoggedBus, McapLog, WhenFull};
use crate::run::{Clock, End, LockStep};
use crate::safety::State;
use crate::stack::{Operator, Stack, StackConfig};
use crate::time::{Duration, Instant};

/// What `canloop drive` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
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
    #[arg(long, value_enum, default_value_t = Pace::Lockstep)]
    pace: Pace,
    /// Log everything to this MCAP file
    #[arg(long, value_name = "FILE.mcap")]
    log: Option<PathBuf>,
    /// In lock-step: how long the other side may be silent, s
    #[arg(long, default_value_t = 10.0, value_name = "SECONDS")]
    dead_man_s: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Pace {
    /// The far side's marker ends each period: for `hil-sim serve`
    Lockstep,
}

/// The stack's events, to a log if one is wanted.
struct Events {
    log: Option<McapLog>,
}

impl Sink for Events {
    fn event(&mut self, at: Instant, event: &Event) {
        if let Event::Notice(notice) = event {
            say(format_args!("{:>12.6} s  {}", at.as_secs_f64(), notice.text));
        }
        if let Some(log) = &mut self.log {
            log.event(at, event);
        }
    }
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Problems> {
    let Pace::Lockstep = args.pace;
    let (config, text) = StackConfig::load(&args.config.display().to_string(), &args.overrides)?;
    let patience = patience(args.dead_man_s)?;
    let clock = Clock::new();
    let mut bus = bus::open(&args.bus, &OpenOptions::default(), clock)?;
    let log = args.log.as_deref().map(|path| open_log(path, &args.bus, &config, &text)).transpose()?;
    let mut events = Events { log };
    let mut stack = Stack::new(&config, Instant::ZERO);
    stack.operate(Operator::Enable);
    let stop = stop::listen();
    let (end, state) = LockStep::new(stack, bus.as_mut(), &mut events, clock, patience).run(stop);
    if let Some(log) = events.log {
        log.finish().map_err(cannot_log)?;
    }
    let (code, words) = match end {
        End::Over => (ended_in(state), "the other side ended the run".to_owned()),
        End::Stopped => (ended_in(state), "stopped; the drives were told to let go".to_owned()),
        End::Silent => (1, format!("nothing came from the other side for {} s", args.dead_man_s)),
        End::Lost(error) => (1, error.to_string()),
    };
    say(words);
    Ok(ExitCode::from(code))
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
