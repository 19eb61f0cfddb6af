//! Each thing that can go wrong is made to go wrong on a bus, over the wire and
//! in front of the plant. The stack trips for that reason, torque is gone as
//! soon as README.md says, and nothing moves again before reset and enable.

use canloop::event::{Event, Tick};
use canloop::frame::Frame;
use canloop::safety::{Operator, Reason, State};
use canloop::schema::{Command, FaultCode, Feedback, Message, Profile};
use canloop::stack::Stack;
use canloop::time::Instant;
use canloop::wheels::{Wheel, Wheels};
use hil_sim::far_side::{FarSide, Happening};
use hil_sim::scenario::{Link, Scenario};

/// A reason, how it is caused here, and how long it takes from the cause until
/// neither wheel has any torque.
struct Trip {
    reason: Reason,
    cause: &'static str,
    overrides: &'static [&'static str],
    /// Does it; the periods of causing begin when it returns true.
    act: fn(&mut Rig) -> bool,
    /// What becomes of frames from then on.
    tamper: Tamper,
}

/// Changes a frame that crosses the bus, or keeps it from crossing; what it
/// remembers is a position.
type Tamper = fn(&Profile, &mut Frame, &mut Option<f64>) -> Fate;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Fate {
    Crosses,
    Vanishes,
}

/// Stack and far side, with something between them that can tamper with what
/// crosses.
struct Rig {
    stack: Stack,
    far_side: FarSide,
    profile: Profile,
    now: Instant,
    /// How late the stack wakes up, periods.
    late_periods: i64,
    tamper: Tamper,
    /// What that remembers.
    stuck_at: Option<f64>,
    ticks: u64,
    /// The last that the stack told.
    tick: Tick,
    notices: Vec<&'static str>,
    /// Mean torque over the period that ended last, N m.
    torque_nm: Wheels<f64>,
    true_speed_rad_s: Wheels<f64>,
    true_angle_rad: Wheels<f64>,
}

const PERIOD_MS: u64 = 5;
/// Long enough for drives to boot and enable and for the robot to move.
const UNDER_WAY_PERIODS: u32 = 600;
/// In which friction has stopped the robot.
const ROLLING_PERIODS: u32 = 400;

const NOTHING: Tamper = |_, _, _| Fate::Crosses;
const AT_ONCE: fn(&mut Rig) -> bool = |_| true;

