//! The program as a user has it: the real binary in a fresh folder.

#![allow(dead_code, reason = "every test file uses a part of it")]

pub mod builds;
pub mod drives;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// A folder of its own in which `hil-sim` runs.
pub struct Rig {
    folder: TempDir,
}

/// How a command ended and what it said.
pub struct Run {
    pub status: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Rig {
    /// An empty folder.
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a folder for the test") }
    }

    /// A path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file into the folder.
    pub fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().expect("it is in the folder")).expect("the folder is writable");
        std::fs::write(path, text).expect("the folder is writable");
    }

    /// A command line of the program, not yet started.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hil-sim"));
        command.args(args).current_dir(self.folder.path()).stdin(Stdio::null());
        command
    }

    /// Runs the program to its end.
    pub fn hil_sim(&self, args: &[&str]) -> Run {
        finish(&mut self.command(args))
    }

    /// Runs a scenario with overrides and without log and page.
    pub fn run(&self, scenario: &str, overrides: &[&str]) -> Run {
        let mut args = vec!["run", scenario, "--no-log", "--no-report"];
        overrides.iter().for_each(|set| args.extend(["--set", set]));
        self.hil_sim(&args)
    }

    /// The figures of the run in `folder`.
    pub fn summary(&self, folder: &str) -> Value {
        read_json(&self.path(folder).join("summary.json"))
    }

    /// Names of what is in the folder, in order.
    pub fn files(&self) -> Vec<String> {
        files_in(self.folder.path())
    }
}

impl Run {
    /// The run, if it ended with this status; else the test ends here.
    #[track_caller]
    pub fn expect_status(self, status: i32) -> Self {
        assert_eq!(self.status, Some(status), "stdout:\n{}\nstderr:\n{}", self.stdout, self.stderr);
        self
    }
}

/// The figures of a run of `dac-friction` with these overrides, whether its
/// expectations held or not.
#[track_caller]
pub fn figures(overrides: &[&str]) -> Value {
    let rig = Rig::new();
    let run = rig.run("dac-friction", overrides);
    assert!(matches!(run.status, Some(0 | 1)), "{overrides:?} ended with {:?}:\n{}", run.status, run.stderr);
    rig.summary("runs")
}

/// A number of a summary, by its path.
#[track_caller]
pub fn number(summary: &Value, pointer: &str) -> f64 {
    let found = summary.pointer(pointer);
    found.and_then(Value::as_f64).unwrap_or_else(|| panic!("{pointer} should be a number and is {found:?}"))
}

/// All findings of a run as one text.
pub fn findings(summary: &Value) -> String {
    let lines = summary["findings"].as_array().expect("a list of findings");
    lines.iter().map(|line| line.as_str().expect("a sentence")).collect::<Vec<_>>().join("\n")
}

/// Runs a command to its end.
pub fn finish(command: &mut Command) -> Run {
    let output = command.output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    Run { status: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

/// Runs a Python script of this folder with the independent readers.
#[track_caller]
pub fn python(script: &str, args: &[&Path]) -> String {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let runner = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts/python");
    let run = finish(Command::new(runner).arg(tests.join(script)).args(args)).expect_status(0);
    run.stdout
}

/// Names of what is in a folder, in order.
pub fn files_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let name = |entry: std::io::Result<std::fs::DirEntry>| entry.expect("an entry").file_name();
    let mut names: Vec<_> = entries.map(|entry| name(entry).to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A JSON file.
#[track_caller]
pub fn read_json(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).expect("JSON")
}
