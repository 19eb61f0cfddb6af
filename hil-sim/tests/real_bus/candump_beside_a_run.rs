//! What a run's log holds is what `candump -L`, which we did not write, saw on
//! the same bus at the same time: frame for frame.

#![allow(clippy::disallowed_methods, reason = "another program is waited for")]

use std::process::Command;

use crate::rig::python;
use crate::two_programs::Bench;

#[test]
#[ignore = "needs vcan0"]
fn the_log_of_a_run_and_that_of_candump_hold_the_same_frames_over_vcan() {
    let bench = Bench::over_vcan();
    let serve = bench.serve(&["--no-log", "--set", "duration_s=5"]);
    // 8 MB of receive buffer, for a machine with one processor on which three programs run.
    let mut candump = bench.start("candump", Command::new("candump").args(["-L", "-r", "8388608", "vcan0"]));
    candump.wait_until("it has its socket", |_| sockets_on_vcan() >= 2);
    bench.drive(&["--log", "drive.mcap"]).finish().expect_status(0);
    serve.finish().expect_status(0);
    let mut seen = 0;
    candump.wait_until("it has written all", |candump| {
        let before = std::mem::replace(&mut seen, candump.told().len());
        std::thread::sleep(std::time::Duration::from_millis(200));
        before == seen
    });
    candump.signal("TERM");
    drop(candump);
    python("real_bus/same_as_candump.py", &[&bench.rig.path("drive.mcap"), &bench.rig.path("candump.out")]);
}

/// Sockets that listen to frames of vcan0: `hil-sim serve` has one.
fn sockets_on_vcan() -> usize {
    let listed = std::fs::read_to_string("/proc/net/can/rcvlist_all").expect("a kernel with CAN");
    listed.lines().filter(|line| line.trim_start().starts_with("vcan0")).count()
}
