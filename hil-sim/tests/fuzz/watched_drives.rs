//! Simulated drives that are watched: whatever they are given, some things
//! always hold.

use std::collections::BTreeSet;

use canloop::event::BusFrame;
use canloop::frame::Frame;
use canloop::schema::DriveState;
use canloop::time::Instant;
use canloop::wheels::{Wheel, Wheels};
use hil_sim::far_side::{FarSide, Happening};
use hil_sim::plant::State;
use hil_sim::scenario::Scenario;
use hil_sim::virtual_robot::VirtualRobot;

use crate::drives_that_ship::bit_rates;

/// More frames than drives send for one thing that happens, by far.
const MOST_FRAMES: usize = 32;
/// More than happens in a step: a wire's full queues, and their answers.
const MOST_HAPPENINGS: usize = 1000;

/// A robot on a bus without a wire.
pub struct WatchedRobot {
    /// What its drives went through: the steps from state to state.
    pub seen: BTreeSet<(String, String)>,
    robot: VirtualRobot,
    torque_limit_nm: f64,
}

/// A whole far side, with its wire.
pub struct WatchedFarSide {
    far_side: FarSide,
    torque_limit_nm: f64,
    /// When something happened last.
    last: Instant,
    /// Periods begun.
    ticks: u64,
}

impl WatchedRobot {
    /// The scenario's robot, its periods begun by the clock or by frames.
    pub fn new(scenario: &Scenario, is_by_clock: bool) -> Self {
        let robot = scenario.virtual_robot(Instant::ZERO);
        Self {
            seen: BTreeSet::new(),
            robot: if is_by_clock { robot.by_clock() } else { robot },
            torque_limit_nm: scenario.drive_spec().torque_limit_nm,
        }
    }

    /// Lets something happen and looks at what comes of it.
    pub fn watch(&mut self, happen: impl FnOnce(&mut VirtualRobot)) {
        let (ticks, next_wakeup, states) = (self.robot.ticks(), self.robot.next_wakeup(), self.states());
        happen(&mut self.robot);
        assert!(self.robot.ticks() >= ticks);
        assert!(self.robot.next_wakeup() >= next_wakeup, "the next wake-up went backwards");
        let frames = std::iter::from_fn(|| self.robot.poll_transmit()).count();
        assert!(frames <= MOST_FRAMES, "{frames} frames at once");
        check_plant(self.robot.state(), self.robot.torque_applied_nm(), self.torque_limit_nm);
        for wheel in Wheel::BOTH {
            self.check_drive(wheel);
        }
        let states_after = self.states();
        for (before, after) in states.into_iter().zip(states_after) {
            if before != after {
                self.seen.insert((before, after));
            }
        }
    }

    fn states(&self) -> [String; 2] {
        Wheel::BOTH.map(|wheel| self.robot.drive(wheel).state_name().to_owned())
    }

    fn check_drive(&self, wheel: Wheel) {
        let drive = self.robot.drive(wheel);
        let is_on = drive.state() == DriveState::Enabled;
        let limit_nm = if is_on { self.torque_limit_nm } else { 0.0 };
        for torque_nm in [drive.torque().now_nm(), drive.torque().final_nm] {
            assert!(torque_nm.abs() <= limit_nm, "a drive in {:?} applies {torque_nm} N m", drive.state_name());
        }
    }
}

impl WatchedFarSide {
    /// The far side of a scenario.
    pub fn new(scenario: &Scenario) -> Self {
        Self {
            far_side: FarSide::new(scenario, bit_rates(scenario), Instant::ZERO),
            torque_limit_nm: scenario.drive_spec().torque_limit_nm,
            last: Instant::ZERO,
            ticks: 0,
        }
    }

    /// Takes a frame; gives those that the drives have sent.
    pub fn take(&mut self, frame: Frame) -> Vec<Frame> {
        self.far_side.take(frame);
        let mut happenings = 0;
        let mut answers = Vec::new();
        while let Some((at, happening)) = self.far_side.poll() {
            assert!(at >= self.last, "{happening:?} happened before what happened before it");
            self.last = at;
            happenings += 1;
            match happening {
                Happening::Frame(BusFrame { sent_by_stack: false, frame, .. }) => answers.push(frame),
                Happening::Synced(synced) => {
                    assert_eq!(synced.tick, self.ticks, "a period was left out");
                    self.ticks += 1;
                    check_plant(&synced.state, synced.torque_nm, self.torque_limit_nm);
                }
                _ => {}
            }
        }
        assert!(happenings <= MOST_HAPPENINGS, "{happenings} things happened at once");
        answers
    }
}

fn check_plant(state: &State, torque_nm: Wheels<f64>, limit_nm: f64) {
    let State { angle_rad, speed_rad_s, pose } = state;
    let numbers =
        [angle_rad.right, angle_rad.left, speed_rad_s.right, speed_rad_s.left, pose.x_m, pose.y_m, pose.heading_rad];
    assert!(numbers.iter().all(|number| number.is_finite()), "{state:?}");
    // A mean is rounded.
    assert!(torque_nm.all(|torque| torque.abs() <= limit_nm + 1e-9), "applied {torque_nm:?} N m");
}
