//! A progress bar for work that takes over a second on a terminal.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Shows how far the work is, if it takes long enough for anybody to wonder.
pub struct Progress {
    started: Instant,
    bar: ProgressBar,
    shown: bool,
}

const PATIENCE: Duration = Duration::from_secs(1);
const REFRESH: Duration = Duration::from_millis(20);

impl Progress {
    /// Work of `length` steps.
    pub fn new(label: impl Into<String>, length: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::hidden());
        let style = ProgressStyle::with_template("{msg} {bar:40} {percent:>3} %  {eta} left");
        bar.set_style(style.expect("a constant template"));
        bar.set_message(label.into());
        Self { started: now(), bar, shown: false }
    }

    /// Work has come to step `position`.
    pub fn at(&mut self, position: u64) {
        if !self.shown && self.started.elapsed() > PATIENCE {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
            self.shown = true;
        }
        self.bar.set_position(position);
    }

    /// Lets others work for a moment before the bar is drawn anew.
    #[allow(clippy::disallowed_methods, reason = "nothing simulated waits")]
    pub fn wait(&self) {
        std::thread::sleep(REFRESH);
    }

    /// Wall-clock time since the work began, s.
    pub fn elapsed_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Takes the bar away.
    pub fn done(&self) {
        self.bar.finish_and_clear();
    }
}

#[allow(clippy::disallowed_methods, reason = "a person waits by the wall clock; nothing simulated sees it")]
fn now() -> Instant {
    Instant::now()
}
