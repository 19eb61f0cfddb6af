//! What frames tell: how full the bus is, and what the drives are doing.

use serde::Serialize;

use crate::bus::frame_bits;
use crate::event::BusFrame;
use crate::schema::{DriveState, Message, Profile};
use crate::wheels::Wheels;

/// A bus as frames cross it.
#[derive(Clone, Debug)]
pub(super) struct BusView {
    profile: Profile,
    frames: u64,
    drives: Wheels<Option<DriveState>>,
}

/// What the drives say they are doing; nothing until they have spoken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct Drives {
    right: Option<&'static str>,
    left: Option<&'static str>,
}

impl BusView {
    /// A bus with drives of this profile.
    pub fn new(profile: &Profile) -> Self {
        Self { profile: profile.clone(), frames: 0, drives: Wheels::default() }
    }

    /// A frame crossed the bus; tells how many bit times it took.
    pub fn take(&mut self, crossed: &BusFrame) -> u32 {
        self.frames += 1;
        if !crossed.sent_by_stack {
            let said = self.profile.decode(&crossed.frame).ok();
            let other = self.profile.decode_other(&crossed.frame);
            said.into_iter().chain(other).for_each(|message| self.hear(&message));
        }
        frame_bits(&crossed.frame)
    }

    /// Frames so far.
    pub const fn frames(&self) -> u64 {
        self.frames
    }

    /// The drives' states.
    pub fn drives(&self) -> Drives {
        Drives { right: self.drives.right.map(word), left: self.drives.left.map(word) }
    }

    fn hear(&mut self, message: &Message) {
        let (wheel, state) = match message {
            Message::Feedback(wheel, feedback) => (*wheel, feedback.state),
            Message::Heartbeat(wheel, heartbeat) => (*wheel, heartbeat.state),
            _ => return,
        };
        if let Some(state) = state {
            self.drives[wheel] = Some(self.profile.conversation.meaning(state));
        }
    }
}

const fn word(state: DriveState) -> &'static str {
    match state {
        DriveState::Boot => "boot",
        DriveState::Ready => "ready",
        DriveState::Enabled => "enabled",
        DriveState::Fault => "fault",
    }
}
