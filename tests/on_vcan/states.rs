//! What a driver tells of its controller becomes states and losses.

use canloop::bus::{Arrival, Bus as _, BusError, ControllerState};
use socketcan::{CanErrorFrame, CanSocket, Socket as _};

use crate::rig::{Vcan, drain, next, numbered};

const CONTROLLER: u32 = 0x04;
const BUS_OFF: u32 = 0x40;
const BUS_ERROR: u32 = 0x80;
const RESTARTED: u32 = 0x100;

/// A driver's message, as another program can put it onto a virtual bus.
fn tell(vcan: &Vcan, class: u32, problems: u8) {
    let message = CanErrorFrame::new_error(class, &[0, problems]).unwrap();
    CanSocket::open(vcan.0).unwrap().write_frame(&message).unwrap();
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn the_controller_state_is_told_when_it_changes() {
    let vcan = Vcan::new("states0");
    let mut bus = vcan.open();
    for (problems, state) in [
        (0x08, ControllerState::ErrorWarning),
        (0x30, ControllerState::ErrorPassive),
        (0x40, ControllerState::ErrorActive),
        (0x10, ControllerState::ErrorPassive),
    ] {
        tell(&vcan, CONTROLLER, problems);
        tell(&vcan, CONTROLLER, problems);
        assert_eq!(next(&mut bus).1, Arrival::State(state));
        assert_eq!(drain(&mut bus), []);
    }
    tell(&vcan, BUS_ERROR, 0);
    assert_eq!(drain(&mut bus), []);
    assert_eq!(bus.counts().errors, 9);
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn nothing_is_sent_while_bus_off_and_a_restart_ends_it() {
    let vcan = Vcan::new("busoff0");
    let mut bus = vcan.open();
    tell(&vcan, BUS_OFF, 0);
    assert_eq!(next(&mut bus).1, Arrival::State(ControllerState::BusOff));
    assert_eq!(next(&mut bus).1, Arrival::Down);
    assert!(matches!(bus.send(&numbered(1, 1)), Err(BusError::Down)));
    tell(&vcan, RESTARTED, 0);
    assert_eq!(next(&mut bus).1, Arrival::State(ControllerState::ErrorActive));
    assert_eq!(next(&mut bus).1, Arrival::Up);
    bus.send(&numbered(1, 1)).unwrap();
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn a_frame_that_the_controller_had_no_room_for_is_lost() {
    let vcan = Vcan::new("overrun0");
    let mut bus = vcan.open();
    tell(&vcan, CONTROLLER, 0x01);
    assert_eq!(drain(&mut bus), [Arrival::Lost(1)]);
    assert_eq!(bus.counts().lost, 1);
}
