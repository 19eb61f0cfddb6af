//! `canloop convert` and `canloop show` as a user calls them.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use crate::rig::folder;

const LOG: &str = "\
(1436509052.000000) can0 181#0000000000000000
(1436509052.005000) can0 181#0100000000000000
(1436509052.010000) can0 181#0200000000000000 T
(1436509052.010000) can1 18FEF1FE##1AABBCCDD
(1436509052.005000) can1 20000088#0000010000000000
";
const DBC: &str = "BU_: A\n\nBO_ 385 Wheel: 8 A\n SG_ Position : 0|16@1- (0.5,0) [0|0] \"rad\" A\n SG_ State : 16|8@1+ (1,0) [0|0] \"\" A\n\nVAL_ 385 State 0 \"Off\" 1 \"On\" ;\n";

fn canloop(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_canloop")).current_dir(folder).args(args).output().expect("it runs")
}

fn out(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("UTF-8")
}

fn err(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("UTF-8")
}

#[test]
fn a_log_goes_through_other_formats_and_comes_back_the_same() {
    let folder = folder();
    std::fs::write(folder.path().join("a.log"), LOG).unwrap();
    for steps in [["a.log", "b.mcap", "c.log"], ["a.log", "b.pcapng", "c.log"], ["a.log", "b.csv", "c.log"]] {
        for pair in steps.windows(2) {
            let done = canloop(folder.path(), &["convert", pair[0], pair[1]]);
            assert!(done.status.success(), "{}", err(&done));
            assert!(out(&done).contains("5 records of can0, can1"), "{}", out(&done));
            assert_eq!(err(&done), "");
        }
        assert_eq!(std::fs::read_to_string(folder.path().join("c.log")).unwrap(), LOG);
    }
}

#[test]
fn what_the_target_cannot_hold_is_said() {
    let folder = folder();
    std::fs::write(folder.path().join("a.log"), LOG).unwrap();
    let done = canloop(folder.path(), &["convert", "a.log", "b.trc", "--to", "trc-1.1"]);
    assert!(done.status.success());
    assert_eq!(
        err(&done),
        "warning: TRC 1.1 holds no CAN FD frames: 1 left out\n\
         warning: TRC 1.1 does not tell buses apart: 1 frames of others are on the first\n"
    );
}

#[test]
fn damage_is_said_with_its_place_and_all_else_is_converted() {
    let folder = folder();
    let damaged = LOG.replace("181#02", "181#XX");
    std::fs::write(folder.path().join("a.log"), damaged).unwrap();
    let done = canloop(folder.path(), &["convert", "a.log", "b.csv"]);
    assert_eq!(done.status.code(), Some(2));
    let said = err(&done);
    assert!(said.starts_with("error: found `X` in the data, expected hexadecimal digits\n --> a.log:3:30\n"), "{said}");
    assert_eq!(std::fs::read_to_string(folder.path().join("b.csv")).unwrap().lines().count(), 5);
}

#[test]
fn bad_arguments_are_refused_and_nothing_is_written() {
    let folder = folder();
    std::fs::write(folder.path().join("a.log"), LOG).unwrap();
    std::fs::write(folder.path().join("what"), "hello\n").unwrap();
    for (args, wanted) in [
        (&["convert", "a.log", "b.xyz"][..], "b.xyz: the name does not show what it is to be"),
        (&["convert", "a.log", "b", "--to", "blff"], "did you mean blf?"),
        (&["convert", "a.log", "a.log"], "a.log would be written over itself"),
        (&["convert", "b.log", "c.log"], "cannot open b.log: No such file"),
        (&["convert", "what", "c.log"], "neither its content nor its name shows what it is"),
        (&["convert", ".", "c.log"], "is a folder"),
        (&["convert", "a.log", "c.log", "--to", "busmaster"], "BUSMASTER files are read, but not written"),
        (&["convert", "a.log", "no/c.log"], "cannot create no/c.log"),
        (&["show", "a.log", "--dbc", "no.dbc"], "cannot read no.dbc"),
    ] {
        let done = canloop(folder.path(), args);
        assert_eq!(done.status.code(), Some(2), "{args:?}");
        assert!(err(&done).contains(wanted), "{args:?}: {}", err(&done));
        assert!(!folder.path().join("c.log").exists());
    }
    assert_eq!(std::fs::read_to_string(folder.path().join("a.log")).unwrap(), LOG);
}

