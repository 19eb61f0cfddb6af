//! `hil-sim check` finds what is wrong with a scenario before it runs.

mod rig;

use rig::Rig;

#[test]
fn shipped_scenarios_are_clean() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios");
    let files: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path().display().to_string()).collect();
    let arguments: Vec<&str> = ["check"].into_iter().chain(files.iter().map(String::as_str)).collect();
    let run = Rig::new().hil_sim(&arguments).expect_status(0);
    assert_eq!(run.stdout, format!("{} files: nothing to complain of\n", files.len()));
}

#[test]
fn what_only_a_scenario_says_is_checked_too() {
    let rig = Rig::new();
    rig.write(
        "mine.toml",
        "base = \"dac-friction\"\nsed = 1\n[bus]\nbitrate_bit_s = 5\n[[expect]]\nsignal = \"speed\"\n",
    );
    let run = rig.hil_sim(&["check", "mine.toml"]).expect_status(1);
    for part in ["mine.toml:2:1", "unknown key `sed`", "did you mean `seed`?", "mine.toml:4:17", "mine.toml:6:10"] {
        assert!(run.stdout.contains(part), "no {part:?} in:\n{}", run.stdout);
    }
}
