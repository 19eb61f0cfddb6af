//! A command that `scripts/with-vcan` or `scripts/with-can-card` runs in a
//! machine of its own does there what it would have done outside.

#![cfg(target_os = "linux")]

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};

use rustix::process::{Pid, Signal, kill_process};

const MACHINES: [&[&str]; 2] = [&["with-vcan", "--vm"], &["with-can-card"]];

/// The script with its options and the command, and an empty folder for what
/// it makes while it runs.
fn in_machine(machine: &[&str], temporary: &Path, command: &[&str]) -> Command {
    let mut run = Command::new(Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts").join(machine[0]));
    run.args(&machine[1..]).args(command).env("TMPDIR", temporary).env("CANLOOP_VM_TIMEOUT_S", "120");
    run.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    run
}

#[track_caller]
fn assert_empty(folder: &Path) {
    let left: Vec<_> = folder.read_dir().unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(left.is_empty(), "left behind: {left:?}");
}

/// Bytes of every value, without a pattern that a lost block would repeat.
fn noise(bytes: usize) -> Vec<u8> {
    let next = |state: &u32| Some(state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    std::iter::successors(Some(1), next).map(|state| state.to_be_bytes()[0]).take(bytes).collect()
}

#[test]
fn input_output_arguments_environment_folder_and_status_are_those_of_the_command() {
    let script = r#"tee /dev/stderr; printf '%s\n' "$PWD" "$1" "$VARIABLE" >told; exit 7"#;
    for machine in MACHINES {
        let (temporary, place) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let folder = place.path().join("a folder");
        std::fs::create_dir(&folder).unwrap();
        let mut run = in_machine(machine, temporary.path(), &["--", "sh", "-c", script, "sh", "an 'argument'"]);
        let mut run = run.current_dir(&folder).env("VARIABLE", "of $two words").stdin(Stdio::piped()).spawn().unwrap();
        let (mut stdin, sent) = (run.stdin.take().unwrap(), noise(3_000_000));
        let feeder = std::thread::spawn({
            let sent = sent.clone();
            move || stdin.write_all(&sent).unwrap()
        });
        let ended = run.wait_with_output().unwrap();
        assert_eq!(ended.status.code(), Some(7), "{machine:?}: {}", String::from_utf8_lossy(&ended.stderr));
        feeder.join().unwrap();
        assert!(ended.stdout == sent, "{machine:?}: {} bytes of output", ended.stdout.len());
        assert!(ended.stderr == sent, "{machine:?}: {} bytes of errors", ended.stderr.len());
        let told = std::fs::read_to_string(folder.join("told")).unwrap();
        assert_eq!(told, format!("{}\nan 'argument'\nof $two words\n", folder.display()));
        assert_empty(temporary.path());
    }
}

#[test]
fn a_short_input_is_not_lost() {
    for machine in MACHINES {
        let temporary = tempfile::tempdir().unwrap();
        let mut run = in_machine(machine, temporary.path(), &["cat"]).stdin(Stdio::piped()).spawn().unwrap();
        run.stdin.take().unwrap().write_all(b"x").unwrap();
        let ended = run.wait_with_output().unwrap();
        assert_eq!(
            (ended.status.code(), &*ended.stdout, &*ended.stderr),
            (Some(0), &b"x"[..], &b""[..]),
            "{machine:?}"
        );
    }
}

#[test]
fn a_signal_reaches_the_command() {
    let script = "trap 'echo asked to end; exit 9' TERM; echo ready; while :; do sleep 0.1; done";
    for machine in MACHINES {
        let temporary = tempfile::tempdir().unwrap();
        let mut run = in_machine(machine, temporary.path(), &["bash", "-c", script]).spawn().unwrap();
        let mut stdout = BufReader::new(run.stdout.take().unwrap());
        let mut said = String::new();
        stdout.read_line(&mut said).unwrap();
        assert_eq!(said, "ready\n", "{machine:?}");
        kill_process(Pid::from_child(&run), Signal::TERM).unwrap();
        stdout.read_to_string(&mut said).unwrap();
        assert_eq!(said, "ready\nasked to end\n", "{machine:?}");
        assert_eq!(run.wait().unwrap().code(), Some(9), "{machine:?}");
        assert_empty(temporary.path());
    }
}

#[test]
fn a_command_that_does_not_exist_is_said_as_a_shell_would() {
    for machine in MACHINES {
        let temporary = tempfile::tempdir().unwrap();
        let ended = in_machine(machine, temporary.path(), &["no-such-command"]).output().unwrap();
        let said = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(127), "{machine:?}: {said}");
        assert!(said.contains("no-such-command"), "{machine:?}: {said}");
    }
}

#[test]
fn wrong_use_is_refused_before_a_machine_starts() {
    for machine in MACHINES {
        for (args, words) in [(&["--"][..], "no command given"), (&["--speed", "1", "true"], "unknown option --speed")]
        {
            let temporary = tempfile::tempdir().unwrap();
            let ended = in_machine(machine, temporary.path(), args).output().unwrap();
            let said = String::from_utf8_lossy(&ended.stderr);
            assert_eq!(ended.status.code(), Some(2), "{machine:?}: {said}");
            assert!(said.contains(machine[0]) && said.contains(words), "{machine:?}: {said}");
        }
        let temporary = tempfile::tempdir().unwrap();
        let ended = in_machine(machine, temporary.path(), &["true"]).env("CANLOOP_VM_TIMEOUT_S", "soon").output();
        let ended = ended.unwrap();
        let said = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(2), "{machine:?}: {said}");
        assert!(said.contains("CANLOOP_VM_TIMEOUT_S") && said.contains("soon"), "{machine:?}: {said}");
    }
}
