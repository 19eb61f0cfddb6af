//! The rows of a sweep are there as Parquet too, for readers that others wrote:
//! the same ones, in columns of their types, and never half of them.

mod rig;

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use rig::{Rig, Run, python};

/// Some of its runs are refused: there is no negative mass.
const PLAN: &str = "name = \"small\"\nscenario = \"dac-friction\"\nset = [\"duration_s=0.5\", \"expect=[]\"]\nseeds = 2\n\
    [[vary]]\nkey = \"controller.law\"\nvalues = [\"dac-matched\", \"dac\"]\n\
    [[vary]]\nkey = \"robot.load.mass_kg\"\nvalues = [80, -1]\n\
    [[vary]]\nkey = \"period_s\"\nfrom = 0.005\nto = 0.01\ncount = 2\n";
/// What pyarrow is to find in the columns of the keys.
const KEYS: [&str; 3] = ["controller.law=string", "robot.load.mass_kg=int64", "period_s=double"];

/// Everything that a reader of its own finds in a Parquet file is in the CSV
/// file; says how many rows and how many refused runs there are.
#[track_caller]
fn compared(rig: &Rig, csv: &str, parquet: &str, plan: &str, keys: &[&str]) -> String {
    rig.write("plan-text.toml", plan);
    let paths = [rig.path(csv), rig.path(parquet), rig.path("plan-text.toml")];
    let keys = keys.iter().map(std::path::Path::new);
    python("sweep_in_parquet.py", &paths.iter().map(AsRef::as_ref).chain(keys).collect::<Vec<_>>()).trim().to_owned()
}

/// What a plan says, without the line that tells the part.
fn plan_in(rig: &Rig, folder: &str) -> String {
    let text = std::fs::read_to_string(rig.path(folder).join("plan.toml")).expect("a plan");
    text.split_once('\n').expect("a line and a plan").1.to_owned()
}

fn planned() -> Rig {
    let rig = Rig::new();
    rig.write("small.toml", PLAN);
    rig
}

#[test]
fn an_independent_reader_finds_each_row_with_its_types_and_nulls() {
    let rig = planned();
    let run = rig.hil_sim(&["sweep", "small.toml"]).expect_status(0);
    assert!(run.stdout.contains("sweeps/small/results.parquet"), "{}", run.stdout);
    assert_eq!(rig::files_in(&rig.path("sweeps/small")), ["plan.toml", "results.csv", "results.parquet"]);
    let plan = plan_in(&rig, "sweeps/small");
    let found = compared(&rig, "sweeps/small/results.csv", "sweeps/small/results.parquet", &plan, &KEYS);
    assert_eq!(found, "16 rows, 8 refused");
}

#[test]
fn the_same_rows_are_the_same_bytes() {
    let rig = planned();
    rig.hil_sim(&["sweep", "small.toml"]).expect_status(0);
    let first = std::fs::read(rig.path("sweeps/small/results.parquet")).expect("a file");
    // As a kill leaves it, in the middle of a line.
    let rows = std::fs::read(rig.path("sweeps/small/results.csv")).expect("a file");
    std::fs::write(rig.path("sweeps/small/results.csv"), &rows[..rows.len() / 2]).expect("writable");
    rig.hil_sim(&["sweep", "small.toml"]).expect_status(0);
    assert!(std::fs::read(rig.path("sweeps/small/results.parquet")).expect("a file") == first);
}

#[test]
fn merged_parts_are_there_in_both_forms_or_in_the_one_that_is_asked_for() {
    let rig = planned();
    for shard in ["1/3", "2/3", "3/3"] {
        rig.hil_sim(&["sweep", "small.toml", "--shard", shard]).expect_status(0);
    }
    let parts = ["sweeps/small-2-of-3", "sweeps/small-3-of-3", "sweeps/small-1-of-3"];
    let merge = |output| rig.hil_sim(&[&["merge"][..], &parts, &["-o", output]].concat()).expect_status(0);
    merge("all.csv");
    merge("alone.parquet");
    assert_eq!(rig.files(), ["all.csv", "all.parquet", "alone.parquet", "small.toml", "sweeps"]);
    let plan = plan_in(&rig, parts[0]);
    for parquet in ["all.parquet", "alone.parquet"] {
        assert_eq!(compared(&rig, "all.csv", parquet, &plan, &KEYS), "16 rows, 8 refused");
    }
}

#[test]
fn a_row_that_a_kill_left_unfinished_is_missing_in_the_whole() {
    let rig = planned();
    rig.hil_sim(&["sweep", "small.toml"]).expect_status(0);
    let rows = std::fs::read_to_string(rig.path("sweeps/small/results.csv")).expect("a file");
    rig.write("sweeps/small/results.csv", &rows[..rows.len() - 1]);
    let run = rig.hil_sim(&["merge", "sweeps/small", "-o", "all.csv"]).expect_status(1);
    assert!(run.stdout.contains("15 runs") && run.stdout.contains("missing: run 15\n"), "{}", run.stdout);
    let plan = plan_in(&rig, "sweeps/small");
    assert_eq!(compared(&rig, "all.csv", "all.parquet", &plan, &KEYS), "15 rows, 7 refused");
}

