//! Whether the log of a run has every frame that crossed the bus.

use std::path::Path;

use canloop::event::{Event, Sink};
use canloop::time::Instant;
use canloop::traffic;

use crate::bench::Outcome;
use crate::frames_hash::FramesHash;
use crate::recording::Recording;
use crate::scenario::Scenario;

/// A run that is logged while somebody else watches it.
pub struct Logged<'s, W> {
    recording: Recording<'s>,
    watcher: W,
}

impl<'s, W: Sink> Logged<'s, W> {
    /// Logs a run of `scenario` to the file at `path`.
    ///
    /// # Errors
    /// Why there is no log.
    pub fn new(scenario: &'s Scenario, path: &Path, watcher: W) -> Result<Self, String> {
        let recording = Recording::new(scenario).with_log(path).map_err(|error| error.to_string())?;
        Ok(Self { recording, watcher })
    }

    /// Ends the log of a run that ended so, and reads it again. Gives back who
    /// watched, and what is wrong with the log, if anything is.
    pub fn finish(self, outcome: &Outcome, path: &Path) -> (W, Option<String>) {
        let finished = self.recording.finish(outcome);
        let wrong = match finished.log_error {
            Some(error) => Some(error.to_string()),
            None => match hash_of(path) {
                Ok(hash) if hash == finished.summary.frames_blake3 => None,
                Ok(_) => Some("the log has not the frames that crossed the bus".to_owned()),
                Err(what) => Some(format!("the log cannot be read: {what}")),
            },
        };
        (self.watcher, wrong)
    }
}

impl<W: Sink> Sink for Logged<'_, W> {
    fn event(&mut self, at: Instant, event: &Event) {
        self.recording.event(at, event);
        self.watcher.event(at, event);
    }

    fn wants_exchange(&self) -> bool {
        true
    }
}

/// That of [`crate::summary::Summary::frames_blake3`], over what a log holds.
fn hash_of(path: &Path) -> Result<String, String> {
    let (_, reader) = traffic::open(path, None).map_err(|problem| problem.to_string())?;
    let mut hash = FramesHash::new();
    for item in reader {
        let record = item.map_err(|finding| finding.title)?;
        if let Some(frame) = record.frame() {
            hash.take(record.at, frame);
        }
    }
    Ok(hash.finish())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench;

    struct Nobody;

    impl Sink for Nobody {
        fn event(&mut self, _at: Instant, _event: &Event) {}
    }

    /// What is wrong with the log of a short run after `harm` was done to it.
    fn wrong(harm: impl FnOnce(&Path)) -> Option<String> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run.mcap");
        let short = ["duration_s=1".to_owned(), "expect=[]".to_owned()];
        let scenario = Scenario::load("dac-friction", &short).expect("it is shipped");
        let mut logged = Logged::new(&scenario, &path, Nobody).expect("a log");
        let outcome = bench::run(&scenario, &mut logged, |_| std::ops::ControlFlow::Continue(()));
        harm(&path);
        logged.finish(&outcome, &path).1
    }

    #[test]
    fn a_log_with_all_frames_is_right() {
        assert_eq!(wrong(|_| {}), None);
    }

    #[test]
    fn a_log_that_is_not_there_is_found_out() {
        let what = wrong(|path| std::fs::remove_file(path).expect("it is there"));
        assert!(what.expect("it is gone").contains("cannot be read"));
    }
}
