//! What a driver's error message says (`linux/can/error.h`).

use socketcan::errors::ControllerProblems;

use crate::bus::ControllerState;

const CONTROLLER_PROBLEM: u32 = 0x004;
const BUS_OFF: u32 = 0x040;
const RESTARTED: u32 = 0x100;

/// The state that the controller has come to, if the message tells of one.
pub(super) fn controller_state(class: u32, data: &[u8; 8]) -> Option<ControllerState> {
    if class & BUS_OFF != 0 {
        return Some(ControllerState::BusOff);
    }
    let problems = controller_problems(class, data);
    if problems.intersects(ControllerProblems::RX_PASSIVE | ControllerProblems::TX_PASSIVE) {
        Some(ControllerState::ErrorPassive)
    } else if problems.intersects(ControllerProblems::RX_WARNING | ControllerProblems::TX_WARNING) {
        Some(ControllerState::ErrorWarning)
    } else if problems.contains(ControllerProblems::ACTIVE) || class & RESTARTED != 0 {
        Some(ControllerState::ErrorActive)
    } else {
        None
    }
}

/// Whether the controller had no room for a frame that it received.
pub(super) fn lost_frame(class: u32, data: &[u8; 8]) -> bool {
    controller_problems(class, data).contains(ControllerProblems::RX_OVERFLOW)
}

fn controller_problems(class: u32, data: &[u8; 8]) -> ControllerProblems {
    match class & CONTROLLER_PROBLEM {
        0 => ControllerProblems::empty(),
        _ => ControllerProblems::from_bits_truncate(data[1]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_message_gives_the_worst_state_that_it_names() {
        let state = |class, problems| controller_state(class, &[0, problems, 0, 0, 0, 0, 0, 0]);
        assert_eq!(state(BUS_OFF | CONTROLLER_PROBLEM, 0x20), Some(ControllerState::BusOff));
        assert_eq!(state(CONTROLLER_PROBLEM, 0x30), Some(ControllerState::ErrorPassive));
        assert_eq!(state(CONTROLLER_PROBLEM, 0x0C), Some(ControllerState::ErrorWarning));
        assert_eq!(state(CONTROLLER_PROBLEM, 0x40), Some(ControllerState::ErrorActive));
        assert_eq!(state(RESTARTED, 0), Some(ControllerState::ErrorActive));
        assert_eq!(state(0x008, 0x30), None, "a protocol violation has other data there");
    }
}
