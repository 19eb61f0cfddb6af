//! What is read of an interface is what `ip` shows.

use std::process::Command;

use canloop::bus::CanLink;

use crate::rig::Vcan;

#[test]
#[ignore = "needs a kernel with CAN"]
fn a_link_is_read_as_ip_shows_it() {
    let vcan = Vcan::new("shown0");
    let link = CanLink::read(vcan.0).unwrap();
    assert!(link.is_up && link.carries_fd && !link.is_controller);
    assert_eq!((link.bit_rate_bit_s, link.state), (None, None));
    let shown = Command::new("ip").args(["link", "show", "shown0"]).output().unwrap();
    let shown = String::from_utf8(shown.stdout).unwrap();
    assert!(shown.starts_with(&format!("{}: shown0", link.index)), "{shown}");
    assert!(shown.contains(&format!("qlen {}", link.queue_frames)), "{shown}");
    assert!(CanLink::all().unwrap().contains(&("shown0".to_owned(), link)));
}
