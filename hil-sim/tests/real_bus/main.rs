//! The stack and its far side as two programs, `canloop drive` and `hil-sim
//! serve`, on a bus between them.
//!
//! Tests on the kernel's interfaces are marked as ignored: they run where
//! those exist, which the tests below see to.

#![cfg(target_os = "linux")]

mod bad_bus;
mod candump_beside_a_run;
mod dead_other_side;
mod garbage_on_the_bus;
mod lockstep_over_every_bus;
mod python_controller;
mod two_programs;

#[path = "../rig/mod.rs"]
mod rig;

use std::path::Path;
use std::process::{Command, Stdio};

#[test]
fn all_of_it_holds_on_the_kernels_virtual_bus() {
    run_where_there_is("with-vcan", "over_vcan");
}

#[test]
fn all_of_it_holds_on_two_emulated_cards() {
    run_where_there_is("with-can-card", "over_a_card");
}

/// Runs the ignored tests of this name through a script that gives them a
/// kernel with CAN.
fn run_where_there_is(script: &str, tests: &str) {
    two_programs::canloop();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts").join(script);
    let ran = Command::new(&script)
        .arg("--")
        .arg(std::env::current_exe().expect("this test has a path"))
        .args(["--ignored", tests, "--test-threads", "1", "--color", "never"])
        .env("CANLOOP_VM_TIMEOUT_S", "300")
        .env(two_programs::PYTHON, two_programs::python())
        .stdin(Stdio::null())
        .output()
        .unwrap_or_else(|error| panic!("{}: {error}", script.display()));
    let told = String::from_utf8_lossy(&ran.stdout);
    let errors = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{}\n{told}\n{errors}", ran.status);
    assert!(told.contains("test result: ok") && !told.contains(" 0 passed"), "{told}");
}
