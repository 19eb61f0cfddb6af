//! Ctrl-C ends a run at its next period; what was logged until then can be
//! read, and the program says so.

mod rig;

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use rig::{Rig, Run, number, python};

#[test]
fn a_run_that_is_interrupted_leaves_a_log_that_can_be_read() {
    let rig = Rig::new();
    let run = interrupted(&rig, "INT", &["run", "dac-friction"], "runs/run.mcap");
    let run = run.expect_status(130);
    assert!(run.stdout.contains("dac-friction: interrupted"), "{}", run.stdout);
    assert!(run.stdout.contains("the log up to") && run.stdout.contains("can be read"), "{}", run.stdout);
    let summary = rig.summary("runs");
    assert_eq!((&summary["end"], &summary["passed"]), (&"interrupted".into(), &false.into()));
    assert!((0.0..100_000.0).contains(&number(&summary, "/simulated_s")));
    let out = python("interrupted_run.py", &[&rig.path("runs")]);
    assert_eq!(out.trim(), format!("{} messages", number(&summary, "/log/messages")));
}

#[test]
fn an_interrupt_keeps_later_scenarios_from_starting() {
    let rig = Rig::new();
    rig.write("later.toml", "base = \"dac-friction\"\nname = \"later\"\n");
    let run = interrupted(&rig, "TERM", &["run", "dac-friction", "later.toml"], "runs/dac-friction/run.mcap");
    run.expect_status(130);
    assert_eq!(rig::files_in(&rig.path("runs")), ["dac-friction"]);
}

#[test]
fn without_a_log_nothing_is_said_of_one() {
    let rig = Rig::new();
    let run = interrupted(&rig, "INT", &["run", "dac-friction", "--no-log"], "runs").expect_status(130);
    assert!(run.stdout.contains("interrupted") && !run.stdout.contains("log up to"), "{}", run.stdout);
}

/// Starts a run that would take minutes and sends it a signal as soon as it
/// has made `file` and, where that is a log, has filled some of it.
#[allow(clippy::disallowed_methods, reason = "another program is waited for")]
fn interrupted(rig: &Rig, signal: &str, args: &[&str], file: &str) -> Run {
    let mut command = rig.command(args);
    command.args(["--set", "duration_s=1e6"]).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("it starts");
    let started = Instant::now();
    let is_ready = || rig.path(file).metadata().is_ok_and(|found| found.is_dir() || found.len() > 1_000_000);
    while !is_ready() {
        assert!(started.elapsed() < Duration::from_secs(30), "the run makes no log");
        assert_eq!(child.try_wait().expect("it is our child"), None, "the run ended by itself");
        std::thread::sleep(Duration::from_millis(5));
    }
    let sent = Command::new("sh").args(["-c", &format!("kill -{signal} {}", child.id())]).status();
    assert!(sent.expect("there is a shell").success());
    let output = child.wait_with_output().expect("it ends");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    Run { status: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}