#[test]
fn a_log_may_come_from_a_pipe() {
    let folder = folder();
    std::fs::write(folder.path().join("a.log"), LOG).unwrap();
    let input = std::fs::File::open(folder.path().join("a.log")).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_canloop"));
    let done =
        command.current_dir(folder.path()).args(["convert", "-", "b.asc"]).stdin(input).output().expect("it runs");
    assert!(out(&done).starts_with("standard input (candump): 5 records"), "{}", out(&done));
}

#[test]
fn a_log_is_shown_in_lines_that_fit_a_terminal() {
    let folder = folder();
    std::fs::write(folder.path().join("a.log"), LOG).unwrap();
    let done = canloop(folder.path(), &["show", "a.log", "--bitrate", "500000", "--data-bitrate", "2000000"]);
    assert!(done.status.success());
    let text = out(&done);
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    for wanted in [
        "a.log: candump",
        "4, 1 of them CAN FD; 1 error frames, 0 lost",
        "0.010000 s, from 2015-07-10 06:17:32.000000",
        "in steps of 1 ms; 1 go back, by up to 0.005000 s; 1 are as the one before",
        "can0         181      data       8          3        5.000        0.000        5.000        0.000",
    ] {
        assert!(text.contains(wanted), "{wanted}\n{text}");
    }
}

#[test]
fn the_same_figures_come_as_json() {
    let folder = folder();
    std::fs::write(folder.path().join("a.log"), LOG).unwrap();
    let done = canloop(folder.path(), &["show", "a.log", "--json", "--bitrate", "500000"]);
    let json: Value = serde_json::from_str(&out(&done)).expect("JSON");
    assert_eq!((&json["format"], &json["records"]), (&Value::from("candump"), &Value::from(5)));
    assert_eq!(json["buses"][1]["errors"], 1);
    assert_eq!(json["stamps"]["backwards"], 1);
    assert_eq!(json["messages"][0]["period_s"], 0.005);
    // Three frames of 8 bytes, mostly zeros, of 111 bits and their stuff bits in 10 ms.
    let load = json["buses"][0]["load"].as_f64().expect("a load");
    assert!((0.067..0.085).contains(&load), "{load}");
}

#[test]
fn frames_are_decoded() {
    let folder = folder();
    std::fs::write(folder.path().join("a.log"), LOG).unwrap();
    std::fs::write(folder.path().join("a.dbc"), DBC).unwrap();
    let done = canloop(folder.path(), &["show", "a.log", "--dbc", "a.dbc"]);
    assert_eq!(
        out(&done),
        "1436509052.000000000  can0  181 Wheel  Position=0 rad  State=Off\n\
         1436509052.005000000  can0  181 Wheel  Position=0.5 rad  State=Off\n\
         1436509052.010000000  can0> 181 Wheel  Position=1 rad  State=Off\n\
         1436509052.010000000  can1  18FEF1FE##1AABBCCDD\n\
         1436509052.005000000  can1  error frame 00000088 [00, 00, 01, 00, 00, 00, 00, 00]\n"
    );
    let done =
        canloop(folder.path(), &["show", "a.log", "--dbc", "a.dbc", "--signals", "Position,Wheel.State", "--csv"]);
    assert_eq!(
        out(&done),
        "time_s,Position,Wheel.State\n1436509052.000000000,0,0\n1436509052.005000000,0.5,0\n1436509052.010000000,1,0\n"
    );
    let done = canloop(folder.path(), &["show", "a.log", "--dbc", "a.dbc", "--signals", "Positon", "--csv"]);
    assert_eq!(done.status.code(), Some(2));
    assert!(err(&done).contains("did you mean Position?"), "{}", err(&done));
}
