//! What goes to the drives in a period, and what is made of what they leave
//! out.

use super::Stack;
use super::remainder::Remainder;
use crate::estimator::Sample;
use crate::schema::{Acts, Applied, Asks, Command, Conversation, DriveState, Message, Request};
use crate::time::Duration;
use crate::wheels::{Wheel, Wheels};

impl Stack {
    /// Makes the drives answer; what waited for that goes first, or right
    /// after the SYNC.
    pub(super) fn begin_period(&mut self) {
        self.drives.right.begin_period(self.ticks > 0);
        self.drives.left.begin_period(self.ticks > 0);
        self.send_sync();
        if self.profile.acts == Acts::OnArrival {
            let flows = self.chain.state().lets_torque_flow();
            self.speak(if flows { self.held_nm } else { Wheels::default() });
        }
        self.in_force_nm = [self.commanded_nm, self.in_force_nm[0]];
        if self.profile.asks == Asks::ByPoll {
            self.frames.extend(self.profile.polls().map(|poll| self.profile.encode(&poll)));
        }
    }

    /// Time between this sample of each wheel and the one before, s.
    pub(super) fn spans_s(&mut self) -> Wheels<f64> {
        let period = self.period;
        Wheels::from_fn(|wheel| {
            let now = self.drives[wheel].sampled_at.unwrap_or(self.sync_at);
            let last = self.sampled_at[wheel].replace(now);
            let span = last.map_or(period, |last| now - last);
            // Two reports cannot be of the same moment, whatever the clock says.
            if span > Duration::ZERO { span.as_secs_f64() } else { period.as_secs_f64() }
        })
    }

    /// Where drives do not report the torque that they applied, it is taken to
    /// be the one that they were asked for, as the frame could say it; where
    /// they report it coarsely, within a step of what they report.
    pub(super) fn with_torque(&self, samples: Wheels<Sample>) -> Wheels<Sample> {
        if !self.believes_commands {
            return samples;
        }
        let mut samples = samples;
        for wheel in Wheel::BOTH {
            let reported_nm = samples[wheel].torque_nm;
            let step_nm = match self.profile.applied_torque(wheel) {
                None => f64::INFINITY,
                Some(scale) if self.profile.applied == Applied::Coarse => scale.resolution_nm,
                Some(_) => continue,
            };
            let said_nm = self.profile.torque_as_said(wheel, self.in_force_nm[1][wheel]);
            samples[wheel].torque_nm = said_nm.clamp(reported_nm - step_nm, reported_nm + step_nm);
        }
        samples
    }

    /// Drives that never tell their state are taken to be in the one that they
    /// were asked to be in.
    pub(super) fn believe_silent_drives(&mut self) {
        if !self.profile.tells_state {
            let wish = if self.chain.request() == Request::Enable { DriveState::Enabled } else { DriveState::Ready };
            let state = self.profile.conversation.state_meaning(wish);
            self.drives = self.drives.map(|drive| drive.believed_in(state));
        }
    }

    pub(super) fn send_sync(&mut self) {
        if self.profile.has_sync() {
            self.sync_sent = self.sync_counter;
            self.send(&Message::Sync { counter: self.sync_counter });
            self.sync_counter = self.profile.next_sync_counter(self.sync_counter);
        }
    }

    /// What the gate lets through of a torque, N m, and of what the commands
    /// before could not say.
    pub(super) fn pass(&mut self, wanted_nm: Wheels<f64>) -> Wheels<f64> {
        if !self.profile.carries_remainder || !self.chain.state().lets_torque_flow() {
            self.remainder = Remainder::default();
            return self.chain.pass(wanted_nm);
        }
        let asked_nm = self.remainder.added_to(wanted_nm);
        let sent_nm = self.chain.pass(asked_nm);
        self.remainder.settle(&self.profile, asked_nm, sent_nm);
        sent_nm
    }

    /// Sends both drives a torque, N m, and what leads to the state wanted.
    pub(super) fn speak(&mut self, torque_nm: Wheels<f64>) {
        let request = self.chain.request();
        let states = self.drives.map(|drive| drive.state.unwrap_or(Conversation::FIRST));
        let commands = Wheels::from_fn(|wheel| {
            let counter = self.command_counters[wheel];
            self.command_counters[wheel] = self.profile.next_command_counter(wheel, counter);
            let word = self.profile.conversation.word_in_command(states[wheel], request);
            Message::Command(wheel, Command { torque_nm: torque_nm[wheel], word, counter })
        });
        if self.profile.shares_command() {
            self.frames.push(self.profile.encode_shared(&commands));
        } else {
            self.send(&commands.right);
            self.send(&commands.left);
        }
        for wheel in Wheel::BOTH {
            let words = self.profile.conversation.words_beside(states[wheel], request);
            self.frames.extend(words.map(|word| self.profile.encode(&Message::Word(wheel, word))));
        }
        self.commanded_nm = torque_nm;
        self.chain.request_was_sent();
    }
}
