//! A log that breaks off, or was damaged, is made one that ordinary readers
//! open, with all that is whole of it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use canloop::event::{Event, Sink, Tick};
use canloop::log::{LogContents, McapLog, WhenFull};
use canloop::time::Instant;

/// Messages in a chunk: those of a second, and the one that ends it.
const CHUNK: u64 = 201;

/// A log of ten seconds, a chunk a second, in a folder of its own.
fn logged() -> (tempfile::TempDir, PathBuf, Vec<u8>) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.mcap");
    let attachments = vec![("robot.toml".to_owned(), "application/toml".to_owned(), b"period_s = 0.005".to_vec())];
    let contents = LogContents { attachments, ..LogContents::default() };
    let mut log = McapLog::create(&path, &contents, WhenFull::Wait).expect("the log begins");
    for tick in 0..2000 {
        let at = Instant::from_nanos(tick as i64 * 5_000_000);
        let torque_nm = libm::sin(tick as f64 * 0.01);
        let torque_wanted_nm = canloop::wheels::Wheels::both(torque_nm);
        log.event(at, &Event::Tick(Tick { tick, torque_wanted_nm, ..Tick::default() }));
    }
    log.finish().expect("the log ends");
    let bytes = std::fs::read(&path).expect("the log");
    (folder, path, bytes)
}

fn canloop_repair(args: &[&Path]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_canloop")).arg("repair").args(args).output().expect("the program")
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// What the `mcap` package from PyPI finds in a log: messages and attachments.
fn found_by_others(path: &Path) -> (u64, u64) {
    let script = "import sys\nfrom mcap.reader import make_reader\n\
        reader = make_reader(open(sys.argv[1], 'rb'), validate_crcs=True)\n\
        summary = reader.get_summary()\n\
        messages = sum(1 for _ in reader.iter_messages())\n\
        assert messages == summary.statistics.message_count\n\
        print(messages, sum(1 for _ in reader.iter_attachments()))";
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/python");
    let output = Command::new(python).args(["-c", script]).arg(path).output().expect("Python");
    assert!(output.status.success(), "{}", told(&output));
    let counts = String::from_utf8_lossy(&output.stdout);
    let (messages, attachments) = counts.trim().split_once(' ').expect("two numbers");
    (messages.parse().expect("a number"), attachments.parse().expect("a number"))
}

#[test]
fn a_log_that_breaks_off_anywhere_keeps_its_whole_chunks() {
    let (folder, path, bytes) = logged();
    let mut most = 0;
    for tenths in 1..10 {
        std::fs::write(&path, &bytes[..bytes.len() * tenths / 10]).expect("writable");
        let output = canloop_repair(&[&path]);
        assert!(output.status.success(), "{}", told(&output));
        assert!(told(&output).contains("of a chunk that was never finished"), "{}", told(&output));
        let (messages, attachments) = found_by_others(&folder.path().join("run.repaired.mcap"));
        assert_eq!((messages % CHUNK, attachments), (0, 1), "whole chunks");
        assert!(messages >= most, "more of the file has more of its messages");
        most = messages;
    }
    assert!(most >= 7 * CHUNK, "{most}");
}

#[test]
fn a_damaged_chunk_is_left_out_and_the_rest_is_kept() {
    let (_folder, path, mut bytes) = logged();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0xFF;
    std::fs::write(&path, &bytes).expect("writable");
    let output = canloop_repair(&[Path::new("--in-place"), &path]);
    assert!(output.status.success(), "{}", told(&output));
    assert!(told(&output).contains("a part that is damaged, at byte "), "{}", told(&output));
    assert_eq!(found_by_others(&path), (2000 - CHUNK, 1), "one chunk of ten");
}

#[test]
fn a_whole_log_is_left_as_it_is() {
    let (folder, path, bytes) = logged();
    let output = canloop_repair(&[&path]);
    assert!(output.status.success() && told(&output).contains("2000 messages; there is nothing to repair"));
    assert_eq!(std::fs::read(&path).expect("the log"), bytes);
    assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 1);
}

#[test]
fn what_is_no_log_is_refused_and_nothing_is_written() {
    let (folder, path, _) = logged();
    let text = folder.path().join("text.mcap");
    std::fs::write(&text, "(0.0) can0 123#00\n").expect("writable");
    for (args, says) in [
        (vec![text.as_path()], "cannot be read as an MCAP file"),
        (vec![Path::new("/nowhere/run.mcap")], "cannot read /nowhere/run.mcap"),
    ] {
        let output = canloop_repair(&args);
        assert!(output.status.code() == Some(2) && told(&output).contains(says), "{}", told(&output));
    }
    std::fs::write(&path, b"\x89MCAP0\r\n").expect("writable");
    let output = canloop_repair(&[&path, Path::new("-o"), &path]);
    assert!(output.status.code() == Some(2) && told(&output).contains("its own copy"), "{}", told(&output));
}
