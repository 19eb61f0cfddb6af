//! `canloop check` finds everything that is wrong with a file, with its place
//! and what to do, before anything runs on it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// A folder of files to be checked.
struct Files(tempfile::TempDir);

impl Files {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn write(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).expect("the file is written");
        path
    }
}

fn check<P: AsRef<Path>>(options: &[&str], files: &[P]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_canloop"));
    command.arg("check").args(options).args(files.iter().map(AsRef::as_ref)).output().expect("the program starts")
}

/// Exit status and findings of one file.
fn found(options: &[&str], file: &Path) -> (i32, Vec<Value>) {
    let output = check(&[&["--json"], options].concat(), &[file]);
    let text = String::from_utf8(output.stdout).expect("text");
    let findings = text.lines().map(|line| serde_json::from_str(line).expect("a JSON object a line")).collect();
    (output.status.code().expect("a status"), findings)
}

/// Of a DBC's text: severity, line, column and message of every finding.
fn found_in_dbc(text: &str) -> (i32, Vec<(String, u64, u64, String)>) {
    let files = Files::new();
    let (status, findings) = found(&[], &files.write("a.dbc", text));
    let told = findings.iter().map(|finding| {
        assert!(finding["hint"].is_string(), "no hint: {finding}");
        let text = |key: &str| finding[key].as_str().unwrap().to_owned();
        let number = |key: &str| finding[key].as_u64().unwrap();
        (text("severity"), number("line"), number("column"), text("message"))
    });
    (status, told.collect())
}

#[track_caller]
fn assert_found(text: &str, severity: &str, line: u64, column: u64, message: &str) {
    let (status, findings) = found_in_dbc(text);
    let expected = (severity.to_owned(), line, column, message.to_owned());
    assert_eq!(findings, [expected]);
    assert_eq!(status, i32::from(severity == "error"));
}

const GOOD: &str = "VERSION \"\"\nBU_: A B\nBO_ 1 One: 8 A\n SG_ First : 0|16@1+ (1,0) [0|0] \"\" B\n";

#[test]
fn shipped_files_are_clean() {
    let files: Vec<PathBuf> = ["dbc", "hil-sim/scenarios"]
        .iter()
        .flat_map(|folder| std::fs::read_dir(Path::new(ROOT).join(folder)).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "dbc" || extension == "toml"))
        .collect();
    let output = check(&[], &files);
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert_eq!(text, format!("{} files: nothing to complain of\n", files.len()));
}

