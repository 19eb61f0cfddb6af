//! What is kept and told of a run: notices at once, all events in a log, the
//! figures in a summary.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use crate::bus::bus_name;
use crate::cli::say;
use crate::config::Problem;
use crate::event::{Event, Sink};
use crate::live::Feed;
use crate::log::{LogContents, LogError, LoggedBus, McapLog, WhenFull};
use crate::run::{BusCounts, DEGRADED, End, LoopFigures, Punctuality};
use crate::stack::StackConfig;
use crate::time::Instant;

/// Reads the stack's events: tells people what they should know, logs and
/// measures all, and shows it to whoever looks on.
pub struct Reader {
    pub log: Option<McapLog>,
    pub live: Option<Feed>,
    pub punctuality: Punctuality,
    pub start: Instant,
    /// Periods that the stack began.
    pub periods: u64,
    /// The last thing said.
    pub said: Option<&'static str>,
}

/// The figures of a run, as `--summary` writes them.
#[derive(Debug, Serialize)]
pub struct Summary<'r> {
    pub version: &'static str,
    pub config: &'r str,
    pub overrides: &'r [String],
    pub bus_address: &'r str,
    pub pace: &'static str,
    /// How it ended: `over`, `stopped`, `tripped`, `silent` or `lost`.
    pub end: &'static str,
    /// What the stack was doing before it said goodbye.
    pub state: &'static str,
    /// The same as a sentence, with the reason of a trip.
    pub state_text: &'static str,
    pub period_s: f64,
    pub periods: u64,
    pub bus: BusCounts,
    /// How punctual the loop was; `null` in lock-step, which has no clock.
    #[serde(rename = "loop")]
    pub punctuality: Option<LoopFigures>,
    pub degraded: &'r [String],
    /// `null` without a log.
    pub log: Option<LogFigures>,
}

/// What went into the log.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LogFigures {
    pub messages: u64,
    /// Events that came faster than they could be passed on.
    pub lost: u64,
}

impl Sink for Reader {
    fn event(&mut self, at: Instant, event: &Event) {
        match event {
            // What happens frame after frame is said once; the log has it all. What the
            // machine does not allow is said with what would allow it.
            Event::Notice(notice) if self.said != Some(notice.text) && notice.kind != DEGRADED => {
                say(format_args!("{:>12.6} s  {}", (at - self.start).as_secs_f64(), notice.text));
                self.said = Some(notice.text);
            }
            Event::Sync(_) => self.periods += 1,
            _ => {}
        }
        self.punctuality.event(at, event);
        if let Some(log) = &mut self.log {
            log.event(at, event);
        }
        if let Some(live) = &mut self.live {
            live.event(at, event);
        }
    }
}

/// A word for machines.
pub const fn word(end: &End) -> &'static str {
    match end {
        End::Over => "over",
        End::Stopped => "stopped",
        End::Tripped => "tripped",
        End::Silent => "silent",
        End::Lost(_) => "lost",
    }
}

/// What a log holds, so that the run can be understood and repeated.
pub fn contents<'a>(bus: &'a str, config: &'a StackConfig, text: &str) -> LogContents<'a> {
    let profile = &config.profile;
    let file = |name: String, media_type: &str, text: &str| (name, media_type.to_owned(), text.into());
    LogContents {
        buses: vec![LoggedBus { name: bus_name(bus), dbcs: vec![&profile.dbc] }],
        attachments: vec![
            file("robot.toml".to_owned(), "application/toml", text),
            file(format!("{}.toml", profile.name), "application/toml", &profile.toml_text),
            file(format!("{}.dbc", profile.name), "text/plain", &profile.dbc.source.text),
        ],
        planned: Vec::new(),
        metadata: BTreeMap::from([
            ("program".to_owned(), "canloop drive".to_owned()),
            ("version".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
        ]),
    }
}

pub fn open_log(path: &Path, contents: &LogContents<'_>) -> Result<McapLog, Problem> {
    McapLog::create(path, contents, WhenFull::Wait).map_err(cannot_log)
}

pub fn cannot_log(error: LogError) -> Problem {
    Problem::bare(error.to_string())
}

impl Summary<'_> {
    /// Writes it as JSON.
    pub fn write(&self, path: &Path) -> Result<(), Problem> {
        let mut json = serde_json::to_string_pretty(self).expect("a summary is plain data");
        json.push('\n');
        std::fs::write(path, json).map_err(|error| Problem::bare(format!("cannot write {}: {error}", path.display())))
    }
}
