//! Bad input ends with status 2 and one message that says where, what was
//! found and what was expected, and leaves nothing behind.

mod rig;

use rig::{Rig, Run};

/// Runs the shipped scenario with one override that must be refused with a
/// message that holds all of `words`.
#[track_caller]
fn refused(rig: &Rig, overrides: &[&str], words: &[&str]) {
    check(rig, rig.run("dac-friction", overrides), words);
}

#[track_caller]
fn check(rig: &Rig, run: Run, words: &[&str]) {
    let before = rig.files();
    let run = run.expect_status(2);
    assert_eq!(run.stdout, "");
    assert_eq!(run.stderr.matches("error: ").count(), 1, "one message, please:\n{}", run.stderr);
    for word in words {
        assert!(run.stderr.contains(word), "the message should say {word:?}:\n{}", run.stderr);
    }
    assert!(!before.contains(&"runs".to_owned()), "a folder was left behind: {before:?}");
}

#[test]
fn an_impossible_number_is_refused_with_its_place() {
    let table = [
        ("robot.mass_kg=-1", "--set:1:15", "found -1, expected a number from 0.001"),
        ("robot.wheel_radius_m=0", "--set:1:22", "found 0, expected a number from 0.001"),
        ("period_s=0", "--set:1:10", "found 0, expected a number from 1e-5 to 10"),
        ("drive.counts_per_turn=0", "--set:1:23", "found 0, expected a whole number from 1"),
        ("drive.counts_per_turn=1.5", "--set:1:23", "found 1.5, expected a whole number from 1"),
        ("robot.load.mass_kg=-80.0", "--set:1:20", "found -80, expected a number from 0"),
        ("robot.mass_kg=nan", "--set:1:15", "found NaN, expected a number"),
        ("robot.mass_kg=-inf", "--set:1:15", "found -inf, expected a number"),
        ("robot.mass_kg=1e308", "--set:1:15", "found 1e308, expected a number from 0.001 to"),
        ("duration_s=1e300", "--set:1:12", "found 1e300, expected a number from"),
        ("duration_s=-1", "--set:1:12", "found -1, expected a number from"),
        ("drive.torque_limit_nm=0", "--set:1:23", "found 0, expected a number from"),
        ("drive.torque_limit_nm=1e6", "--set:1:23", "the most that a command"),
        ("path.center_m=[5.0]", "--set:1:15", "found an array, expected an array of 2 numbers"),
        ("bus.bitrate_bit_s=0", "--set:1:19", "found 0, expected a whole number from 10000"),
        ("seed=-1", "--set:1:6", "found -1, expected a whole number from 0"),
    ];
    for (set, place, words) in table {
        let key = set.split('=').next().expect("KEY=VALUE");
        refused(&Rig::new(), &[set], &[key, place, words]);
    }
}

