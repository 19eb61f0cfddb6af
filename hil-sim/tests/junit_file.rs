//! `--junit` writes what CI servers read: a suite a scenario, a case an
//! expectation.

mod rig;

use std::path::Path;
use std::process::Command;

use rig::{Rig, finish, python};

#[test]
fn an_independent_reader_finds_every_expectation_as_a_case() {
    let rig = Rig::new();
    let two = "[[expect]]\nname = \"a < b & \\\"c\\\"\"\nsignal = \"position_error_m\"\nmax = 1e-9\n[[expect]]\nstate = \"running\"\nfrom_s = 0.1\n";
    rig.write(
        "one.toml",
        &format!("base = \"dac-friction\"\nname = \"one\"\nduration_s = 0.5\npath.duration_s = 150.0\n{two}"),
    );
    rig.write("none.toml", "base = \"one.toml\"\nname = \"none\"\nseed = 9\nexpect = []\n");
    rig.hil_sim(&["run", "one.toml", "none.toml", "--no-log", "--junit", "junit.xml"]).expect_status(1);
    let out = read_by_others(&rig);
    let lines: Vec<_> = out.lines().collect();
    let [one, failed, held, none, alone] = lines[..] else { panic!("{out}") };
    assert!(
        one.starts_with("suite one tests=2 failures=1 seed=1 hash=")
            && one.ends_with("hil-sim run one.toml --set seed=1")
    );
    assert!(failed.starts_with("case one a < b & \"c\": failed, from 0.0"), "{failed}");
    assert!(
        failed.contains("too high") && failed.ends_with("reproduce: hil-sim run one.toml --set seed=1"),
        "{failed}"
    );
    assert_eq!(held, "case one state is running from 0.1 s to 0.5 s: passed");
    assert!(none.starts_with("suite none tests=1 failures=0 seed=9 hash="), "{none}");
    assert_eq!(alone, "case none the run: passed");
    for (line, folder) in [(one, "runs/one"), (none, "runs/none")] {
        let hash = rig.summary(folder)["frames_blake3"].as_str().expect("a hash").to_owned();
        assert!(line.contains(&format!("hash={hash}")), "{line}");
    }
}

#[test]
fn a_run_that_ends_early_fails_a_case_although_all_it_was_asked_held() {
    let rig = Rig::new();
    let slow =
        ["bus.bitrate_bit_s=10000", "duration_s=20", "expect=[{signal=\"position_error_m\",max=100,until_s=0.1}]"];
    let mut args = vec!["run", "dac-friction", "--no-log", "--junit", "junit.xml"];
    slow.iter().for_each(|set| args.extend(["--set", set]));
    let run = rig.hil_sim(&args).expect_status(1);
    assert!(run.stdout.contains("blocked"), "{}", run.stdout);
    let out = read_by_others(&rig);
    assert!(out.contains("failures=1") && out.contains("the run ended early: blocked"), "{out}");
}

/// What an independent reader finds in `junit.xml`, which holds to the public
/// schema.
fn read_by_others(rig: &Rig) -> String {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts/junit-schema");
    let schema = finish(&mut Command::new(script)).expect_status(0).stdout;
    python("junit_file.py", &[&rig.path("junit.xml"), Path::new(schema.trim())])
}

#[test]
fn a_file_that_cannot_be_written_is_said() {
    let rig = Rig::new();
    let run =
        rig.hil_sim(&["run", "line", "--no-log", "--set", "duration_s=1", "--set", "expect=[]", "--junit", "no/j.xml"]);
    assert!(run.expect_status(2).stderr.contains("cannot write no/j.xml"));
}
