//! The bus on a kernel's CAN interfaces.
//!
//! The tests need root and a kernel with CAN of their own: they make, take
//! down and remove interfaces. They are marked as ignored, and the first two
//! tests here run them all, in such a kernel and in one that has CAN cards.

#![cfg(target_os = "linux")]

mod card;
mod frame_lengths;
mod frames;
mod link;
mod listening;
mod losses;
mod opening;
mod outages;
mod rig;
mod states;
mod two_cards;

use std::path::Path;
use std::process::{Command, Stdio};

use canloop::bus::{OpenOptions, SocketCan};
use canloop::run::Clock;
use socketcan::{CanSocket, Socket as _};

#[test]
fn the_bus_holds_on_a_kernel_with_can() {
    run_where_there_is(&["with-vcan", "--vm"], &["--skip", "two_cards"]);
}

#[test]
fn the_bus_holds_on_two_emulated_cards() {
    run_where_there_is(&["with-can-card"], &["two_cards"]);
}

/// Runs the ignored tests so chosen through a script that gives them a kernel
/// with CAN.
fn run_where_there_is(script: &[&str], tests: &[&str]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts").join(script[0]);
    let ran = Command::new(&path)
        .args(&script[1..])
        .arg("--")
        .arg(std::env::current_exe().unwrap())
        .args(["--ignored", "--test-threads", "1", "--color", "never"])
        .args(tests)
        .env("CANLOOP_VM_TIMEOUT_S", "900")
        .env(rig::PYTHON, python())
        .stdin(Stdio::null())
        .output()
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
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
