//! The program's commands, and how they end.

pub mod campaign;
pub mod check;
pub mod map;
pub mod merge;
pub mod paper;
pub mod plant;
pub mod run;
pub mod scenario;
pub mod serve;
pub mod sweep;

mod conclusion;
mod interrupt;
mod pace;
mod progress;

use std::fmt::Display;
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use canloop::config::{Problem, Problems};

/// Why a command could not do its work.
#[derive(Debug)]
pub enum Failure {
    /// What it was given will not do.
    BadInput(Problems),
    /// Something it wrote to or read from failed half-way.
    Broken(String),
}

/// Every expectation held.
pub const HELD: u8 = 0;
/// An expectation did not hold.
pub const FAILED: u8 = 1;
/// The input was bad, or the output could not be written.
pub const BAD_INPUT: u8 = 2;
/// Ended by Ctrl-C, as shells count it.
pub const INTERRUPTED: u8 = 130;

impl Failure {
    /// Says what is wrong on standard error.
    pub fn report(&self) -> ExitCode {
        match self {
            Self::BadInput(problems) => eprintln!("{problems}"),
            Self::Broken(text) => eprintln!("error: {text}"),
        }
        ExitCode::from(BAD_INPUT)
    }
}

impl From<Problems> for Failure {
    fn from(problems: Problems) -> Self {
        Self::BadInput(problems)
    }
}

impl From<Problem> for Failure {
    fn from(problem: Problem) -> Self {
        Self::BadInput(problem.into())
    }
}

/// Prints a line, unless nobody reads any more: files are written all the
/// same, so a closed pipe is no reason to stop.
fn say(line: impl Display) {
    let _ = writeln!(std::io::stdout(), "{line}");
}

fn create_folder(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| {
        let problem = Problem::bare(format!("cannot create the folder {}: {error}", folder.display()));
        problem.help("choose another one with --out").into()
    })
}

fn write_file(path: &Path, contents: &str) -> Result<(), Failure> {
    std::fs::write(path, contents).map_err(|error| Failure::Broken(format!("cannot write {}: {error}", path.display())))
}