const TRIPS: [Trip; 16] = [
    Trip {
        reason: Reason::StaleFeedback,
        cause: "the right drive's feedback stays out",
        overrides: &[],
        act: AT_ONCE,
        tamper: |profile, frame, _| match profile.decode(frame) {
            Ok(Message::Feedback(Wheel::Right, _)) => Fate::Vanishes,
            _ => Fate::Crosses,
        },
    },
    Trip {
        reason: Reason::HeartbeatLost,
        cause: "the left drive's heartbeat stays out",
        overrides: &[],
        act: AT_ONCE,
        tamper: |profile, frame, _| match profile.decode(frame) {
            Ok(Message::Heartbeat(Wheel::Left, _)) => Fate::Vanishes,
            _ => Fate::Crosses,
        },
    },
    Trip {
        reason: Reason::DamagedFrames,
        cause: "three frames in a drive's name have a wrong CRC",
        overrides: &[],
        act: |rig| {
            let mut damaged = rig.profile.encode(&Message::Feedback(Wheel::Right, Feedback::default()));
            damaged.payload_mut()[0] ^= 0x10;
            (0..3).for_each(|_| rig.stack.handle_frame(rig.now, &damaged));
            true
        },
        tamper: NOTHING,
    },
    Trip {
        reason: Reason::CounterJump,
        cause: "old feedback is sent once more",
        overrides: &[],
        act: |rig| {
            let state = rig.profile.conversation.state("enabled");
            let counter = Some((rig.ticks as u8).wrapping_sub(3) & 0xF);
            let replayed = Feedback { state, counter, ..Feedback::default() };
            let frame = rig.profile.encode(&Message::Feedback(Wheel::Left, replayed));
            rig.stack.handle_frame(rig.now, &frame);
            true
        },
        tamper: NOTHING,
    },
    Trip {
        reason: Reason::EncoderJump,
        cause: "the left encoder jumps by 0.2 rad of the wheel",
        overrides: &[],
        act: AT_ONCE,
        tamper: |profile, frame, _| {
            const COUNTS: f64 = 0.2 * 3.0 * 65536.0 / (2.0 * std::f64::consts::PI);
            if let Ok(Message::Feedback(Wheel::Left, mut feedback)) = profile.decode(frame) {
                feedback.position = feedback.position.map(|position| position + COUNTS);
                *frame = profile.encode(&Message::Feedback(Wheel::Left, feedback));
            }
            Fate::Crosses
        },
    },
    Trip {
        reason: Reason::DriveFault,
        cause: "the left drive's power stage fails",
        overrides: &[],
        act: |rig| {
            rig.far_side.robot_mut().raise_fault(Wheel::Left, FaultCode::OverCurrent);
            true
        },
        tamper: NOTHING,
    },
    Trip {
        reason: Reason::DriveDisabled,
        cause: "somebody else tells the right drive to disable",
        overrides: &[],
        act: |rig| {
            let word = rig.profile.conversation.word("disable");
            // Behind the stack's own command of this period, with the next counter.
            let command = Command { word, counter: rig.ticks as u8 & 0xF, ..Command::default() };
            rig.far_side.take(rig.profile.encode(&Message::Command(Wheel::Right, command)));
            true
        },
        tamper: NOTHING,
    },
    Trip {
        reason: Reason::EnableTimeout,
        cause: "the left drive gets no command; limit 0.1 s",
        overrides: &["safety.enable_timeout_s=0.1"],
        act: |rig| {
            // Anew, and from the beginning this time.
            rig.stack.operate(Operator::EmergencyStop);
            rig.run(ROLLING_PERIODS);
            rig.stack.operate(Operator::Reset);
            rig.run(10);
            rig.stack.operate(Operator::Enable);
            true
        },
        tamper: |profile, frame, _| match profile.decode(frame) {
            Ok(Message::Command(Wheel::Left, _)) => Fate::Vanishes,
            _ => Fate::Crosses,
        },
    },
    Trip {
        reason: Reason::FollowingError,
        cause: "the right encoder sticks; limit 0.5 rad",
        overrides: &["safety.following_error_rad=0.5"],
        act: AT_ONCE,
        tamper: |profile, frame, stuck_at| {
            if let Ok(Message::Feedback(Wheel::Right, mut feedback)) = profile.decode(frame) {
                feedback.position = stuck_at.or(feedback.position);
                *stuck_at = feedback.position;
                *frame = profile.encode(&Message::Feedback(Wheel::Right, feedback));
            }
            Fate::Crosses
        },
    },
    Trip {
        reason: Reason::OverSpeed,
        cause: "the path gets faster than the limit of 0.3 rad/s",
        overrides: &["safety.wheel_speed_limit_rad_s=0.3"],
        act: |rig| rig.true_speed_rad_s.any(|speed| speed.abs() > 0.3),
        tamper: NOTHING,
    },
    Trip {
        reason: Reason::TorqueSaturated,
        cause: "a wheel gets stuck; limit 0.1 s above 90 N m",
        overrides: &["safety.saturation_timeout_s=0.1", "robot.friction.right.static_nm=200.0"],
        act: |rig| rig.tick.torque_wanted_nm.any(|torque| torque.abs() > 90.0),
        tamper: NOTHING,
    },
    Trip {
        reason: Reason::StopTimeout,
        cause: "a stop brakes too gently; limit 0.1 s",
        overrides: &["safety.stop_timeout_s=0.1", "safety.stop_deceleration_rad_s2=0.001"],
        act: |rig| {
            rig.stack.operate(Operator::Stop);
            true
        },
        tamper: NOTHING,
    },
    Trip {
        reason: Reason::LoopOverrun,
        cause: "the loop wakes up two periods late",
        overrides: &[],
        act: |rig| {
            rig.late_periods = 2;
            true
        },
        tamper: NOTHING,
    },
    Trip {
        reason: Reason::BusLost,
        cause: "the interface goes down and comes up",
        overrides: &[],
        act: |rig| {
            rig.stack.trip(Reason::BusLost);
            true
        },
        tamper: NOTHING,
    },
    Trip {
        reason: Reason::BusOff,
        cause: "the controller goes off the bus and comes back",
        overrides: &[],
        act: |rig| {
            rig.stack.trip(Reason::BusOff);
            true
        },
        tamper: NOTHING,
    },
    Trip {
        reason: Reason::OperatorStop,
        cause: "an emergency stop",
        overrides: &[],
        act: |rig| {
            rig.stack.operate(Operator::EmergencyStop);
            true
        },
        tamper: NOTHING,
    },
];

impl Rig {
    fn new(overrides: &[&str]) -> Self {
        let overrides: Vec<String> =
            ["path.duration_s=20.0"].iter().chain(overrides).map(|&text| text.to_owned()).collect();
        let scenario = Scenario::load("dac-friction", &overrides).unwrap_or_else(|problems| panic!("{problems}"));
        let Link::Can(rates) = scenario.link else { panic!("it has a bus") };
        let mut stack = Stack::new(&scenario.stack, Instant::ZERO);
        stack.operate(Operator::Enable);
        Self {
            stack,
            far_side: FarSide::new(&scenario, rates, Instant::ZERO),
            profile: scenario.stack.profile,
            now: Instant::ZERO,
            late_periods: 0,
            tamper: NOTHING,
            stuck_at: None,
            ticks: 0,
            tick: Tick::default(),
            notices: Vec::new(),
            torque_nm: Wheels::default(),
            true_speed_rad_s: Wheels::default(),
            true_angle_rad: Wheels::default(),
        }
    }

    fn run(&mut self, periods: u32) {
        (0..periods).for_each(|_| self.step());
    }

    fn step(&mut self) {
        let due = self.stack.next_wakeup();
        self.now =
            due + canloop::time::Duration::from_millis(PERIOD_MS as i64) * std::mem::take(&mut self.late_periods);
        self.stack.handle_wakeup(self.now);
        self.ticks += 1;
        self.exchange();
    }

