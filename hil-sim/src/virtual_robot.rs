//! The robot as a controller sees it: two drives on a bus, with the plant
//! behind them.
//!
//! Like the stack it has no hands and no watch: frames and moments in, frames
//! out. The plant advances at each SYNC, by as much as it is told, so nothing
//! depends on when exactly the frames between two of them crossed.

use std::collections::VecDeque;

use canloop::frame::Frame;
use canloop::schema::{DriveState, Message, Profile};
use canloop::time::Instant;
use canloop::wheels::{Wheel, Wheels};

use crate::drive::{Drive, DriveSpec};
use crate::plant::{Plant, State};

/// Two drives and the plant that they move.
pub struct VirtualRobot {
    profile: Profile,
    plant: Plant,
    drives: Wheels<Drive>,
    /// SYNCs seen.
    ticks: u64,
    torque_applied_nm: Wheels<f64>,
    next_heartbeat: Instant,
    frames: VecDeque<(Wheel, Frame)>,
}

impl VirtualRobot {
    /// Drives that are switched on at `start` in front of `plant`.
    pub fn new(profile: Profile, plant: Plant, spec: DriveSpec, start: Instant) -> Self {
        Self {
            profile,
            plant,
            drives: Wheels::both(Drive::new(spec)),
            ticks: 0,
            torque_applied_nm: Wheels::default(),
            next_heartbeat: start,
            frames: VecDeque::with_capacity(16),
        }
    }

    /// Takes a frame from the bus; says whether it was a SYNC, which takes the
    /// plant on by `span_s`. What is no drive's business, or corrupt, is
    /// ignored, as a drive would.
    pub fn handle_frame(&mut self, frame: &Frame, span_s: f64) -> bool {
        match self.profile.decode(frame) {
            Ok(Message::Sync { counter }) => {
                self.sync(counter, span_s);
                true
            }
            Ok(Message::Command(wheel, command)) => {
                self.drives[wheel].take_command(command);
                false
            }
            _ => false,
        }
    }

    /// Whether a frame is valid and meant for the drives.
    pub fn is_addressed_by(&self, frame: &Frame) -> bool {
        matches!(self.profile.decode(frame), Ok(Message::Sync { .. } | Message::Command(..)))
    }

    /// Takes the plant on by a period of `span_s` in which no SYNC came.
    pub fn go_without_sync(&mut self, span_s: f64) {
        self.plant.advance(span_s, self.drives.as_ref().map(Drive::torque));
        for wheel in Wheel::BOTH {
            self.drives[wheel].go_without_sync(span_s);
            self.tell_fault(wheel);
        }
    }

    /// Takes note that `at` has come: heartbeats are due.
    pub fn handle_wakeup(&mut self, at: Instant) {
        if at < self.next_heartbeat {
            return;
        }
        self.next_heartbeat += self.profile.heartbeat_period;
        for wheel in Wheel::BOTH {
            self.send(wheel, Message::Heartbeat(wheel, self.drives[wheel].heartbeat()));
        }
    }

    /// When it next wants [`Self::handle_wakeup`].
    pub const fn next_wakeup(&self) -> Instant {
        self.next_heartbeat
    }

    /// The next frame a drive sends.
    pub fn poll_transmit(&mut self) -> Option<(Wheel, Frame)> {
        self.frames.pop_front()
    }

    /// SYNCs seen.
    pub const fn ticks(&self) -> u64 {
        self.ticks
    }

    /// The plant's state at the last SYNC.
    pub fn state(&self) -> &State {
        self.plant.state()
    }

    /// Whether both drives are enabled.
    pub fn is_enabled(&self) -> bool {
        self.drives.all(|drive| drive.heartbeat().state == DriveState::Enabled)
    }

    /// Mean torque at the wheels over the period that ended with the last
    /// SYNC, N m.
    pub const fn torque_applied_nm(&self) -> Wheels<f64> {
        self.torque_applied_nm
    }

    fn sync(&mut self, sync_counter: u8, span_s: f64) {
        // Nothing has moved before the first SYNC: it marks time zero.
        let span_s = if self.ticks == 0 { 0.0 } else { span_s };
        self.ticks += 1;
        if span_s > 0.0 {
            let torque = self.drives.as_ref().map(Drive::torque);
            self.plant.advance(span_s, torque);
        }
        let angle_rad = self.plant.state().angle_rad;
        for wheel in Wheel::BOTH {
            let drive = &mut self.drives[wheel];
            let counter = self.profile.feedback_counter(wheel, sync_counter);
            let feedback = drive.sync(span_s, angle_rad[wheel], counter);
            self.torque_applied_nm[wheel] = feedback.torque_applied_nm;
            self.tell_fault(wheel);
            self.send(wheel, Message::Feedback(wheel, feedback));
        }
    }

    fn tell_fault(&mut self, wheel: Wheel) {
        if let Some(fault) = self.drives[wheel].take_raised_fault() {
            self.send(wheel, Message::Fault(wheel, fault));
        }
    }

    fn send(&mut self, wheel: Wheel, message: Message) {
        self.frames.push_back((wheel, self.profile.encode(&message)));
    }
}
