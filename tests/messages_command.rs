//! `canloop messages` prints what a drive profile puts on the bus.

use std::path::Path;
use std::process::{Command, Output};

fn messages(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_canloop"));
    command.arg("messages").args(arguments).output().expect("the program starts")
}

#[test]
fn the_built_in_drive_is_shown_without_being_asked_for() {
    let output = messages(&[]);
    assert!(output.status.success());
    let table = String::from_utf8(output.stdout).expect("text");
    for message in ["Sync", "RightCommand", "LeftFeedback", "RightHeartbeat", "LeftFault"] {
        assert!(table.contains(message), "{message} is missing in\n{table}");
    }
}

#[test]
fn a_profile_of_one_s_own_is_found_by_its_path() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("dbc/wheel_drive.toml");
    assert_eq!(messages(&[path.to_str().expect("a UTF-8 path")]).stdout, messages(&[]).stdout);
}

#[test]
fn a_robot_s_file_shows_the_messages_with_the_ids_of_its_own_drives() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let path = folder.path().join("robot.toml");
    let robot = include_str!("../hil-sim/scenarios/dac-friction.toml");
    let own =
        robot.replace("profile = \"wheel_drive\"", "profile = \"wheel_drive\"\nnode_ids = { right = 5, left = 6 }");
    std::fs::write(&path, own).expect("the folder is writable");
    let output = messages(&[path.to_str().expect("a UTF-8 path")]);
    let table = String::from_utf8(output.stdout).expect("text");
    for (id, message) in [("080", "Sync"), ("205", "RightCommand"), ("186", "LeftFeedback"), ("706", "LeftHeartbeat")] {
        assert!(table.contains(&format!("| `0x{id}` | {message} |")), "{message} is not {id} in\n{table}");
    }
}

#[test]
fn a_robot_based_on_a_scenario_that_only_hil_sim_knows_is_refused_with_the_way_to_a_file() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, "base = \"dac-friction\"\n[drive]\nnode_ids = { right = 5 }\n").expect("it is writable");
    let output = messages(&[path.to_str().expect("a UTF-8 path")]);
    assert_eq!(output.status.code(), Some(2));
    let text = String::from_utf8(output.stderr).expect("text");
    for part in ["mine.toml:1:8", "`dac-friction`", "hil-sim scenario dac-friction > dac-friction.toml"] {
        assert!(text.contains(part), "{part} is missing in\n{text}");
    }
}

#[test]
fn a_profile_that_does_not_exist_is_bad_input() {
    for name in ["weel_drive", "no-such-file.toml"] {
        let output = messages(&[name]);
        assert_eq!(output.status.code(), Some(2));
        let text = String::from_utf8(output.stderr).expect("text");
        assert!(text.contains(name), "{text}");
    }
}