    fn exchange(&mut self) {
        loop {
            while let Some(event) = self.stack.poll_event() {
                match event {
                    Event::Tick(tick) => self.tick = tick,
                    Event::Notice(notice) => self.notices.push(notice.text),
                    _ => {}
                }
            }
            if let Some(mut frame) = self.stack.poll_transmit() {
                if (self.tamper)(&self.profile, &mut frame, &mut self.stuck_at) == Fate::Crosses {
                    self.far_side.take(frame);
                }
                continue;
            }
            match self.far_side.poll() {
                Some((_, Happening::Frame(crossed))) if !crossed.sent_by_stack => {
                    let mut frame = crossed.frame;
                    if (self.tamper)(&self.profile, &mut frame, &mut self.stuck_at) == Fate::Crosses {
                        self.stack.handle_frame(self.now, &frame);
                    }
                }
                Some((_, Happening::Synced(synced))) => {
                    self.torque_nm = synced.torque_nm;
                    self.true_speed_rad_s = synced.state.speed_rad_s;
                    self.true_angle_rad = synced.state.angle_rad;
                }
                Some(_) => {}
                None => return,
            }
        }
    }

    /// Whether a wheel turns in the periods to come.
    fn moves_within(&mut self, periods: u32) -> bool {
        let before = self.true_angle_rad;
        self.run(periods);
        self.true_angle_rad != before
    }

    /// The robot rolls to rest, and nothing moves it any more.
    #[track_caller]
    fn assert_at_rest_for_good(&mut self) {
        self.run(ROLLING_PERIODS);
        for _ in 0..200 {
            assert!(!self.moves_within(1), "it moves, and the stack is {:?}", self.stack.state());
            assert_eq!(self.torque_nm, Wheels::default());
        }
    }
}

/// Periods from the cause until both wheels' torque is zero and the stack has
/// tripped.
fn periods_to_zero(rig: &mut Rig, trip: &Trip) -> u64 {
    let reason = State::Tripped(trip.reason);
    let mut periods = 0;
    // Torque over a period is known when it has ended.
    while rig.stack.state() != reason || rig.torque_nm != Wheels::default() {
        rig.step();
        periods += 1;
        assert!(periods < 2000, "{:?} never: {:?}, {:?}", trip.reason, rig.stack.state(), rig.notices);
    }
    periods - 1
}

/// Makes it trip, and shows that it stays so. Gives the periods that it took.
fn trip_for_good(trip: &Trip) -> u64 {
    let mut rig = Rig::new(trip.overrides);
    if trip.reason != Reason::TorqueSaturated && trip.reason != Reason::OverSpeed {
        rig.run(UNDER_WAY_PERIODS);
        assert!(rig.moves_within(1) && rig.torque_nm != Wheels::default(), "{:?}: it is under way", trip.reason);
        assert_eq!(rig.stack.state(), State::Running);
    }
    while !(trip.act)(&mut rig) {
        rig.step();
        assert!(rig.ticks < 5000, "{:?} has no cause", trip.reason);
    }
    rig.tamper = trip.tamper;
    rig.notices.clear();
    let periods = periods_to_zero(&mut rig, trip);
    rig.stack.operate(Operator::Enable);
    rig.assert_at_rest_for_good();
    assert_eq!(rig.stack.state(), State::Tripped(trip.reason), "enable alone does not leave a trip");
    rig.tamper = NOTHING;
    rig.stack.operate(Operator::Reset);
    rig.assert_at_rest_for_good();
    assert_eq!(rig.stack.state(), State::Stopped);
    rig.stack.operate(Operator::Enable);
    rig.run(10);
    assert!(rig.stack.state().is_armed(), "a new enable is obeyed: {:?}", rig.stack.state());
    periods
}

fn row(trip: &Trip) -> String {
    let periods = trip_for_good(trip);
    let limit = trip.reason.limit_key().map_or(String::new(), |key| format!("`{key}`"));
    let what = trip.reason.text().trim_start_matches("tripped: ");
    format!("| {what} | {limit} | {} | {periods} | {} ms |", trip.cause, periods * PERIOD_MS)
}

#[test]
fn each_trip_takes_the_torque_away_as_soon_as_the_readme_says_and_motion_does_not_resume() {
    let readme = include_str!("../../README.md");
    let rows: Vec<String> = TRIPS.iter().map(row).collect();
    let missing: Vec<&String> = rows.iter().filter(|row| !readme.contains(row.as_str())).collect();
    assert!(missing.is_empty(), "README.md should say:\n{}", rows.join("\n"));
}

#[test]
fn every_reason_but_one_that_no_bus_can_cause_is_caused_here() {
    let caused = TRIPS.map(|trip| trip.reason);
    let missing: Vec<Reason> = Reason::ALL.into_iter().filter(|reason| !caused.contains(reason)).collect();
    // Frames cannot carry anything that the law makes no number of: what is
    // not finite is refused as damaged. The chain's own tests have this one.
    assert_eq!(missing, [Reason::NotFinite]);
}