#[test]
fn a_value_of_the_wrong_type_is_refused() {
    refused(&Rig::new(), &[r#"robot.mass_kg="heavy""#], &["--set:1:15", "found the string \"heavy\"", "a number"]);
    refused(&Rig::new(), &["controller.law=3"], &["--set:1:16", "found 3", "\"dac-matched\""]);
    refused(&Rig::new(), &["robot=3"], &["--set:1:7", "found 3, expected a table"]);
    refused(&Rig::new(), &["expect=3"], &["--set:1:8", "found 3", "[[expect]]"]);
    refused(&Rig::new(), &["name=2026-01-01"], &["--set:1:6", "found a date, expected a string"]);
}

#[test]
fn an_unknown_word_is_refused_with_the_words_there_are() {
    let words = ["found the string \"dacc\"", "\"dac\"", "\"dac-matched\"", "\"pi-speed\"", "\"pi-angle\""];
    refused(&Rig::new(), &[r#"controller.law="dacc""#], &words);
    refused(&Rig::new(), &[r#"path.kind="square""#], &["--set:1:11", "\"circle\"", "\"figure-eight\""]);
    refused(&Rig::new(), &[r#"robot.model="toy""#], &["\"paper\"", "\"rigid-body\""]);
    refused(&Rig::new(), &[r#"bus.link="wire""#], &["\"can\"", "\"ideal\""]);
}

#[test]
fn an_unknown_key_or_section_is_refused_with_the_nearest_one() {
    refused(&Rig::new(), &["robot.mas_kg=3"], &["--set:1:7", "found `mas_kg`", "did you mean `mass_kg`?"]);
    refused(&Rig::new(), &["robots.mass_kg=3"], &["--set:1:8", "found `robots`", "did you mean `robot`?"]);
    let rig = Rig::new();
    rig.write("my.toml", "base = \"dac-friction\"\nduration = 3.0\n\n[zebra]\nstripes = 4\n");
    let run = rig.hil_sim(&["run", "my.toml"]).expect_status(2);
    for words in ["my.toml:2:1", "did you mean `duration_s`?", "my.toml:4:2", "found `zebra`"] {
        assert!(run.stderr.contains(words), "{}", run.stderr);
    }
    assert_eq!(rig.files(), ["my.toml"]);
}

#[test]
fn a_key_that_is_missing_is_asked_for_where_it_should_stand() {
    let rig = Rig::new();
    rig.write("my.toml", &SHIPPED.replace("gear_ratio = 3.0\n", ""));
    check(&rig, rig.hil_sim(&["run", "my.toml"]), &["my.toml:8:1", "found no `gear_ratio` in [robot]", "a number"]);
    rig.write("my.toml", &SHIPPED.replace("[path]\nkind = \"circle\"\n", "[path]\n"));
    check(&rig, rig.hil_sim(&["run", "my.toml"]), &["my.toml:34:1", "found no `kind` in [path]", "\"circle\""]);
}

#[test]
fn a_file_that_is_missing_or_no_toml_is_refused() {
    let rig = Rig::new();
    check(&rig, rig.hil_sim(&["run", "nowhere.toml"]), &["cannot read nowhere.toml"]);
    check(&rig, rig.hil_sim(&["run", "./nowhere"]), &["cannot read ./nowhere"]);
    rig.write("my.toml", "name = \"x\"\nseed = = 3\n");
    check(&rig, rig.hil_sim(&["run", "my.toml"]), &["my.toml:2:8", "not valid TOML"]);
    rig.write("my.toml", "seed = 1\nseed = 2\n");
    check(&rig, rig.hil_sim(&["run", "my.toml"]), &["my.toml:2:1", "duplicate key"]);
    std::fs::write(rig.path("my.toml"), [0xff, 0xfe, 0x00]).expect("the folder is writable");
    check(&rig, rig.hil_sim(&["run", "my.toml"]), &["my.toml is not UTF-8 text"]);
    std::fs::create_dir(rig.path("folder.toml")).expect("the folder is writable");
    check(&rig, rig.hil_sim(&["run", "folder.toml"]), &["cannot read folder.toml"]);
}

#[test]
fn a_scenario_of_no_such_name_is_refused_with_the_nearest_one() {
    let rig = Rig::new();
    check(&rig, rig.hil_sim(&["run", "dac-frction"]), &["`dac-frction`", "did you mean `dac-friction`?", ".toml"]);
    check(&rig, rig.hil_sim(&["run", "xyz"]), &["`xyz`", "dac-friction", ".toml"]);
}

#[test]
fn a_bad_override_is_refused() {
    refused(&Rig::new(), &["seed"], &["--set:1:1", "expected KEY=VALUE"]);
    refused(&Rig::new(), &["controller.law=dac"], &["--set:1:16", "not valid TOML", "needs quotes"]);
    refused(&Rig::new(), &["=3"], &["--set:1:1", "not valid TOML"]);
    refused(&Rig::new(), &["name.first=3"], &["--set:1:6", "found a string there, expected a table"]);
    refused(&Rig::new(), &["robot.mass_kg=40\nseed=2"], &["--set:1:1", "must be one KEY=VALUE"]);
    refused(&Rig::new(), &["robot.mass_kg.=40"], &["--set:1:"]);
}

#[test]
fn gains_that_make_the_paper_s_error_matrix_unstable_are_refused() {
    let words = ["these gains are unstable", "eigenvalue of the error matrix A", "expected at most 1", "below 2/T"];
    for (set, place) in [
        ("controller.kd_per_s=500.0", "--set:1:21"),
        ("controller.kd_per_s=-1.0", "--set:1:21"),
        ("controller.kd_per_s=0", "--set:1:21"),
        ("controller.kp_per_s2=-0.1", "--set:1:22"),
        ("controller.kp_per_s2=5000.0", "--set:1:22"),
    ] {
        refused(&Rig::new(), &[set], &[&words[..], &[place]].concat());
    }
    refused(&Rig::new(), &["period_s=1.0"], &words);
}

#[test]
fn a_dbc_without_a_needed_signal_is_refused() {
    let dbc = include_str!("../../dbc/wheel_drive.dbc");
    let profile = include_str!("../../dbc/wheel_drive.toml");
    let rig = Rig::new();
    rig.write("own/wheel_drive.toml", profile);
    let set = [r#"drive.profile="own/wheel_drive.toml""#];
    let without: String =
        dbc.lines().filter(|line| !line.contains("TorqueApplied")).map(|line| format!("{line}\n")).collect();
    rig.write("own/wheel_drive.dbc", &without);
    let run = rig.run("dac-friction", &set).expect_status(2);
    for words in ["own/wheel_drive.toml:", "TorqueApplied", "RightFeedback"] {
        assert!(run.stderr.contains(words), "{}", run.stderr);
    }
    rig.write("own/wheel_drive.dbc", &dbc.replace("SG_ Torque : 0|16@1-", "SG_ Torque : 0|16@3-"));
    let run = rig.run("dac-friction", &set).expect_status(2);
    assert!(run.stderr.contains("own/wheel_drive.dbc:"), "{}", run.stderr);
    std::fs::remove_file(rig.path("own/wheel_drive.dbc")).expect("it was there");
    refused(&rig, &set, &["own/wheel_drive.dbc"]);
    assert_eq!(rig.files(), ["own"]);
    rig.write("own/wheel_drive.dbc", dbc);
    rig.run("dac-friction", &[set[0], "duration_s=0.1", "expect=[]"]).expect_status(0);
}

#[test]
fn a_drive_profile_that_does_not_exist_is_refused_where_it_is_named() {
    refused(&Rig::new(), &[r#"drive.profile="nope""#], &["--set:1:15", "no drive profile \"nope\"", "wheel_drive"]);
    refused(&Rig::new(), &[r#"drive.profile="no.toml""#], &["--set:1:15", "cannot read no.toml"]);
}

#[test]
fn friction_that_holds_less_than_it_slides_is_refused_for_the_wheel_that_says_so() {
    let words = ["found 1, less than `coulomb_nm`, 6"];
    refused(&Rig::new(), &["robot.friction.static_nm=1"], &[words[0], "--set:1:26"]);
    refused(&Rig::new(), &["robot.friction.left.static_nm=1"], &[words[0], "--set:1:31"]);
}

#[test]
fn an_expectation_that_nothing_could_meet_is_refused() {
    let signal = r#"expect=[{signal="position_eror_m",max=1}]"#;
    refused(&Rig::new(), &[signal], &["--set:1:17", "no such signal", "did you mean `position_error_m`?"]);
    for (bad, words) in [
        ("max=1,from_s=200", "found 200, expected a time before 150"),
        ("max=1,until_s=151", "found 151, expected no more than `duration_s`, 150"),
        ("max=1,from_s=-1", "found -1, expected"),
        ("from_s=3", "found no bound on it"),
        ("max=1,min=2", "`min` above `max`"),
        ("max=nan", "found NaN, expected a finite number"),
    ] {
        refused(&Rig::new(), &[&format!(r#"expect=[{{signal="position_error_m",{bad}}}]"#)], &["--set:1:", words]);
    }
}

#[test]
fn a_period_longer_than_the_run_is_refused() {
    refused(
        &Rig::new(),
        &["duration_s=0.004", "expect=[]"],
        &["period_s", "found a period longer than `duration_s`, 0.004"],
    );
}

#[test]
fn a_name_that_would_lead_out_of_its_folder_is_refused() {
    for name in ["../x", "a/b", "", "..", ".hidden", "a b", "C:x"] {
        refused(&Rig::new(), &[&format!("name={name:?}")], &["--set:1:6", "expected letters, digits"]);
    }
}

#[test]
fn two_scenarios_of_one_name_are_refused() {
    let rig = Rig::new();
    check(&rig, rig.hil_sim(&["run", "dac-friction", "dac-friction"]), &["two scenarios are named `dac-friction`"]);
}

#[test]
fn one_bad_scenario_among_good_ones_keeps_them_all_from_running() {
    let rig = Rig::new();
    check(&rig, rig.hil_sim(&["run", "dac-friction", "nowhere.toml"]), &["cannot read nowhere.toml"]);
}

#[test]
fn a_circle_of_bases_and_a_base_that_is_missing_are_refused() {
    let rig = Rig::new();
    rig.write("a.toml", "base = \"b.toml\"\n");
    rig.write("b.toml", "base = \"a.toml\"\n");
    check(&rig, rig.hil_sim(&["run", "a.toml"]), &["a.toml:1:8", "circle"]);
    rig.write("a.toml", "seed = 3\nbase = \"c.toml\"\n");
    check(&rig, rig.hil_sim(&["run", "a.toml"]), &["a.toml:2:8", "c.toml", "named here"]);
}

#[test]
fn an_output_folder_that_cannot_be_made_is_refused() {
    let rig = Rig::new();
    rig.write("file", "");
    let run = rig.hil_sim(&["run", "dac-friction", "--out", "file/x"]).expect_status(2);
    assert!(run.stderr.contains("file/x") && run.stderr.contains("--out"), "{}", run.stderr);
    assert_eq!(rig.files(), ["file"]);
}

#[test]
fn a_command_line_that_is_wrong_ends_with_the_same_status() {
    for args in [&["run"][..], &["run", "dac-friction", "--sett", "a=1"], &["walk"], &[]] {
        let rig = Rig::new();
        let run = rig.hil_sim(args).expect_status(2);
        assert!(run.stderr.contains("Usage: hil-sim"), "{}", run.stderr);
        assert!(rig.files().is_empty());
    }
}

const SHIPPED: &str = include_str!("../scenarios/dac-friction.toml");