#[test]
fn all_findings_come_with_line_column_source_and_hint() {
    let files = Files::new();
    let text = GOOD.replace("0|16", "0|0")
        + " SG_ Far : 63|9@1+ (0.5,0) [0|0] \"\" B\nBO_ 1 Two: 8 C\nVAL_ 1 First 0 \"a\" ;\n";
    let path = files.write("bad.dbc", &text);
    let output = check(&[], &[&path]);
    let shown = String::from_utf8(output.stdout).unwrap();
    for part in [
        "bad.dbc:4:14",
        "4 |  SG_ First : 0|0@1+",
        "= help: it is passed over",
        "One.Far does not fit its message",
        "warning: One.Far has no unit",
        "bad.dbc:6:5",
        "the id 001 is given twice",
        "nobody knows the sender of Two",
        "1 file: 3 errors, 2 warnings",
    ] {
        assert!(shown.contains(part), "no {part:?} in:\n{shown}");
    }
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn overlapping_signals_are_errors_unless_a_switch_keeps_them_apart() {
    let over = " SG_ Over : 15|2@1+ (1,0) [0|0] \"\" B\n";
    assert_found(&format!("{GOOD}{over}"), "error", 5, 13, "First and Over of One overlap");
    let multiplexed = GOOD.replace("First :", "First m0 :").replace("0|16@1+", "8|16@1+");
    let switch = " SG_ Mode M : 0|8@1+ (1,0) [0|0] \"\" B\n";
    let apart = " SG_ Other m1 : 8|8@1+ (1,0) [0|0] \"\" B\n";
    assert_eq!(found_in_dbc(&format!("{multiplexed}{switch}{apart}")), (0, vec![]));
    let ranges = "SG_MUL_VAL_ 1 Other Mode 0-3;\n";
    assert_found(&format!("{multiplexed}{switch}{apart}{ranges}"), "error", 6, 17, "First and Other of One overlap");
}

#[test]
fn what_is_given_twice_is_an_error_or_a_warning() {
    assert_found(&format!("{GOOD}BO_ 1 Two: 8 A\n"), "error", 5, 5, "the id 001 is given twice");
    assert_found(&format!("{GOOD}BO_ 2 One: 8 A\n"), "error", 5, 7, "the name One is given twice");
    assert_found(&GOOD.replace("A B\n", "A B A\n"), "warning", 2, 10, "the node A is given twice");
    assert_found(
        &format!("{GOOD}VAL_ 1 First 1 \"a\" 1 \"b\" ;\n"),
        "warning",
        5,
        20,
        "a value of One.First is named twice",
    );
}

#[test]
fn ranges_units_and_start_values_are_looked_at() {
    assert_found(&GOOD.replace("(1,0)", "(0.5,0)"), "warning", 4, 36, "One.First has no unit");
    assert_found(
        &GOOD.replace("[0|0]", "[0|70000]"),
        "warning",
        4,
        28,
        "the range of One.First is wider than its bits",
    );
    let start = "BA_DEF_ SG_ \"GenSigStartValue\" INT 0 0;\nBA_ \"GenSigStartValue\" SG_ 1 First 65536;\n";
    assert_found(&format!("{GOOD}{start}"), "warning", 4, 14, "One.First cannot start with its start value");
}

#[test]
fn a_rate_that_the_bus_cannot_carry_is_an_error() {
    // 135 bits at worst, every millisecond: 135 kbit/s.
    let cycle = "BA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 1000;\nBA_ \"GenMsgCycleTime\" BO_ 1 1;\n";
    let files = Files::new();
    let path = files.write("busy.dbc", format!("{GOOD}{cycle}"));
    assert_eq!(found(&[], &path), (0, vec![]));
    assert_eq!(found(&["--bitrate", "140000"], &path).0, 0);
    let (status, findings) = found(&["--bitrate", "125000"], &path);
    assert_eq!((status, &findings[0]["line"]), (1, &3.into()));
    assert_eq!(findings[0]["message"], "the bus cannot carry this: 108 % of its 125000 bit/s");
    let rate = "BA_DEF_ \"Baudrate\" INT 0 1000000;\nBA_ \"Baudrate\" 125000;\n";
    assert_eq!(found(&[], &files.write("busy.dbc", format!("{GOOD}{cycle}{rate}"))).0, 1);
}

#[test]
fn a_profile_is_checked_together_with_its_dbc() {
    let files = Files::new();
    let toml = std::fs::read_to_string(Path::new(ROOT).join("dbc/wheel_drive.toml")).unwrap();
    let dbc = std::fs::read_to_string(Path::new(ROOT).join("dbc/wheel_drive.dbc")).unwrap();
    files.write(
        "wheel_drive.dbc",
        dbc.replacen("SG_ Request : 16|4", "SG_ Requests : 16|4", 1).replace("\"N m\"", "\"\""),
    );
    let path = files.write("mine.toml", toml.replace("position_at = \"motor\"", "position_at = \"wheels\""));
    let (status, findings) = found(&[], &path);
    let messages: Vec<_> = findings.iter().map(|finding| finding["message"].as_str().unwrap()).collect();
    assert!(messages.iter().any(|message| message.contains("RightCommand.Torque has no unit")), "{messages:#?}");
    assert!(messages.iter().any(|message| message.contains("has no signal `Request`")), "{messages:#?}");
    assert!(messages.iter().any(|message| message.contains("position_at` will not do")), "{messages:#?}");
    assert_eq!(status, 1);
}

#[test]
fn a_robot_file_is_checked_together_with_its_profile() {
    let files = Files::new();
    for name in ["wheel_drive.toml", "wheel_drive.dbc"] {
        std::fs::copy(Path::new(ROOT).join("dbc").join(name), files.0.path().join(name)).unwrap();
    }
    let scenario = std::fs::read_to_string(Path::new(ROOT).join("hil-sim/scenarios/dac-friction.toml")).unwrap();
    let own = scenario.replace("profile = \"wheel_drive\"", "profile = \"wheel_drive.toml\"");
    assert_ne!(own, scenario);
    let path = files.write("robot.toml", &own);
    assert_eq!(found(&[], &path), (0, vec![]));
    files.write("wheel_drive.dbc", "BU_:\n");
    let (status, findings) = found(&[], &path);
    assert!(findings.iter().any(|finding| finding["file"].as_str().unwrap().ends_with("wheel_drive.toml")));
    assert_eq!(status, 1);
}

#[test]
fn a_robot_that_is_too_fast_for_its_bus_is_an_error() {
    let files = Files::new();
    let scenario = std::fs::read_to_string(Path::new(ROOT).join("hil-sim/scenarios/dac-friction.toml")).unwrap();
    let line = scenario.lines().find(|line| line.starts_with("period_s")).unwrap();
    let path = files.write("fast.toml", scenario.replace(line, "period_s = 0.0005"));
    let (status, findings) = found(&[], &path);
    let [finding] = findings.as_slice() else { panic!("{findings:#?}") };
    assert_eq!(finding["message"], "the bus cannot carry this: 210 % of its 500000 bit/s");
    assert!(finding["hint"].as_str().unwrap().contains("`period_s` 0.00135 or longer"), "{finding}");
    assert_eq!(status, 1);
}

#[test]
fn a_robot_whose_messages_can_be_late_is_a_warning() {
    let files = Files::new();
    let scenario = std::fs::read_to_string(Path::new(ROOT).join("hil-sim/scenarios/dac-friction.toml")).unwrap();
    let path = files.write("fast.toml", scenario.replace("period_s = 0.005", "period_s = 0.0012"));
    let (status, findings) = found(&[], &path);
    let [finding] = findings.as_slice() else { panic!("{findings:#?}") };
    assert_eq!((&finding["severity"], &finding["line"]), (&"warning".into(), &6.into()));
    assert_eq!(finding["message"], "the bus cannot always carry this in time");
    assert!(finding["label"].as_str().unwrap().contains("takes up to"), "{finding}");
    assert_eq!(status, 0);
}

#[test]
fn a_base_that_only_hil_sim_knows_is_a_warning() {
    let files = Files::new();
    let path = files.write("mine.toml", "base = \"dac-friction\"\nname = \"mine\"\n");
    let (status, findings) = found(&[], &path);
    assert_eq!((status, findings.len(), &findings[0]["severity"]), (0, 1, &"warning".into()));
    assert!(findings[0]["hint"].as_str().unwrap().contains("hil-sim check"));
}

#[test]
fn all_that_is_no_toml_is_found() {
    let files = Files::new();
    let (status, findings) = found(&[], &files.write("bad.toml", "name = \nperiod_s = 1..2\n[robot\n"));
    let lines: Vec<_> = findings.iter().map(|finding| finding["line"].as_u64().unwrap()).collect();
    assert_eq!((status, lines.first(), lines.last()), (1, Some(&1), Some(&3)), "{findings:#?}");
}

#[test]
fn files_that_cannot_be_read_end_with_2_and_the_others_are_checked() {
    let files = Files::new();
    let bad = files.write("bad.dbc", GOOD.replace("0|16", "0|0"));
    let other = files.write("notes.txt", "nothing of ours");
    let empty = files.write("empty.toml", "");
    let missing = files.0.path().join("missing.dbc");
    let output = check(&[], &[missing, bad, other, empty]);
    let text = String::from_utf8(output.stdout).unwrap();
    for part in
        ["One.First has no usable size", "cannot read", "notes.txt is no file that can be checked", "empty.toml is no"]
    {
        assert!(text.contains(part), "no {part:?} in:\n{text}");
    }
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn a_dbc_is_known_by_its_contents_too() {
    let files = Files::new();
    assert_eq!(found(&[], &files.write("drive.txt", GOOD)), (0, vec![]));
    assert_eq!(found(&[], &files.write("DRIVE.DBC", "")), (0, vec![]));
}

#[test]
fn json_says_where_a_finding_ends() {
    let files = Files::new();
    let path = files.write("a.dbc", GOOD.replace("0|16@1+", "\t0|0@1+"));
    let (_, findings) = found(&[], &path);
    let finding = &findings[0];
    assert_eq!(finding["file"], path.to_str().unwrap());
    assert_eq!((&finding["line"], &finding["column"]), (&4.into(), &15.into()));
    assert_eq!(finding["end"], serde_json::json!({"line": 4, "column": 21}));
    assert!(finding["label"].as_str().unwrap().contains("found 0 bits"));
}
