//! Everything that can be observed of a run, as one typed list. Log, summary,
//! report and expectations read these events and nothing else.

use crate::exchange::Exchange;
use crate::frame::Frame;
use crate::robot::{Pose, Twist};
use crate::time::Instant;
use crate::wheels::Wheels;

/// Something that happened.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "events live in reused buffers; a box would allocate every tick")]
pub enum Event {
    /// A frame crossed a bus; the time stamp is the end of the frame.
    Frame(BusFrame),
    /// The stack began a period.
    Sync(SyncEvent),
    /// The stack took a period's feedback and answered it.
    Tick(Tick),
    /// What the plant really did; only a simulation knows.
    Truth(Truth),
    /// How punctual a real-time loop was in a period.
    Timing(Timing),
    /// The stack changed its state, or refused something, and why.
    Notice(Notice),
    /// Something that a scenario planned began or ended.
    Mark(Mark),
    /// Something went into the stack or came out of it: told where somebody
    /// wants to replay it.
    Exchange(Exchange),
}

/// A reader of events.
pub trait Sink {
    /// Takes one event. Times never decrease from call to call.
    fn event(&mut self, at: Instant, event: &Event);

    /// Whether it has a use for [`Event::Exchange`].
    fn wants_exchange(&self) -> bool {
        false
    }
}

/// A frame as seen on a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusFrame {
    /// Which bus, as an index into the run's list of them.
    pub bus: u8,
    /// Whether the stack sent it.
    pub sent_by_stack: bool,
    /// The frame.
    pub frame: Frame,
}

/// The beginning of a period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SyncEvent {
    /// Periods since the stack was made.
    pub tick: u64,
    /// Where the path wants the robot at this moment.
    pub reference: Pose,
}

/// The stack's own state, once a period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tick {
    /// Periods since the stack was made.
    pub tick: u64,
    /// The safety state as a number.
    pub state: u8,
    /// Where the path wants the robot.
    pub reference: Pose,
    /// How fast the path wants it to move.
    pub reference_twist: Twist,
    /// Where odometry believes it to be.
    pub odometry: Pose,
    /// Wheel angles wanted, rad.
    pub target_angle_rad: Wheels<f64>,
    /// Wheel speeds wanted, rad/s.
    pub target_speed_rad_s: Wheels<f64>,
    /// Wheel angles measured, rad.
    pub angle_rad: Wheels<f64>,
    /// Wheel speeds measured, rad/s.
    pub speed_rad_s: Wheels<f64>,
    /// Wheel accelerations measured, rad/s^2.
    pub acceleration_rad_s2: Wheels<f64>,
    /// Torque that the drives say they applied in the period that has ended, N m.
    pub torque_applied_nm: Wheels<f64>,
    /// Torque that the law asked for, N m.
    pub torque_wanted_nm: Wheels<f64>,
    /// Torque that the safety gate let through, N m.
    pub torque_sent_nm: Wheels<f64>,
}

/// The plant's state at the beginning of a period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Periods since the run began.
    pub tick: u64,
    /// Where the robot is.
    pub pose: Pose,
    /// Its distance from the reference, m.
    pub position_error_m: f64,
    /// Its heading less the reference's, wrapped to +-pi, rad.
    pub heading_error_rad: f64,
    /// Wheel angles, rad.
    pub angle_rad: Wheels<f64>,
    /// Wheel speeds, rad/s.
    pub speed_rad_s: Wheels<f64>,
    /// Mean torque at the wheels over the period that has ended, N m.
    pub torque_nm: Wheels<f64>,
}

/// How punctual a real-time loop was in a period; all in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// Periods since the stack was made.
    pub tick: u64,
    /// How late the loop woke up to send SYNC.
    pub lateness_s: f64,
    /// From that SYNC to the one before.
    pub period_s: f64,
    /// From handing the SYNC before to the bus to the last feedback that
    /// answered it; NaN if none did.
    pub round_trip_s: f64,
    /// What the stack took to make torques of that feedback; NaN if none came.
    pub compute_s: f64,
}

/// A thing worth telling a person.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Notice {
    /// Stable word for machines, such as `tripped`.
    pub kind: &'static str,
    /// One sentence for people.
    pub text: &'static str,
}

