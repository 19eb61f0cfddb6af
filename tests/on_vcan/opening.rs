//! What cannot be opened is refused with the reason and the way out.

use canloop::bus::{Bus as _, BusError, OpenOptions, SocketCan};
use canloop::frame::{CanId, Frame};
use canloop::run::Clock;

use crate::rig::{Vcan, ip, open, open_with};

fn refusal(interface: &str, options: &OpenOptions) -> String {
    SocketCan::open(interface, options, Clock::new()).err().expect("it should not open").to_string()
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn an_unknown_interface_is_refused_with_those_there_are() {
    let _vcan = Vcan::new("known0");
    let message = refusal("can7", &OpenOptions::default());
    assert!(message.contains("there is no interface can7") && message.contains("known0"), "{message}");
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn an_interface_that_is_down_is_refused_with_the_command_that_brings_it_up() {
    let vcan = Vcan::new("down0");
    ip("link set down0 down");
    let message = refusal(vcan.0, &OpenOptions::default());
    assert!(message.contains("down0 is down") && message.contains("ip link set down0 up"), "{message}");
    ip("link set down0 up");
    open(vcan.0);
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn an_interface_of_another_kind_is_refused() {
    let message = refusal("lo", &OpenOptions::default());
    assert!(message.contains("lo is no CAN interface"), "{message}");
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn a_classic_interface_is_refused_where_can_fd_is_needed() {
    let vcan = Vcan::new("classic0");
    ip("link set classic0 down");
    ip("link set classic0 mtu 16");
    ip("link set classic0 up");
    let message = refusal(vcan.0, &OpenOptions { needs_fd: true, ..Default::default() });
    assert!(message.contains("classic frames only") && message.contains("mtu 72"), "{message}");
    let refused = vcan.open().send(&Frame::zeroed(CanId::Standard(1), 12));
    assert!(matches!(refused, Err(BusError::Gone(..))), "{refused:?}");
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn a_virtual_interface_has_no_bit_rate_to_be_wrong() {
    let vcan = Vcan::new("anyrate0");
    open_with(vcan.0, &OpenOptions { bit_rate_bit_s: Some(125_000), ..Default::default() });
}
