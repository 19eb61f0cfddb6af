//! The same scenario and seed give the same frames, bit for bit: in every
//! process, in every build, and after every change that should not matter.

mod rig;

use std::path::PathBuf;
use std::process::Command;

use rig::builds::other_build;
use rig::{Rig, finish};

/// Short runs and the hashes of their frames. Whoever changes the behaviour on
/// purpose puts in the hashes that the failing test prints and says so in the
/// commit; a change without a purpose is a defect.
const GOLDEN: [(&[&str], &str); 4] = [
    (&["duration_s=5.0"], "4fb3aa343921219ebe46e049aecad5a5f338440da567ff89b8d359fcc09b834d"),
    (
        &["duration_s=5.0", r#"robot.model="rigid-body""#, "period_s=0.001", "bus.bitrate_bit_s=1000000"],
        "1bab5189c6bba677ad4955fda9577c67e5364c07fe3aea4637ea0d8b34191691",
    ),
    (
        &[
            "duration_s=5.0",
            r#"controller.pose_loop="kanayama""#,
            "start={x_m=8.0,y_m=4.0,heading_rad=0.0}",
            r#"path={kind="figure-eight",center_m=[5.0,5.0],width_m=4.0,duration_s=20.0}"#,
        ],
        "58563a202376964455045a729a17bed9051256fac212908afbde9a7e5912971a",
    ),
    (
        &["duration_s=5.0", r#"controller={law="pi-speed",kp=1.0,ki=3.0}"#, "drive.counts_per_turn=1000"],
        "9ca3f10c025b522cb01da4b28e5accecfd88bc94205ff6438555d189f52c32d6",
    ),
];

#[test]
fn two_processes_send_the_same_frames() {
    for (overrides, _) in GOLDEN {
        assert_eq!(hash(&PathBuf::from(env!("CARGO_BIN_EXE_hil-sim")), overrides), hash_here(overrides));
    }
}

#[test]
fn the_debug_and_the_release_build_send_the_same_frames() {
    let other = other_build();
    for (overrides, _) in GOLDEN {
        assert_eq!(hash(&other, overrides), hash_here(overrides), "{overrides:?} on {}", other.display());
    }
    assert_eq!(hash(&other, &[]), hash_here(&[]), "150 s on {}", other.display());
}

#[test]
fn the_frames_are_those_they_have_always_been() {
    let found: Vec<_> = GOLDEN.iter().map(|(overrides, _)| (overrides, hash_here(overrides))).collect();
    let changed = GOLDEN.iter().zip(&found).any(|((_, golden), (_, found))| golden != found);
    assert!(!changed, "the frames have changed; they are now\n{found:#?}");
}

#[test]
fn different_runs_send_different_frames() {
    let hashes: Vec<_> = GOLDEN.iter().map(|(overrides, _)| hash_here(overrides)).collect();
    for (index, hash) in hashes.iter().enumerate() {
        assert!(!hashes[..index].contains(hash));
    }
    let heavier = hash_here(&["duration_s=5.0", "robot.load.mass_kg=80.001"]);
    assert_ne!(heavier, hashes[0], "a gram should be felt");
}

fn hash_here(overrides: &[&str]) -> String {
    hash(&PathBuf::from(env!("CARGO_BIN_EXE_hil-sim")), overrides)
}

fn hash(program: &PathBuf, overrides: &[&str]) -> String {
    let rig = Rig::new();
    let mut command = Command::new(program);
    command.args(["run", "dac-friction", "--no-log", "--set", "expect=[]"]);
    command.args(overrides.iter().flat_map(|set| ["--set", set]));
    finish(command.current_dir(rig.path("."))).expect_status(0);
    let summary = rig.summary("runs");
    summary["frames_blake3"].as_str().expect("a hash").to_owned()
}