#[test]
fn a_sweep_that_is_ended_leaves_the_rows_that_are_done() {
    let rig = planned();
    rig.write("long.toml", &PLAN.replace("\"small\"", "\"long\"").replace("seeds = 2", "seeds = 1000000"));
    let run = ended(&rig, &["sweep", "long.toml"], "sweeps/long/results.csv").expect_status(130);
    assert!(run.stdout.contains("the same command goes on with it"), "{}", run.stdout);
    let plan = plan_in(&rig, "sweeps/long");
    let found = compared(&rig, "sweeps/long/results.csv", "sweeps/long/results.parquet", &plan, &KEYS);
    assert!(found.ends_with("refused") && !found.starts_with("0 rows"), "{found}");
}

#[test]
fn a_full_disk_is_said_and_what_was_there_is_kept() {
    let rig = Rig::new();
    // A plan that finds no room makes a table that carries it find none, and the rows do.
    rig.write("small.toml", &PLAN.replace("\"small\"", &format!("\"{}\"", "s".repeat(100_000))));
    let sweep = ["sweep", "small.toml", "--out", "rows"];
    rig.hil_sim(&sweep).expect_status(0);
    let run = limited(&rig, &sweep).expect_status(2);
    assert!(run.stderr.contains("cannot write rows/results.parquet: File too large"), "{}", run.stderr);
    assert!(run.stderr.contains("rows/results.csv has all rows"), "{}", run.stderr);
    assert_eq!(rig::files_in(&rig.path("rows")), ["plan.toml", "results.csv"]);
    let run = limited(&rig, &["merge", "rows", "-o", "all.csv"]).expect_status(2);
    assert!(run.stderr.contains("cannot write all.parquet: File too large"), "{}", run.stderr);
    assert!(run.stderr.contains("all.csv has all rows"), "{}", run.stderr);
    assert_eq!(rig.files(), ["all.csv", "rows", "small.toml"]);
    rig.hil_sim(&sweep).expect_status(0);
    let plan = plan_in(&rig, "rows");
    assert_eq!(compared(&rig, "all.csv", "rows/results.parquet", &plan, &KEYS), "16 rows, 8 refused");
}

#[test]
fn results_of_another_version_are_said_to_be_of_one() {
    let rig = planned();
    rig.hil_sim(&["sweep", "small.toml"]).expect_status(0);
    let rows = std::fs::read_to_string(rig.path("sweeps/small/results.csv")).expect("a file");
    rig.write("sweeps/small/results.csv", &rows.replacen("bus.lost", "bus.mislaid", 1));
    let run = rig.hil_sim(&["sweep", "small.toml"]).expect_status(2);
    assert!(run.stderr.contains("bus.mislaid") && run.stderr.contains("another version"), "{}", run.stderr);
    rig.write("sweeps/small/results.csv", &rows.replacen(",finished,true,", ",finished,maybe,", 1));
    let run = rig.hil_sim(&["sweep", "small.toml"]).expect_status(2);
    let says = "run 0: found \"maybe\" in the column passed, expected true or false";
    assert!(run.stderr.contains(says), "{}", run.stderr);
    assert!(!rig.path("sweeps/small/results.parquet").exists());
}

/// Runs the program where no file may be longer than 80 blocks of 1 KiB or 512
/// bytes: a full disk that needs no rights.
fn limited(rig: &Rig, args: &[&str]) -> Run {
    let script = "trap '' XFSZ; ulimit -f 80; exec \"$0\" \"$@\"";
    let mut command = Command::new("sh");
    command.args(["-c", script, env!("CARGO_BIN_EXE_hil-sim")]).args(args);
    rig::finish(command.current_dir(rig.path(".")).stdin(Stdio::null()))
}

/// Starts a sweep that would take hours and ends it as Ctrl-C does, once some
/// rows are there.
#[allow(clippy::disallowed_methods, reason = "another program is waited for")]
fn ended(rig: &Rig, args: &[&str], file: &str) -> Run {
    let mut child = rig.command(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    let started = Instant::now();
    while !rig.path(file).metadata().is_ok_and(|found| found.len() > 10_000) {
        assert!(started.elapsed() < Duration::from_secs(60), "the sweep makes no rows");
        assert_eq!(child.try_wait().expect("it is our child"), None, "the sweep ended by itself");
        std::thread::sleep(Duration::from_millis(5));
    }
    let sent = Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status();
    assert!(sent.expect("there is a shell").success());
    let output = child.wait_with_output().expect("it ends");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    Run { status: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}
