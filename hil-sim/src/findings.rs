//! What a run's figures mean, in words, where something went wrong.

use crate::bench::{DIVERGED_M, DIVERGED_NM, End, Outcome};
use crate::scenario::{Link, Scenario};
use crate::summary::{Nodes, Summary};

use canloop::control::LawConfig;
use canloop::safety::State;

/// Mean step of torque, as a share of the torque limit, from which on a loop
/// is said to ring: a healthy one stays a hundred times below.
const RINGING_SHARE: f64 = 0.05;

/// Everything worth saying about a run that did not go well.
pub fn findings(scenario: &Scenario, summary: &Summary, outcome: &Outcome) -> Vec<String> {
    let mut found = Vec::new();
    if let Some(state @ State::Tripped(_)) = outcome.state {
        found.push(format!("The stack {}; torque stayed at zero from then on.", state.text()));
    }
    if outcome.end == End::Diverged {
        let what = if summary.tracking.final_m > DIVERGED_M {
            format!("it was more than {DIVERGED_M} m from its path")
        } else {
            format!("its controller asked for more than {DIVERGED_NM} N m")
        };
        found.push(format!("The robot diverged: at {:.3} s {what}, and the run was ended.", summary.simulated_s));
    }
    if outcome.end == End::Blocked {
        found.push("The bus was blocked: not one SYNC came through any more, and the run was ended.".to_owned());
    }
    let has_bus_faults = scenario.events.iter().any(|event| event.what.bus_fault().is_some());
    if outcome.wire.lost > 0 && has_bus_faults {
        found.push(format!("{} frames found their transmit queue full and were lost.", outcome.wire.lost));
    } else if outcome.wire.lost > 0 {
        found.push(format!(
            "{} frames found their transmit queue full and were lost: the bus cannot carry what a period of {} s \
             sends. Give it a higher `bus.bitrate_bit_s` or the loop a longer `period_s`.",
            outcome.wire.lost, summary.period_s
        ));
    }
    let Nodes { stack, right, left } = summary.bus.nodes;
    for (node, times) in [("stack", stack.bus_off), ("right drive", right.bus_off), ("left drive", left.bus_off)] {
        if times > 0 {
            let times = if times == 1 { "once".to_owned() } else { format!("{times} times") };
            found.push(format!("The {node}'s CAN controller went off the bus {times}."));
        }
    }
    if summary.rings {
        found.push(format!(
            "The torque rings: it changes by {:.1} N m from one period to the next, on average.",
            summary.torque.chatter_nm
        ));
    }
    if !found.is_empty() {
        found.extend(reason(scenario));
    }
    found
}

/// Whether torque that changes by this much a period never settled.
pub fn rings(chatter_nm: f64, scenario: &Scenario) -> bool {
    chatter_nm > RINGING_SHARE * scenario.stack.drive.torque_limit_nm
}

/// Why a law is known to fail where it does.
fn reason(scenario: &Scenario) -> Option<String> {
    let text = match (scenario.stack.controller.law, scenario.link) {
        (LawConfig::Dac { .. }, Link::Can { .. }) => {
            "Why: over a bus a command acts a period late, so eq 12, which adds to its own last command, corrects the \
             same error twice: its characteristic polynomial becomes z^2 - z + 1, whose roots lie on the unit circle, \
             and the loop rings without end. The law `dac-matched` adds to the torque that was really applied while \
             the measured acceleration happened, and does not."
        }
        (LawConfig::DacMatched { filter, .. }, Link::Can { .. }) if filter > 0.9 => {
            "Why: encoder steps, differentiated twice, reach the torque unfiltered. A `controller.filter` of 0.3 \
             passes torque and acceleration through the same low-pass, and cures that."
        }
        (LawConfig::PiAngle { .. }, _) => {
            "Why: eq 20 as printed acts on the wheel's angle. On a wheel that is free to turn its characteristic \
             polynomial, m s^3 + kp s + ki, has no damping term and is unstable whatever the gains. Acting on the \
             wheel's speed (`pi-speed`) it gives the paper's figures."
        }
        _ => return None,
    };
    Some(text.to_owned())
}
