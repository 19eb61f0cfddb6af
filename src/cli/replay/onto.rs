//! Plays a log onto a bus.

use std::path::Path;
use std::process::ExitCode;

use crate::bus::{self, Bus, BusError, OpenOptions};
use crate::cli::log_file::{named, open_log};
use crate::cli::{say, stop};
use crate::config::{Problem, Problems, nearest};
use crate::frame::Frame;
use crate::replay::Playback;
use crate::run::{Clock, StopSwitch};
use crate::time::{Duration, Instant};

/// How often to look whether somebody wants to stop.
const LOOK_UP: Duration = Duration::from_millis(50);
/// How soon to try again when the transmit queue was full.
const SOON: Duration = Duration::from_micros(100);
/// From the start to the first frame.
const BEFORE: Duration = Duration::from_millis(20);

/// What became of the frames.
#[derive(Default)]
struct Played {
    frames: u64,
    /// How late a frame left at most, s.
    latest_s: f64,
}

/// Plays one bus of a log so many times.
pub fn run(log: &Path, onto: &str, from_bus: Option<&str>, speed: f64, times: u32) -> Result<ExitCode, Problems> {
    if !(0.001..=1000.0).contains(&speed) {
        return Err(Problem::bare(format!("--speed will not do: found {speed}, expected 0.001 to 1000")).into());
    }
    let frames = frames_of(log, from_bus)?;
    let Some(&(first, _)) = frames.first() else {
        return Err(Problem::bare(format!("there is no frame to play in {}", log.display())).into());
    };
    let clock = Clock::new();
    let stop = stop::listen();
    let mut bus = bus::open(onto, &OpenOptions::default(), clock)?;
    say(format_args!("playing {} frames of {} onto {onto}", frames.len(), log.display()));
    let mut played = Played::default();
    for _ in 0..times {
        let playback = Playback::new(first, clock.now() + BEFORE, speed);
        for &(at, frame) in &frames {
            if !played.send(bus.as_mut(), &frame, playback.due(at), clock, stop)? {
                return Ok(tell(&played));
            }
        }
    }
    Ok(tell(&played))
}

impl Played {
    /// Sends a frame when it is due; false once somebody wants to stop.
    fn send(
        &mut self,
        bus: &mut dyn Bus,
        frame: &Frame,
        due: Instant,
        clock: Clock,
        stop: &StopSwitch,
    ) -> Result<bool, Problem> {
        let gone = |error: BusError| Problem::bare(error.to_string());
        loop {
            if stop.wish().is_some() {
                return Ok(false);
            }
            let now = clock.now();
            if now < due {
                // What others say meanwhile is nobody's business here.
                bus.receive(due.min(now + LOOK_UP)).map_err(gone)?;
                continue;
            }
            match bus.send(frame) {
                Ok(()) => {
                    self.frames += 1;
                    self.latest_s = self.latest_s.max((clock.now() - due).as_secs_f64());
                    return Ok(true);
                }
                Err(BusError::Full) => drop(bus.receive(now + SOON).map_err(gone)?),
                Err(error) => return Err(gone(error)),
            }
        }
    }
}

fn tell(played: &Played) -> ExitCode {
    say(format_args!("{} frames played, the latest {:.3} ms late", played.frames, played.latest_s * 1e3));
    ExitCode::SUCCESS
}

/// The frames of one bus of a log, in order of their moments.
fn frames_of(log: &Path, from_bus: Option<&str>) -> Result<Vec<(Instant, Frame)>, Problem> {
    let (_, mut reader) = open_log(log, None)?;
    let mut all = Vec::new();
    for item in reader.by_ref() {
        match item {
            Ok(record) => all.extend(record.frame().map(|frame| (record.at, record.bus, *frame))),
            Err(finding) => eprintln!("{}", finding.of(&named(log))),
        }
    }
    let names: Vec<&str> = reader.buses().names().iter().map(String::as_str).collect();
    let wanted = match from_bus {
        Some(name) => names.iter().position(|known| *known == name).ok_or_else(|| {
            let problem = Problem::bare(format!("there is no bus {name:?} in {}", log.display()));
            match nearest(name, names.iter().copied()) {
                Some(near) => problem.help(format!("did you mean `{near}`?")),
                None => problem.help(format!("there are {}", names.join(", "))),
            }
        })?,
        None if names.len() > 1 => {
            let problem = Problem::bare(format!("{} has several buses: {}", log.display(), names.join(", ")));
            return Err(problem.help("say with --from-bus which one is to be played"));
        }
        None => 0,
    };
    all.retain(|&(_, bus, _)| usize::from(bus) == wanted);
    // Logs of several buses are in order only by bus, and not all are at all.
    all.sort_by_key(|&(at, ..)| at);
    Ok(all.into_iter().map(|(at, _, frame)| (at, frame)).collect())
}
