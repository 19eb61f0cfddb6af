//! Tests that need a kernel with CAN, run where there is one.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::two_programs;

/// Runs the ignored tests of this name through a script that gives them a
/// kernel with CAN.
pub fn run_where_there_is(script: &str, tests: &str) {
    two_programs::canloop();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts").join(script);
    // A machine within the machine is slow as it is. Who may not ask for this is told so, and goes on.
    let ran = Command::new("nice")
        .args(["-n", "-15"])
        .arg(&script)
        .arg("--")
        .arg(std::env::current_exe().expect("this test has a path"))
        .args(["--ignored", tests, "--test-threads", "1", "--color", "never"])
        .env("CANLOOP_VM_TIMEOUT_S", "1800")
        .env(two_programs::PYTHON, two_programs::python())
        .stdin(Stdio::null())
        .output()
        .unwrap_or_else(|error| panic!("{}: {error}", script.display()));
    let told = String::from_utf8_lossy(&ran.stdout);
    let errors = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{}\n{told}\n{errors}", ran.status);
    assert!(told.contains("test result: ok") && !told.contains(" 0 passed"), "{told}");
}
