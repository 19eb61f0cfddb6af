//! The whole set of scenarios gives the same frames time after time, however
//! busy the machine is.

mod rig;

use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};

use rig::builds::release_build;
use rig::{Rig, finish};

const TIMES: usize = 20;

#[test]
fn all_scenarios_send_the_same_frames_twenty_times_on_a_busy_machine() {
    let program = release_build();
    let listed = finish(Command::new(&program).args(["run", "--list"])).expect_status(0).stdout;
    let names: Vec<&str> = listed.lines().collect();
    let hashes = || -> Vec<String> {
        let rig = Rig::new();
        let mut run = Command::new("nice");
        run.args(["-n", "10"]).arg(&program).args(["run", "--no-log", "--no-report"]).args(&names);
        finish(run.current_dir(rig.path(""))).expect_status(0);
        let hash = |name: &&str| rig.summary(&format!("runs/{name}"))["frames_blake3"].to_string();
        names.iter().map(hash).collect()
    };
    let first = hashes();
    busy_meanwhile(|| {
        for time in 1..TIMES {
            let again = hashes();
            let other = names.iter().zip(first.iter().zip(&again)).find(|(_, (first, again))| first != again);
            assert!(other.is_none(), "run {time} differs: {other:?}");
        }
    });
}

/// Does something while a thread does nothing as fast as it can.
fn busy_meanwhile(work: impl FnOnce() + std::panic::UnwindSafe) {
    let is_over = AtomicBool::new(false);
    let worked = std::thread::scope(|scope| {
        scope.spawn(|| {
            while !is_over.load(Ordering::Relaxed) {
                std::hint::spin_loop();
            }
        });
        let worked = std::panic::catch_unwind(work);
        is_over.store(true, Ordering::Relaxed);
        worked
    });
    worked.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
}
