//! Over the kernel's CAN, too, the robot keeps to its path with friction on
//! every kind of drive that ships.

use crate::rig::drives::{DRIVES, Promise};
use crate::rig::number;
use crate::two_programs::Bench;

/// What is promised holds from 30 s on; a machine in a machine is slow.
const FOR_35_S: [&str; 2] = ["--set", "duration_s=35"];

#[track_caller]
fn assert_kept(bench: &Bench, max_after_30s_m: f64) {
    let serve = bench.serve(&[["--no-log", "--out", "bus"].as_slice(), &FOR_35_S].concat());
    let drive = bench.drive(&FOR_35_S).finish().expect_status(0);
    assert!(drive.stdout.contains("the other side ended the run"), "{}", drive.stdout);
    // The scenario expects something of its own from 30 s on.
    let serve = serve.finish().expect_status(0);
    assert!(serve.stdout.contains("from 30 s to 35 s: held"), "{}", serve.stdout);
    let (scenario, summary) = (bench.scenario(), bench.rig.summary("bus"));
    println!("{scenario}: {} mm", 1e3 * number(&summary, "/tracking/max_after_30s_m"));
    assert_eq!(number(&summary, "/simulated_s"), 35.0, "{scenario}");
    assert_eq!(summary["bus"]["lost"], 0, "{scenario}");
    assert!(number(&summary, "/tracking/max_m") > 1e-3, "{scenario} has not moved");
    assert!(number(&summary, "/tracking/max_after_30s_m") <= max_after_30s_m, "{scenario}: {summary}");
}

#[test]
#[ignore = "needs vcan0"]
fn with_every_drive_on_vcan() {
    for Promise { scenario, max_after_30s_m, .. } in DRIVES {
        assert_kept(&Bench::over_vcan().of(scenario), max_after_30s_m);
    }
}
