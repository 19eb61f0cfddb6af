//! Any controller can drive the simulated drives: one on python-can and
//! cantools, that has nothing of ours but the DBC.

use std::process::Command;

use crate::two_programs::{Bench, python};

#[track_caller]
fn assert_it_drives(bench: &Bench) {
    let here = env!("CARGO_MANIFEST_DIR");
    let serve = bench.serve(&["--set", "duration_s=2", "--set", "expect=[]", "--no-log"]);
    let mut command = Command::new(python());
    command.arg(format!("{here}/tests/real_bus/python_controller.py"));
    command.arg(format!("{here}/../dbc")).arg(bench.address());
    let controller = bench.start("controller", &mut command).finish().expect_status(0);
    assert_eq!(controller.stdout.trim(), "the drives did as they were told");
    serve.finish().expect_status(0);
}

#[test]
fn over_tcp() {
    assert_it_drives(&Bench::over_tcp());
}

#[test]
#[ignore = "needs vcan0"]
fn over_vcan() {
    assert_it_drives(&Bench::over_vcan());
}

#[test]
#[ignore = "needs can0 and can1 on one bus"]
fn over_a_card() {
    assert_it_drives(&Bench::over_two_cards());
}
