//! Each kind of event does on the bus and to the robot what it says, as readers
//! find that others wrote.

mod rig;

use rig::{Rig, python};

#[test]
fn every_kind_of_event_is_found_in_the_log_of_its_run() {
    let rig = Rig::new();
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_hil-sim"));
    let found = python("every_kind_of_event.py", &[program, &rig.path("")]);
    let mut tried: Vec<&str> = found.split_whitespace().collect();
    tried.sort_unstable();
    assert_eq!(tried, all_kinds(), "a kind of event has no test");
}

/// The kinds that the program knows, as it lists them to who mistypes one.
fn all_kinds() -> Vec<String> {
    let rig = Rig::new();
    rig.write("wrong.toml", "base = \"dac-friction\"\nname = \"wrong\"\n[[event]]\nat_s = 1\nkind = \"wrong\"\n");
    let refused = rig.hil_sim(&["run", "wrong.toml"]).expect_status(2).stderr;
    let (_, listed) = refused.split_once("expected one of ").expect("it lists them");
    let list = listed.lines().next().unwrap_or_default();
    let mut kinds: Vec<String> = list.split('"').skip(1).step_by(2).map(str::to_owned).collect();
    kinds.sort_unstable();
    kinds
}
