//! A campaign tries every fault at every moment in every size, finds what
//! violates what must hold, and says how to see it again.

mod rig;

use std::process::Command;

use rig::{Rig, finish};

/// A campaign of four runs.
const SMALL: &str = "name = \"small\"\nscenarios = [\"dac-friction\"]\nset = [\"path.duration_s=40\"]\n\
    duration_s = 6\nmoments_s = [1.0, 2.0]\n\
    [[fault]]\nkind = \"drop\"\nmessage = \"RightFeedback\"\nprobability = [0.0, 1.0]\n";

#[test]
fn nothing_that_goes_wrong_in_the_campaign_that_ships_violates_what_must_hold() {
    let run = Rig::new().hil_sim(&["campaign"]).expect_status(0);
    assert!(run.stdout.contains("in all") && !run.stdout.contains("violated:"), "{}", run.stdout);
}

#[test]
fn each_kind_has_a_row_of_what_became_of_its_runs() {
    let rig = Rig::new();
    rig.write("small.toml", SMALL);
    let run = rig.hil_sim(&["campaign", "small.toml"]).expect_status(0);
    let rows: Vec<Vec<&str>> = run.stdout.lines().map(|line| line.split_whitespace().collect()).collect();
    assert!(rows.contains(&vec!["drop", "2", "2", "0"]), "{}", run.stdout);
    assert!(run.stdout.contains("4 runs in "), "{}", run.stdout);
}

#[test]
fn what_is_violated_is_told_with_the_command_that_runs_it_again() {
    let rig = Rig::new();
    // Nothing keeps to its path to a micrometre.
    rig.write("strict.toml", &format!("{SMALL}[invariants]\nundetected_m = 1e-6\n"));
    let run = rig.hil_sim(&["campaign", "strict.toml"]).expect_status(1);
    let command = run.stdout.lines().find(|line| line.trim_start().starts_with("hil-sim run ")).expect(&run.stdout);
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_hil-sim"));
    let folder = program.parent().expect("it is in a folder").display();
    let again = finish(
        Command::new("sh")
            .args(["-c", &format!("PATH='{folder}':$PATH; {command} --no-log")])
            .current_dir(rig.path("")),
    );
    again.expect_status(0);
    assert_eq!(rig.summary("runs")["simulated_s"], 6.0);
}

#[test]
fn the_results_do_not_depend_on_the_number_of_threads() {
    let rig = Rig::new();
    rig.write("strict.toml", &format!("{SMALL}[invariants]\nundetected_m = 1e-6\n"));
    let told = |threads: &str| {
        let run = rig.hil_sim(&["campaign", "strict.toml", "--threads", threads]).expect_status(1);
        run.stdout.lines().filter(|line| !line.contains(" runs in ")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(told("1"), told("3"));
}

#[test]
fn a_campaign_of_one_s_own_begins_with_the_one_that_ships() {
    let rig = Rig::new();
    let printed = rig.hil_sim(&["campaign", "--print"]).expect_status(0).stdout;
    assert_eq!(printed.trim_end(), include_str!("../campaigns/faults.toml").trim_end());
}

#[test]
fn what_is_wrong_with_a_campaign_is_said() {
    let cases = [
        ("nothing = 1\n".to_owned(), "`nothing`"),
        (SMALL.replace("\"drop\"", "\"explode\""), "expected one of \"stop\""),
        (SMALL.replace("RightFeedback", "RightFeedbak"), "did you mean `RightFeedback`?"),
        (SMALL.replace("kind = \"drop\"", ""), "kind"),
        (SMALL.replace("[1.0, 2.0]", "[]"), "found no moment"),
        (SMALL.replace("[\"dac-friction\"]", "[]"), "found 0 runs"),
        (SMALL.replace("path.duration_s=40", "path.duration_s=-1"), "path.duration_s"),
    ];
    for (text, says) in cases {
        let rig = Rig::new();
        rig.write("bad.toml", &text);
        let run = rig.hil_sim(&["campaign", "bad.toml"]).expect_status(2);
        assert!(run.stderr.contains(says), "{text}\n{}", run.stderr);
    }
    Rig::new().hil_sim(&["campaign", "no-such-campaign"]).expect_status(2);
}
