//! README.md shows two programs on a bus: its lines, typed as they stand in an
//! empty folder, do what it says.

use std::path::Path;
use std::process::Command;

use crate::two_programs::{Bench, canloop, free_port};

const README: &str = include_str!("../../../README.md");

/// The lines of the first example below this heading.
fn example(heading: &str) -> Vec<&'static str> {
    let (_, section) = README.split_once(heading).expect("README.md has the heading");
    let block = section.split("```sh\n").nth(1).and_then(|rest| rest.split("```").next());
    block.expect("an example below it").lines().collect()
}

/// A line as a shell runs it that finds both programs.
fn shell(line: &str) -> Command {
    let programs = canloop().parent().map(Path::to_owned).expect("programs are in a folder");
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap_or_default());
    let mut command = Command::new("sh");
    command.args(["-c", line]).env("PATH", path);
    command
}

#[test]
fn the_two_terminals_of_the_readme_work_in_an_empty_folder() {
    let port = free_port().to_string();
    let lines = example("\n## Over a real bus\n");
    let lines: Vec<String> = lines.iter().map(|line| line.replace("29536", &port)).collect();
    let [write, serve, drive] = lines.as_slice() else { panic!("other lines: {lines:?}") };
    let bench = Bench::over_tcp();
    bench.start("write", &mut shell(write)).finish().expect_status(0);
    let mut served = bench.start("serve", &mut shell(&format!("exec {serve} --set duration_s=5")));
    served.wait_until("it serves", |serve| serve.told().contains("serving"));
    let drive = bench.start("drive", &mut shell(&format!("exec {drive}"))).finish().expect_status(0);
    assert!(drive.stdout.contains("the other side ended the run"), "{}", drive.stdout);
    served.finish().expect_status(0);
    assert!(bench.rig.path("drive.mcap").is_file());
}
