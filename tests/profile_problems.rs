//! A profile that asks its DBC for something that is not there, or is not
//! what it should be, is refused at the key that asks.

use canloop::config::{Document, Problem, Problems, Source};
use canloop::schema::{Patience, Profile};

const TOML: &str = include_str!("../dbc/wheel_drive.toml");
const DBC: &str = include_str!("../dbc/wheel_drive.dbc");

fn parse(toml: &str, dbc: &str) -> Result<Profile, Problems> {
    Profile::parse(&Document::parse("drive.toml", toml)?, &Source::new("drive.dbc", dbc))
}

/// The one problem that `toml` with `dbc` has.
#[track_caller]
fn problem(toml: &str, dbc: &str) -> Problem {
    let Problems(list) = parse(toml, dbc).expect_err("this profile is bad");
    match <[Problem; 1]>::try_from(list) {
        Ok([problem]) => problem,
        Err(list) => panic!("expected one problem:\n{}", Problems(list)),
    }
}

/// With `from` replaced by `to` in the profile there is one problem, at `to`,
/// which names all `parts`.
#[track_caller]
fn assert_refused(from: &str, to: &str, parts: &[&str]) {
    assert!(TOML.contains(from), "{from}");
    let problem = problem(&TOML.replacen(from, to, 1), DBC);
    let message = problem.to_string();
    let (source, span) = problem.place.as_ref().expect("a place");
    let line = source.text[..span.start].matches('\n').count() + 1;
    let shown = source.text.lines().nth(line - 1).unwrap();
    assert!(shown.contains(to), "not at {to:?}:\n{message}");
    for part in parts {
        assert!(message.contains(part), "no {part:?} in:\n{message}");
    }
}

/// With `from` replaced by `to` in the DBC, everywhere, there is one problem
/// in the profile, which names all `parts`.
#[track_caller]
fn assert_dbc_refused(from: &str, to: &str, parts: &[&str]) {
    assert!(DBC.contains(from), "{from}");
    let problem = problem(TOML, &DBC.replace(from, to));
    let message = problem.to_string();
    assert!(problem.position().unwrap().starts_with("drive.toml"), "{message}");
    for part in parts {
        assert!(message.contains(part), "no {part:?} in:\n{message}");
    }
}

#[test]
fn the_profile_that_comes_along_is_good() {
    let profile = parse(TOML, DBC).unwrap_or_else(|problems| panic!("{problems}"));
    assert_eq!(profile.name, "wheel_drive");
    assert_eq!(profile.toml_text, TOML);
    assert_eq!((profile.node_ids.right, profile.node_ids.left), (1, 2));
    assert_eq!(profile.heartbeat_period, Some(canloop::time::Duration::from_millis(100)));
    assert_eq!(profile.watchdog.map(|watchdog| watchdog.patience), Some(Patience::Periods(4)));
}

#[test]
fn a_message_that_is_not_there_is_reported_with_the_nearest_names() {
    assert_refused("{node}Command", "{node}Comand", &["drive.dbc has no message `RightComand`", "`RightCommand`"]);
    assert_refused("\"Sync\"", "\"Synch\"", &["drive.dbc has no message `Synch`", "`Sync`"]);
}

#[test]
fn a_message_of_one_wheel_only_is_reported() {
    assert_dbc_refused("LeftFeedback", "LeftReport", &["drive.dbc has no message `LeftFeedback`"]);
}

#[test]
fn a_signal_that_is_not_there_is_reported_with_the_nearest_names() {
    assert_refused("\"TorqueApplied\"", "\"Torque\"", &["RightFeedback of drive.dbc has no signal", "`TorqueApplied`"]);
}

#[test]
fn a_value_name_that_is_not_there_is_reported_once_with_the_nearest_names() {
    assert_refused("\"Ready\"", "\"Redy\"", &["RightFeedback.State of drive.dbc has no value named `Redy`", "`Ready`"]);
}

#[test]
fn right_and_left_mixed_up_are_noticed() {
    assert_refused(
        "right = { node = \"Right\", id = 1 }",
        "right = { node = \"Right\", id = 2 }",
        &["`RightCommand` of drive.dbc is another node's", "found node 2, but id 201 carries node 1"],
    );
}

#[test]
fn one_message_cannot_have_two_roles() {
    let toml = TOML.replace("{node}Fault\"", "{node}Heartbeat\"");
    let Problems(list) = parse(&toml, DBC).unwrap_err();
    assert!(
        list.iter().all(|problem| problem.to_string().contains("which another message of the profile has already"))
    );
}

#[test]
fn signals_that_cannot_serve_are_refused() {
    assert_dbc_refused("SG_ Position : 0|32@1- (1,0)", "SG_ Position : 0|32@1- (0.5,0)", &["`Position`", "48 bits"]);
    assert_dbc_refused("SG_ Counter : 20|4@1+", "SG_ Counter : 20|4@1-", &["`Counter`", "unsigned"]);
    assert_dbc_refused("SG_ Crc : 24|8@1+", "SG_ Crc : 24|7@1+", &["`Crc`", "8 bits that are a whole byte"]);
    let beside_a_byte = (
        " SG_ Counter : 20|4@1+ (1,0) [0|15] \"\" RightDrive\n SG_ Crc : 24|8",
        " SG_ Counter : 28|4@1+ (1,0) [0|15] \"\" RightDrive\n SG_ Crc : 20|8",
    );
    assert_dbc_refused(beside_a_byte.0, beside_a_byte.1, &["`Crc`", "8 bits that are a whole byte"]);
    assert_dbc_refused(
        "SG_ Torque : 0|16@1- (0.005,0) [-163.84|163.835]",
        "SG_ Torque : 0|16@1- (0.005,200) [0|0]",
        &["`Torque`", "a finite range that includes 0"],
    );
    assert_dbc_refused("SG_ Request : 16|4@1+", "SG_ Request : 16|1@1+", &["`Request`", "`ClearFault`, 2"]);
}

