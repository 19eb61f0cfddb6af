//! The paper's own simulation: law and plant joined directly. The law sees
//! exact position, speed and acceleration just before the torque changes, and
//! its torque acts at once.

use std::ops::ControlFlow;

use canloop::control::{Measured, Sampling};
use canloop::event::{Event, Sink, SyncEvent, Tick};
use canloop::safety::State;
use canloop::time::Instant;
use canloop::wheels::Wheels;

use crate::bench::{DIVERGED_NM, End, Outcome, is_lost, truth};
use crate::plant::Torque;
use crate::scenario::Scenario;
use crate::wire::WireStats;

/// Runs a scenario on an ideal link.
pub(crate) fn run(
    scenario: &Scenario,
    sink: &mut impl Sink,
    mut progress: impl FnMut(u64) -> ControlFlow<()>,
) -> Outcome {
    let mut plant = scenario.plant();
    let mut controller = scenario.stack.controller.build(Sampling::Exact);
    let period_s = scenario.period_s();
    let mut torque_nm = Wheels::default();
    let mut now = Instant::ZERO;
    let mut tick = 0;
    let end = loop {
        let reference = *controller.reference();
        sink.event(now, &Event::Sync(SyncEvent { tick, reference: reference.pose }));
        let truth = truth(tick, plant.state(), &reference.pose, torque_nm);
        sink.event(now, &Event::Truth(truth));
        if is_lost(&truth) {
            break End::Diverged;
        }
        if tick >= scenario.ticks() {
            break End::Finished;
        }
        if progress(tick).is_break() {
            break End::Interrupted;
        }
        let state = plant.state();
        let measured = Measured {
            angle_rad: state.angle_rad,
            speed_rad_s: state.speed_rad_s,
            acceleration_rad_s2: plant.acceleration(torque_nm),
            torque_nm,
        };
        let decision = controller.decide(&state.pose, &measured);
        let tick_event = Tick {
            tick,
            state: State::Running.code(),
            reference: reference.pose,
            reference_twist: reference.twist,
            odometry: state.pose,
            target_angle_rad: decision.target.angle_rad,
            target_speed_rad_s: decision.target.speed_rad_s,
            angle_rad: measured.angle_rad,
            speed_rad_s: measured.speed_rad_s,
            acceleration_rad_s2: measured.acceleration_rad_s2,
            torque_applied_nm: torque_nm,
            torque_wanted_nm: decision.torque_nm,
            torque_sent_nm: decision.torque_nm,
        };
        sink.event(now, &Event::Tick(tick_event));
        torque_nm = decision.torque_nm;
        if !torque_nm.all(|torque| torque.abs() <= DIVERGED_NM) {
            break End::Diverged;
        }
        plant.advance(period_s, torque_nm.map(Torque::constant));
        controller.advance();
        tick += 1;
        now += scenario.stack.period;
    };
    Outcome { end, ticks: tick, wire: WireStats::default(), state: None }
}