/// The beginning or the end of something that a scenario planned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mark {
    /// Which, as an index into the scenario's events.
    pub event: u16,
    /// Whether it has begun; else it has ended.
    pub has_begun: bool,
}

impl Mark {
    /// What it says to people, given the names of what was planned.
    pub fn text(self, planned: &[String]) -> String {
        let name = planned.get(usize::from(self.event)).map_or("an event", String::as_str);
        format!("{name} {}", if self.has_begun { "begins" } else { "ends" })
    }
}

impl Notice {
    /// Every `kind` that a stack tells in lock-step.
    pub const KINDS: [&'static str; 12] = [
        "boot",
        "stopped",
        "enabling",
        "running",
        "stopping",
        "tripped",
        "culprit",
        "drive-in-fault",
        "frame-refused",
        "feedback-late",
        "feedback-repeated",
        "new-path",
    ];
}

impl Tick {
    /// Names of [`Self::values`], unit last.
    pub const NAMES: [&'static str; 26] = [
        "tick",
        "state",
        "reference_x_m",
        "reference_y_m",
        "reference_heading_rad",
        "reference_speed_m_s",
        "reference_yaw_rate_rad_s",
        "odometry_x_m",
        "odometry_y_m",
        "odometry_heading_rad",
        "target_angle_right_rad",
        "target_angle_left_rad",
        "target_speed_right_rad_s",
        "target_speed_left_rad_s",
        "angle_right_rad",
        "angle_left_rad",
        "speed_right_rad_s",
        "speed_left_rad_s",
        "acceleration_right_rad_s2",
        "acceleration_left_rad_s2",
        "torque_applied_right_nm",
        "torque_applied_left_nm",
        "torque_wanted_right_nm",
        "torque_wanted_left_nm",
        "torque_sent_right_nm",
        "torque_sent_left_nm",
    ];

    /// Every field as a number, in the order of [`Self::NAMES`].
    pub fn values(&self) -> [f64; 26] {
        [
            self.tick as f64,
            f64::from(self.state),
            self.reference.x_m,
            self.reference.y_m,
            self.reference.heading_rad,
            self.reference_twist.speed_m_s,
            self.reference_twist.yaw_rate_rad_s,
            self.odometry.x_m,
            self.odometry.y_m,
            self.odometry.heading_rad,
            self.target_angle_rad.right,
            self.target_angle_rad.left,
            self.target_speed_rad_s.right,
            self.target_speed_rad_s.left,
            self.angle_rad.right,
            self.angle_rad.left,
            self.speed_rad_s.right,
            self.speed_rad_s.left,
            self.acceleration_rad_s2.right,
            self.acceleration_rad_s2.left,
            self.torque_applied_nm.right,
            self.torque_applied_nm.left,
            self.torque_wanted_nm.right,
            self.torque_wanted_nm.left,
            self.torque_sent_nm.right,
            self.torque_sent_nm.left,
        ]
    }
}

impl Timing {
    /// Names of [`Self::values`], unit last.
    pub const NAMES: [&'static str; 5] = ["tick", "lateness_s", "period_s", "round_trip_s", "compute_s"];

    /// Every field as a number, in the order of [`Self::NAMES`].
    pub fn values(&self) -> [f64; 5] {
        [self.tick as f64, self.lateness_s, self.period_s, self.round_trip_s, self.compute_s]
    }
}

impl Truth {
    /// Names of [`Self::values`], unit last.
    pub const NAMES: [&'static str; 12] = [
        "tick",
        "x_m",
        "y_m",
        "heading_rad",
        "position_error_m",
        "heading_error_rad",
        "true_angle_right_rad",
        "true_angle_left_rad",
        "true_speed_right_rad_s",
        "true_speed_left_rad_s",
        "torque_right_nm",
        "torque_left_nm",
    ];

    /// Every field as a number, in the order of [`Self::NAMES`].
    pub fn values(&self) -> [f64; 12] {
        [
            self.tick as f64,
            self.pose.x_m,
            self.pose.y_m,
            self.pose.heading_rad,
            self.position_error_m,
            self.heading_error_rad,
            self.angle_rad.right,
            self.angle_rad.left,
            self.speed_rad_s.right,
            self.speed_rad_s.left,
            self.torque_nm.right,
            self.torque_nm.left,
        ]
    }
}
