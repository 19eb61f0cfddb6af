//! What happened: notices and marks, the newest last.

use std::borrow::Cow;
use std::collections::VecDeque;

use serde::Serialize;

/// Things that are kept, at most.
const KEPT: usize = 100;

/// The newest things that happened.
#[derive(Clone, Debug, Default)]
pub(super) struct Happenings {
    kept: VecDeque<Happening>,
    /// Older ones that are not kept any more.
    forgotten: u64,
    /// Counts the changes of all this.
    version: u64,
}

/// Something that happened, perhaps many times in a row.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Happening {
    /// When first, s after the run's beginning.
    at_s: f64,
    kind: &'static str,
    text: Cow<'static, str>,
    times: u64,
}

/// All that is known of what happened.
#[derive(Debug, Serialize)]
pub(super) struct NewHappenings<'h> {
    forgotten: u64,
    kept: &'h VecDeque<Happening>,
}

impl Happenings {
    /// Something happened. What happens again and again, frame after frame, is
    /// one thing with a count.
    pub fn take(&mut self, at_s: f64, kind: &'static str, text: impl Into<Cow<'static, str>>) {
        let text = text.into();
        self.version += 1;
        match self.kept.back_mut() {
            Some(last) if last.kind == kind && last.text == text => last.times += 1,
            _ => self.kept.push_back(Happening { at_s, kind, text, times: 1 }),
        }
        if self.kept.len() > KEPT {
            self.kept.pop_front();
            self.forgotten += 1;
        }
    }

    /// All of it, if any of it is new to a viewer who saw it when it had the
    /// version `seen`.
    pub fn news(&self, seen: &mut u64) -> Option<NewHappenings<'_>> {
        let is_new = std::mem::replace(seen, self.version) != self.version;
        is_new.then_some(NewHappenings { forgotten: self.forgotten, kept: &self.kept })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_happens_again_and_again_is_one_thing_with_a_count() {
        let mut happenings = Happenings::default();
        happenings.take(1.0, "running", "running");
        (0..5).for_each(|_| happenings.take(2.0, "frame-refused", "a frame was damaged"));
        happenings.take(3.0, "event", "a push begins".to_owned());
        let told: Vec<_> = happenings.kept.iter().map(|one| (one.at_s, one.kind, one.times)).collect();
        assert_eq!(told, [(1.0, "running", 1), (2.0, "frame-refused", 5), (3.0, "event", 1)]);
    }

    #[test]
    fn the_newest_are_kept_and_the_others_counted() {
        let mut happenings = Happenings::default();
        (0..250).for_each(|nth| happenings.take(0.0, "event", format!("event {nth} begins")));
        assert_eq!((happenings.kept.len(), happenings.forgotten), (KEPT, 150));
        assert_eq!(happenings.kept.back().unwrap().text, "event 249 begins");
    }

    #[test]
    fn a_viewer_is_told_only_what_is_new() {
        let mut happenings = Happenings::default();
        let mut seen = 0;
        assert!(happenings.news(&mut seen).is_none());
        happenings.take(0.0, "boot", "boot");
        assert!(happenings.news(&mut seen).is_some());
        assert!(happenings.news(&mut seen).is_none());
    }
}