#[test]
fn a_heartbeat_without_a_period_is_refused() {
    assert_dbc_refused("BO_ 1793 100", "BO_ 1793 0", &["found none for the right wheel", "GenMsgCycleTime"]);
}

#[test]
fn keys_that_are_missing_unknown_or_out_of_range_are_reported() {
    assert_refused("torque_at = \"wheel\"", "torque_at = \"axle\"", &["expected one of \"wheel\", \"motor\""]);
    assert_refused("periods = 4", "periods = 0", &["found 0", "from 1 to 1000"]);
    let message = problem(&format!("{TOML}brake = \"Brake\"\n"), DBC).to_string();
    assert!(message.contains("unknown key `faults.brake`"), "{message}");
    let toml = TOML.replacen("torque = \"Torque\"\n", "", 1);
    assert!(problem(&toml, DBC).to_string().contains("`command.torque` is missing"));
}

#[test]
fn a_message_without_a_crc_needs_no_crc() {
    let toml = TOML.replace("crc = \"Crc\"\n", "");
    assert!(parse(&toml, DBC).is_ok());
    let toml = TOML.split("# SAE J1850").next().unwrap().to_owned() + TOML.split("id_bytes = 2\n").nth(1).unwrap();
    assert!(parse(&toml, DBC).unwrap_err().to_string().contains("expected a table [crc]"));
}

#[test]
fn a_bad_dbc_is_reported_in_the_dbc() {
    let problem = problem(TOML, &DBC.replace("BO_ 386", "BO_ 385"));
    assert_eq!(problem.position().unwrap(), "drive.dbc:30:5", "{problem}");
}

#[test]
fn profiles_are_loaded_by_name_or_from_a_file_with_the_dbc_beside_it() {
    assert_eq!(Profile::load("wheel_drive").unwrap().name, "wheel_drive");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/dbc/wheel_drive.toml");
    let profile = Profile::load(path).unwrap_or_else(|problems| panic!("{problems}"));
    assert_eq!(profile.dbc.source.text, DBC);
    let unknown = Profile::load("weel_drive").unwrap_err().to_string();
    assert!(unknown.contains("\"weel_drive\"") && unknown.contains("wheel_drive"), "{unknown}");
    assert!(Profile::load("nowhere/drive.toml").unwrap_err().to_string().contains("cannot read nowhere/drive.toml"));
}

#[test]
fn a_dbc_that_is_missing_is_reported_at_the_key_that_names_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.toml");
    std::fs::write(&path, TOML).unwrap();
    let message = Profile::load(path.to_str().unwrap()).unwrap_err().to_string();
    assert!(message.contains("cannot read") && message.contains("drive.toml:4:"), "{message}");
}

#[test]
fn words_and_states_that_are_not_there_are_reported_with_the_nearest_names() {
    assert_refused(
        "enable = \"enable\"",
        "enable = \"enabel\"",
        &["found `enabel`, which is not in [words]", "`enable`"],
    );
    assert_refused("next = \"ready\"", "next = \"reddy\"", &["found `reddy`, which is no [[state]]", "`ready`"]);
    assert_refused("hears = { enable = ", "hears = { enabel = ", &["found `enabel`, which is not in [words]"]);
    assert_refused("leads_to = \"fault\"", "leads_to = \"falt\"", &["found `falt`, which is no [[state]]", "`fault`"]);
    assert_refused("means = \"boot\"", "means = \"asleep\"", &["expected one of \"boot\", \"ready\""]);
    assert_refused(
        "Request = \"Enable\"",
        "Requst = \"Enable\"",
        &["RightCommand of drive.dbc has no signal `Requst`"],
    );
}

#[test]
fn a_value_must_fit_its_signal_and_its_mask() {
    assert_refused("shows = \"Boot\"", "shows = 16", &["`State`", "one that can hold 16"]);
    let masked = "shows = { mask = 0x3, value = 0x4 }";
    assert_refused("shows = \"Boot\"", masked, &["found 0x3, expected one that covers the value and fits `State`"]);
}

#[test]
fn drives_that_wait_for_a_sync_need_one_and_those_that_do_not_need_something_else() {
    let toml = TOML.replacen("[sync]\nmessage = \"Sync\"\ncounter = \"Counter\"\n", "", 1);
    let message = parse(&toml, DBC).unwrap_err().to_string();
    assert!(message.contains("expected a table [sync]"), "{message}");
    assert_refused("asks_with = \"sync\"", "asks_with = \"shouting\"", &["expected one of \"sync\", \"poll\""]);
    let dbc =
        DBC.replace("BA_ \"GenMsgCycleTime\" BO_ 385 5;\n", "").replace("BA_ \"GenMsgCycleTime\" BO_ 386 5;\n", "");
    let toml = TOML.replacen("asks_with = \"sync\"", "asks_with = \"nothing\"", 1);
    let message = problem(&toml, &dbc).to_string();
    assert!(message.contains("found no GenMsgCycleTime") && message.contains("drive.toml"), "{message}");
}

#[test]
fn every_profile_that_ships_is_good() {
    for name in Profile::builtin_names() {
        assert_eq!(Profile::builtin(name).expect("it is built in").name, name);
    }
}
