//! What drives say, and what is to be thought of it.

use super::Stack;
use super::drives::Verdict;
use crate::safety::Reason;
use crate::schema::{Asks, DriveState, FaultCode, Feedback, Heartbeat, Message, StateId};
use crate::time::Instant;
use crate::wheels::Wheel;

impl Stack {
    /// Takes what a drive says.
    pub(super) fn take(&mut self, at: Instant, message: Message) {
        match message {
            Message::Feedback(wheel, feedback) => self.take_feedback(at, wheel, &feedback),
            Message::Heartbeat(wheel, Heartbeat { state, fault }) => {
                self.chain.take_heartbeat(wheel);
                self.take_state(wheel, state, Some(fault));
            }
            Message::Fault(wheel, fault) => self.take_state(wheel, None, Some(fault)),
            _ => {}
        }
    }

    fn take_feedback(&mut self, at: Instant, wheel: Wheel, feedback: &Feedback) {
        let echoes = self.profile.counter_echoes_sync;
        let expected = if echoes { self.profile.feedback_counter(wheel, self.sync_sent) } else { None };
        match self.drives[wheel].take(feedback, expected) {
            Verdict::Fresh => {}
            Verdict::Unasked => return self.chain.trip(Reason::CounterJump, Some(wheel)),
            Verdict::Late => {
                return self.note_oddity("feedback-late", "feedback came after the next SYNC had left and was ignored");
            }
            // Drives with a clock of their own may report more often than asked for.
            Verdict::Repeated if matches!(self.profile.asks, Asks::Nothing | Asks::ByCommand) => return,
            Verdict::Repeated => {
                return self.note_oddity("feedback-repeated", "feedback that had come already was ignored");
            }
        }
        self.take_state(wheel, feedback.state, feedback.fault);
        self.drives[wheel].sampled_at = Some(if self.profile.asks == Asks::Nothing { at } else { self.sync_at });
        if self.awaiting_feedback && self.drives.all(|drive| drive.is_complete(&self.profile)) {
            self.answer(self.drives.map(|drive| drive.sample));
        }
    }

    fn take_state(&mut self, wheel: Wheel, state: Option<StateId>, fault: Option<FaultCode>) {
        if fault.is_some_and(|fault| fault != FaultCode::None) {
            self.chain.trip(Reason::DriveFault, Some(wheel));
        }
        let Some(state) = state else { return };
        let before = self.drives[wheel].state.replace(state);
        let meaning = |state| self.profile.conversation.meaning(state);
        let (means, meant) = (meaning(state), before.map(meaning));
        if means == DriveState::Fault && meant != Some(means) {
            self.notice("drive-in-fault", "a drive is in its fault state, and stays there until it is cleared");
        }
        self.chain.take_drive_state(wheel, means);
    }
}
