//! The newest values of a run, and what has been counted so far.

use serde::Serialize;

use super::state_of;
use crate::event::{Notice, SyncEvent, Tick, Timing, Truth};
use crate::robot::{Pose, wrap_angle_rad};
use crate::wheels::{Wheel, Wheels};

/// What there is to know at this moment; nothing where nobody has told it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct Now {
    /// Since the run began, s.
    time_s: f64,
    /// The stack's state, as a word and as a sentence.
    state: Option<&'static str>,
    state_text: Option<&'static str>,
    robot: Option<Place>,
    reference: Option<Place>,
    position_error_m: Option<f64>,
    heading_error_rad: Option<f64>,
    right: WheelNow,
    left: WheelNow,
    /// How punctual a real-time loop is, s.
    lateness_s: Option<f64>,
    worst_lateness_s: Option<f64>,
    round_trip_s: Option<f64>,
    lost: Lost,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Place {
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
}

/// One wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
struct WheelNow {
    speed_rad_s: Option<f64>,
    target_speed_rad_s: Option<f64>,
    torque_wanted_nm: Option<f64>,
    torque_sent_nm: Option<f64>,
    torque_applied_nm: Option<f64>,
}

/// What did not arrive, or was of no use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
struct Lost {
    periods: u64,
    answered: u64,
    /// Periods before this one whose feedback was not complete.
    periods_unanswered: u64,
    /// Notices of frames that were lost on the way here.
    frames_lost: u64,
    frames_refused: u64,
    feedback_late: u64,
    feedback_repeated: u64,
}

impl Now {
    /// Time has come to this moment.
    pub const fn pass(&mut self, at_s: f64) {
        self.time_s = self.time_s.max(at_s);
    }

    /// A period begins.
    pub const fn take_sync(&mut self, sync: &SyncEvent) {
        self.reference = Some(Place::of(&sync.reference));
        self.lost.periods += 1;
        self.lost.periods_unanswered = (self.lost.periods - 1).saturating_sub(self.lost.answered);
    }

    /// The stack tells; where it is only odometry that knows where the robot is.
    pub fn take_tick(&mut self, tick: &Tick, knows_truth: bool) {
        self.lost.answered += 1;
        let state = state_of(tick.state);
        (self.state, self.state_text) = (state.map(|state| state.name()), state.map(|state| state.text()));
        self.reference = Some(Place::of(&tick.reference));
        if !knows_truth {
            self.robot = Some(Place::of(&tick.odometry));
            self.position_error_m = Some(tick.odometry.distance_m(&tick.reference));
            self.heading_error_rad = Some(wrap_angle_rad(tick.odometry.heading_rad - tick.reference.heading_rad));
        }
        for wheel in Wheel::BOTH {
            *self.wheel_mut(wheel) = WheelNow {
                speed_rad_s: Some(tick.speed_rad_s[wheel]),
                target_speed_rad_s: Some(tick.target_speed_rad_s[wheel]),
                torque_wanted_nm: Some(tick.torque_wanted_nm[wheel]),
                torque_sent_nm: Some(tick.torque_sent_nm[wheel]),
                torque_applied_nm: Some(tick.torque_applied_nm[wheel]),
            };
        }
    }

    /// The simulation tells; the wheels, too, where no stack does.
    pub fn take_truth(&mut self, truth: &Truth, knows_stack: bool) {
        self.robot = Some(Place::of(&truth.pose));
        self.position_error_m = Some(truth.position_error_m);
        self.heading_error_rad = Some(truth.heading_error_rad);
        if !knows_stack {
            self.take_wheels(truth.speed_rad_s, truth.torque_nm);
        }
    }

    /// A real-time loop tells.
    pub fn take_timing(&mut self, timing: &Timing) {
        self.lateness_s = Some(timing.lateness_s);
        self.worst_lateness_s = Some(self.worst_lateness_s.unwrap_or(0.0).max(timing.lateness_s));
        self.round_trip_s = Some(timing.round_trip_s).filter(|round_trip_s| round_trip_s.is_finite());
    }

    /// Counts what notices tell of losses.
    pub fn take_notice(&mut self, notice: &Notice) {
        let count = match notice.kind {
            "frames-lost" => &mut self.lost.frames_lost,
            "frame-refused" => &mut self.lost.frames_refused,
            "feedback-late" => &mut self.lost.feedback_late,
            "feedback-repeated" => &mut self.lost.feedback_repeated,
            _ => return,
        };
        *count += 1;
    }

    fn take_wheels(&mut self, speed_rad_s: Wheels<f64>, torque_nm: Wheels<f64>) {
        for wheel in Wheel::BOTH {
            let now = self.wheel_mut(wheel);
            now.speed_rad_s = Some(speed_rad_s[wheel]);
            now.torque_applied_nm = Some(torque_nm[wheel]);
        }
    }

    const fn wheel_mut(&mut self, wheel: Wheel) -> &mut WheelNow {
        match wheel {
            Wheel::Right => &mut self.right,
            Wheel::Left => &mut self.left,
        }
    }
}

impl Place {
    const fn of(pose: &Pose) -> Self {
        Self { x_m: pose.x_m, y_m: pose.y_m, heading_rad: pose.heading_rad }
    }
}
