//! The bus on a kernel's CAN interfaces.
//!
//! The tests need root and a kernel with CAN of their own: they make, take
//! down and remove interfaces. They are marked as ignored, and the one test
//! that is not runs them all in such a kernel.

#![cfg(target_os = "linux")]

mod card;
mod frames;
mod link;
mod losses;
mod opening;
mod outages;
mod rig;
mod states;

use std::path::Path;
use std::process::{Command, Stdio};

use canloop::bus::{OpenOptions, SocketCan};
use canloop::run::Clock;
use socketcan::{CanSocket, Socket as _};

#[test]
fn the_bus_holds_on_a_kernel_with_can() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/with-vcan");
    let ran = Command::new(&script)
        .args(["--vm", "--"])
        .arg(std::env::current_exe().unwrap())
        .args(["--ignored", "--test-threads", "1", "--color", "never"])
        .env("CANLOOP_VM_TIMEOUT_S", "120")
        .env(rig::PYTHON, python())
        .stdin(Stdio::null())
        .output()
        .unwrap_or_else(|error| panic!("{}: {error}", script.display()));
    let told = String::from_utf8_lossy(&ran.stdout);
    let errors = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{}\n{told}\n{errors}", ran.status);
    assert!(told.contains("test result: ok") && !told.contains(" 0 passed"), "{told}");
}

/// The interpreter itself, found outside: a version manager's wrapper, which
/// `python3` may be, takes seconds inside.
fn python() -> String {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/python");
    let asked = Command::new(script).args(["-c", "import sys; print(sys.executable)"]).output().unwrap();
    assert!(asked.status.success(), "scripts/python: {}", String::from_utf8_lossy(&asked.stderr));
    String::from_utf8(asked.stdout).unwrap().trim().to_owned()
}

#[test]
fn a_kernel_without_can_says_so() {
    let has_can = CanSocket::open_iface(0).is_ok();
    let refused = SocketCan::open("nocan7", &OpenOptions::default(), Clock::new()).err().unwrap().to_string();
    let expected = if has_can { "there is no interface nocan7" } else { "this kernel has no CAN sockets" };
    assert!(refused.contains(expected), "{refused}");
}
