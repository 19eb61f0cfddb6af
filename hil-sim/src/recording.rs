//! One run and all that is kept of it: figures always, a log and samples for
//! pictures where they are wanted; and those who look on are shown it.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;

use canloop::event::{Event, Sink};
use canloop::live::{Feed, Live, Run};
use canloop::log::{LogContents, LogError, LoggedBus, McapLog, WhenFull};
use canloop::time::Instant;

use crate::bench::{self, Outcome};
use crate::report::History;
use crate::scenario::{Link, Scenario};
use crate::summary::{Gauge, LogFigures, Summary};
use crate::trace::Trace;

/// Reads a run's events and keeps what is wanted.
pub struct Recording<'s> {
    scenario: &'s Scenario,
    gauge: Gauge,
    log: Option<McapLog>,
    trace: Option<Trace>,
    history: Option<History>,
    live: Option<Feed>,
}

impl<'s> Recording<'s> {
    /// Keeps the figures of a run of `scenario`.
    pub fn new(scenario: &'s Scenario) -> Self {
        Self { scenario, gauge: Gauge::new(scenario), log: None, trace: None, history: None, live: None }
    }

    /// Keeps the figures of a run whose stack is another program.
    pub fn of_another_stack(scenario: &'s Scenario) -> Self {
        Self { gauge: Gauge::of_commands(scenario), ..Self::new(scenario) }
    }

    /// Keeps everything in an MCAP file, too.
    pub fn with_log(mut self, path: &Path) -> Result<Self, LogError> {
        self.log = Some(McapLog::create(path, &contents(self.scenario), WhenFull::Wait)?);
        Ok(self)
    }

    /// Keeps samples for pictures, too.
    pub fn with_trace(mut self, samples: u64) -> Self {
        self.trace = Some(Trace::new(self.scenario.ticks(), self.scenario.period_s(), samples));
        self
    }

    /// Keeps what the run's page shows, too.
    pub fn with_history(mut self) -> Self {
        self.history = Some(History::new(self.scenario));
        self
    }

    /// Shows it to whoever looks on, too; `start` is the moment that it begins
    /// at.
    pub fn with_live(mut self, live: &Live, program: &'static str, start: Instant) -> Self {
        let scenario = self.scenario;
        self.live = live.is_watched().then(|| {
            live.begin(&Run {
                name: &scenario.name,
                program,
                start,
                duration_s: Some(scenario.duration_s),
                stack: &scenario.stack,
                bit_rate_bit_s: match scenario.link {
                    Link::Can(rates) => Some(rates.nominal_bit_s),
                    Link::Ideal => None,
                },
                contents: &contents(scenario),
            })
        });
        self
    }

    /// Runs the scenario in this process.
    pub fn run(mut self, progress: impl FnMut(u64) -> ControlFlow<()>) -> Finished {
        let outcome = bench::run(self.scenario, &mut self, progress);
        self.finish(&outcome)
    }

    /// Closes what was kept of a run that ended so.
    pub fn finish(self, outcome: &Outcome) -> Finished {
        let mut summary = self.gauge.summary(self.scenario, outcome);
        if let Some(live) = self.live {
            live.end(summary.verdict());
        }
        let log = self.log.map(McapLog::finish).transpose();
        if let Ok(Some(report)) = &log {
            summary.log = Some(LogFigures { messages: report.messages, queue_full: report.waits });
        }
        Finished { summary, trace: self.trace, history: self.history, log_error: log.err() }
    }
}

/// What is left of a run.
#[derive(Debug)]
pub struct Finished {
    /// Its figures.
    pub summary: Summary,
    /// Samples for pictures, where they were wanted.
    pub trace: Option<Trace>,
    /// What the run's page shows, where it was wanted.
    pub history: Option<History>,
    /// Why the log ends early, if it does; the figures are complete all the same.
    pub log_error: Option<LogError>,
}

impl Sink for Recording<'_> {
    fn wants_exchange(&self) -> bool {
        self.log.is_some()
    }

    fn event(&mut self, at: Instant, event: &Event) {
        self.gauge.event(at, event);
        if let Some(log) = &mut self.log {
            log.event(at, event);
        }
        if let Some(trace) = &mut self.trace {
            trace.event(at, event);
        }
        if let Some(history) = &mut self.history {
            history.event(at, event);
        }
        if let Some(live) = &mut self.live {
            live.event(at, event);
        }
    }
}

/// What a log, and who looks on, is told before the first event.
fn contents(scenario: &Scenario) -> LogContents<'_> {
    LogContents {
        buses: vec![LoggedBus { name: "can0", dbcs: vec![&scenario.stack.profile.dbc] }],
        planned: scenario.events.iter().map(|event| event.name.clone()).collect(),
        attachments: attachments(scenario),
        metadata: metadata(scenario),
    }
}

/// What it takes to understand and repeat the run from its log alone.
fn attachments(scenario: &Scenario) -> Vec<(String, String, Vec<u8>)> {
    let profile = &scenario.stack.profile;
    let file = |name: &str, media_type: &str, text: &str| (name.to_owned(), media_type.to_owned(), text.into());
    vec![
        file("scenario.toml", "application/toml", &scenario.text),
        file(&format!("{}.toml", profile.name), "application/toml", &profile.toml_text),
        file(&format!("{}.dbc", profile.name), "text/plain", &profile.dbc.source.text),
    ]
}

fn metadata(scenario: &Scenario) -> BTreeMap<String, String> {
    let entries = [
        ("program", "hil-sim".to_owned()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("scenario", scenario.name.clone()),
        ("seed", scenario.seed.to_string()),
    ];
    entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}
