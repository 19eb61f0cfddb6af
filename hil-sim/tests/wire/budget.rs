//! The bounds of `canloop budget` hold on the wire, with the frames that are
//! really sent.

use canloop::budget::{Budget, Terms};
use canloop::safety::State;
use canloop::schema::Cause;
use canloop::time::Duration;
use hil_sim::scenario::{Link, SHIPPED, Scenario};

use crate::rig::Loop;

/// Periods of a run in which the robot moves.
const PERIODS: u64 = 800;

/// Name of a scenario and overrides, where its budget holds.
fn configurations() -> impl Iterator<Item = (&'static str, Vec<&'static str>)> {
    let variants: [&[&str]; 4] = [
        &[],
        &["period_s=0.002", "bus.bitrate_bit_s=1000000"],
        &["period_s=0.01", "bus.bitrate_bit_s=250000"],
        &["period_s=0.02", "bus.bitrate_bit_s=125000"],
    ];
    let drives = ["dac-friction", "cia402", "odrive-0.5", "odrive-0.6", "vesc", "damiao-dm4310", "comma-body"];
    assert!(drives.iter().all(|name| SHIPPED.iter().any(|(shipped, _)| shipped == name)));
    drives.into_iter().flat_map(move |name| variants.map(|overrides| (name, overrides.to_vec())))
}

#[test]
fn what_shipped_robots_send_is_never_later_than_their_budget_says() {
    let mut held = 0;
    for (name, overrides) in configurations() {
        let texts: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
        let Ok(scenario) = Scenario::load(name, &texts) else { continue };
        let Link::Can(rates) = scenario.link else { panic!("it has a bus") };
        let period = scenario.stack.period;
        if scenario.stack.profile.feedback_period.is_some_and(|cycle| cycle > period) {
            continue;
        }
        let (lateness, answer) = (Duration::ZERO, Duration::ZERO);
        let terms = Terms { period, bit_rate_bit_s: rates.nominal_bit_s, lateness, answer };
        let budget = Budget::of(&scenario.stack.profile, &terms);
        let Some(exchange) = budget.exchange.filter(|_| budget.exchange_holds()) else { continue };
        held += 1;
        let mut rig = Loop::new(name, &overrides);
        while rig.stack.state() != State::Running {
            rig.step();
            assert!(rig.steps < 5 * PERIODS, "{name} {overrides:?}: {:?}", rig.stack.state());
        }
        // What is said once to enable a drive is not of the traffic.
        rig.run(2).frames.clear();
        rig.run(PERIODS);
        for &(at, crossed) in &rig.frames {
            let frame = crossed.frame;
            let Some(row) = budget.rows.iter().find(|row| (row.id, row.kind) == (frame.id, frame.kind)) else {
                continue;
            };
            // A period begins at each multiple.
            let since_begun = Duration::from_nanos(at.as_nanos() % period.as_nanos());
            let what = format!("{name} {overrides:?}: {} at {at:?}", row.name);
            assert!(!row.is_of_exchange() || since_begun <= exchange, "{what}: {since_begun:?} of {exchange:?}");
            if row.cause == Cause::Beginning {
                let bound = row.response.expect("it holds");
                assert!(since_begun <= bound, "{what}: {since_begun:?} of {bound:?}");
            }
        }
    }
    assert!(held >= 14, "most of them hold: {held}");
}
