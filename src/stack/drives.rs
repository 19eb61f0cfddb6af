//! The drives as the stack sees them: what they have reported, and in what
//! state they are.

use crate::estimator::Sample;
use crate::schema::{Feedback, Profile, StateId};
use crate::time::Instant;

/// What the stack knows of a drive.
#[derive(Clone, Copy, Debug)]
pub(super) struct DriveView {
    /// What has come of this period's feedback.
    pub sample: Sample,
    /// The parts that have come, a bit each.
    came: u8,
    /// The last state it reported.
    pub state: Option<StateId>,
    /// When what it reported last was so.
    pub sampled_at: Option<Instant>,
    /// Earlier SYNCs that it has yet to answer.
    owed: u32,
    /// The last count of feedback that counts by itself.
    own_count: Option<u8>,
}

/// What is to be thought of a piece of feedback.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// It belongs to this period.
    Fresh,
    /// It came already.
    Repeated,
    /// It answers a SYNC before the last.
    Late,
    /// It answers what nobody asked.
    Unasked,
}

impl DriveView {
    /// A drive that has not been heard of.
    pub const fn new() -> Self {
        let sample = Sample { position: None, speed_rad_s: None, torque_nm: 0.0 };
        Self { sample, came: 0, state: None, sampled_at: None, owed: 0, own_count: None }
    }

    /// Another period begins; if it `was_asked` in the one before and did not
    /// answer, it owes that.
    pub fn begin_period(&mut self, was_asked: bool) {
        self.owed = self.owed.saturating_add(u32::from(was_asked && self.came == 0));
        self.came = 0;
    }

    /// The same drive, which is taken to be in this state.
    pub fn believed_in(self, state: Option<StateId>) -> Self {
        Self { state, ..self }
    }

    /// Takes a part of the feedback; `expected` is the counter that it should
    /// have, where SYNC has one. What is not fresh changes nothing.
    #[inline]
    pub fn take(&mut self, feedback: &Feedback, expected: Option<u8>) -> Verdict {
        if feedback.counter.is_some() && !self.counts(feedback.counter, expected) {
            return self.odd(expected.is_some());
        }
        let part = 1 << feedback.part;
        if self.came & part != 0 {
            return Verdict::Repeated;
        }
        if self.came == 0 {
            // A drive's frames keep their order: what it owed until now is lost.
            self.owed = 0;
            self.sample = Sample::default();
        }
        self.came |= part;
        self.own_count = feedback.counter.or(self.own_count);
        self.sample.position = feedback.position.or(self.sample.position);
        self.sample.speed_rad_s = feedback.speed_rad_s.or(self.sample.speed_rad_s);
        self.sample.torque_nm = feedback.torque_applied_nm.unwrap_or(self.sample.torque_nm);
        Verdict::Fresh
    }

    /// Whether everything has come that it has to say of this period.
    #[inline]
    pub fn is_complete(&self, profile: &Profile) -> bool {
        self.came == u8::MAX >> (8 - profile.parts())
    }

    fn counts(&self, found: Option<u8>, expected: Option<u8>) -> bool {
        match expected {
            Some(_) => found == expected,
            None => found != self.own_count,
        }
    }

    /// Feedback with another counter: one that answers a SYNC that is still
    /// owed is late and worth nothing any more; any other nobody asked for.
    fn odd(&mut self, answers_sync: bool) -> Verdict {
        if !answers_sync {
            return Verdict::Repeated;
        }
        if self.owed == 0 {
            return Verdict::Unasked;
        }
        self.owed -= 1;
        Verdict::Late
    }
}
