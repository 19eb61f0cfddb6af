//! A sweep runs each case once, however it is cut up or broken off, and its rows
//! are the same.

mod rig;

use std::collections::BTreeMap;

use rig::{Rig, Run};

const PLAN: &str = "name = \"small\"\nscenario = \"dac-friction\"\nset = [\"duration_s=0.5\", \"expect=[]\"]\nseeds = 2\n\
    [[vary]]\nkey = \"period_s\"\nvalues = [0.005, 0.01]\n\
    [[vary]]\nkey = \"robot.load.mass_kg\"\nfrom = 0\nto = 160\ncount = 3\n";

fn sweep(rig: &Rig, args: &[&str]) -> Run {
    rig.hil_sim(&[&["sweep", "small.toml"], args].concat())
}

fn text(rig: &Rig, path: &str) -> String {
    std::fs::read_to_string(rig.path(path)).expect("a file")
}

/// The whole, run at once.
fn whole() -> (Rig, String) {
    let rig = Rig::new();
    rig.write("small.toml", PLAN);
    sweep(&rig, &[]).expect_status(0);
    let results = text(&rig, "sweeps/small/results.csv");
    (rig, results)
}

#[test]
fn each_case_has_a_row_with_what_was_varied_and_its_figures() {
    let (_, results) = whole();
    let mut lines = results.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    assert!(header.starts_with(&["run", "period_s", "robot.load.mass_kg", "seed", "outcome"]), "{header:?}");
    let rows: Vec<BTreeMap<&str, &str>> =
        lines.map(|line| header.iter().copied().zip(line.split(',')).collect()).collect();
    assert_eq!(rows.len(), 12);
    assert_eq!((rows[7]["period_s"], rows[7]["robot.load.mass_kg"], rows[7]["seed"]), ("0.01", "0.0", "2"));
    assert!(rows.iter().all(|row| row["outcome"] == "finished" && row["frames_blake3"].len() == 64));
    assert!(rows.iter().all(|row| row["torque.max_nm"].parse::<f64>().is_ok_and(|torque| torque > 0.0)));
    // A row is what the scenario itself gives.
    let rig = Rig::new();
    rig.run("dac-friction", &["duration_s=0.5", "expect=[]", "period_s=0.01", "robot.load.mass_kg=0.0", "seed=2"]);
    assert_eq!(rig.summary("runs")["frames_blake3"], rows[7]["frames_blake3"]);
}

#[test]
fn a_sweep_that_was_broken_off_goes_on_where_it_was() {
    let (rig, whole) = whole();
    // In the middle of a line, as a kill leaves it.
    std::fs::write(rig.path("sweeps/small/results.csv"), &whole[..whole.len() * 2 / 3]).expect("writable");
    let run = sweep(&rig, &[]).expect_status(0);
    assert!(run.stdout.contains(" of 12 runs were done before"), "{}", run.stdout);
    assert_eq!(text(&rig, "sweeps/small/results.csv"), whole);
    let run = sweep(&rig, &[]).expect_status(0);
    assert!(run.stdout.contains("12 of 12 runs were done before"), "{}", run.stdout);
}

#[test]
fn parts_in_any_order_make_the_whole() {
    let (_, whole) = whole();
    let rig = Rig::new();
    rig.write("small.toml", PLAN);
    for shard in ["3/3", "1/3", "2/3"] {
        sweep(&rig, &["--shard", shard, "--threads", "3"]).expect_status(0);
    }
    let parts = ["sweeps/small-2-of-3", "sweeps/small-3-of-3", "sweeps/small-1-of-3"];
    let run = rig.hil_sim(&[["merge"].as_slice(), &parts, &["-o", "all.csv"]].concat()).expect_status(0);
    assert!(run.stdout.contains("12 runs, 0 of them several times"), "{}", run.stdout);
    assert_eq!(text(&rig, "all.csv"), whole);
    let twice = [["merge"].as_slice(), &parts, &[parts[0], "-o", "all.csv"]].concat();
    assert!(rig.hil_sim(&twice).expect_status(0).stdout.contains("12 runs, 4 of them several times"));
    assert_eq!(text(&rig, "all.csv"), whole);
    let run = rig.hil_sim(&["merge", parts[0], parts[2], "-o", "some.csv"]).expect_status(1);
    assert!(run.stdout.contains("missing: run 2\nmissing: run 5\n"), "{}", run.stdout);
}

#[test]
fn an_engine_s_variables_choose_the_part() {
    let rig = Rig::new();
    rig.write("small.toml", PLAN);
    let mut command = rig.command(&["sweep", "small.toml"]);
    let run = rig::finish(command.envs([("JOB_COMPLETION_INDEX", "1"), ("JOB_COMPLETIONS", "4")])).expect_status(0);
    assert!(run.stdout.contains("sweeps/small-2-of-4/results.csv"), "{}", run.stdout);
    let mut command = rig.command(&["sweep", "small.toml"]);
    let run = rig::finish(command.env("CI_NODE_INDEX", "9").env("CI_NODE_TOTAL", "4")).expect_status(2);
    assert!(run.stderr.contains("CI_NODE_INDEX=9"), "{}", run.stderr);
}

#[test]
fn a_run_that_will_not_do_is_a_row_and_no_end() {
    let rig = Rig::new();
    rig.write("small.toml", &PLAN.replace("from = 0\nto = 160\ncount = 3", "values = [80, -1]"));
    sweep(&rig, &[]).expect_status(0);
    let results = text(&rig, "sweeps/small/results.csv");
    assert_eq!(results.lines().filter(|line| line.contains(",refused,")).count(), 4, "{results}");
    assert_eq!(results.lines().filter(|line| line.contains(",finished,")).count(), 4, "{results}");
}

#[test]
fn what_is_wrong_with_a_sweep_is_said_before_anything_is_run() {
    let cases: [(String, &[&str], &str); 10] = [
        (PLAN.replace("period_s\"", "perriod_s\""), &[], "perriod_s"),
        (PLAN.replace("to = 160", "to = 0"), &[], "found an empty range"),
        (PLAN.replace("count = 3", "count = 1"), &[], "count"),
        (PLAN.replace("values = [0.005, 0.01]", "values = []"), &[], "found no value"),
        (PLAN.replace("values = [0.005, 0.01]", "uniform = [0.005, 0.01]"), &[], "may be any number, on a grid"),
        (PLAN.replace("values = [0.005, 0.01]", "nothing = 1"), &[], "expected one of values"),
        (PLAN.replace("robot.load.mass_kg", "seed"), &[], "expected `seeds = N`"),
        (PLAN.replace("robot.load.mass_kg", "period_s"), &[], "found `period_s` a second time"),
        (PLAN.to_owned(), &["--shard", "0/4"], "expected I/N"),
        (PLAN.to_owned(), &["--shard", "5/4"], "expected I/N"),
    ];
    for (plan, args, says) in cases {
        let rig = Rig::new();
        rig.write("small.toml", &plan);
        let run = sweep(&rig, args).expect_status(2);
        assert!(run.stderr.contains(says), "{says}: {}", run.stderr);
        assert!(!rig.path("sweeps").exists(), "{says}");
    }
}

#[test]
fn results_of_another_plan_are_left_alone() {
    let (rig, whole) = whole();
    rig.write("small.toml", &PLAN.replace("seeds = 2", "seeds = 3"));
    let run = sweep(&rig, &[]).expect_status(2);
    assert!(run.stderr.contains("results of another plan"), "{}", run.stderr);
    assert_eq!(text(&rig, "sweeps/small/results.csv"), whole);
    sweep(&rig, &["--out", "other"]).expect_status(0);
    let run = rig.hil_sim(&["merge", "other", "sweeps/small", "-o", "all.csv"]).expect_status(2);
    assert!(run.stderr.contains("are of different plans"), "{}", run.stderr);
}

#[test]
fn a_plan_says_what_is_drawn_of_it() {
    let rig = Rig::new();
    let map = "[[map]]\ntitle = \"how far\"\nx = \"period_s\"\ny = \"robot.load.mass_kg\"\npanels = \"seed\"\n";
    rig.write("small.toml", &format!("{PLAN}{map}"));
    sweep(&rig, &[]).expect_status(0);
    let svg = text(&rig, "sweeps/small/map.svg");
    let drawn = roxmltree::Document::parse(&svg).expect("well-formed");
    let cells = drawn.descendants().filter(|node| node.has_tag_name("title")).count() - 1;
    assert_eq!(cells, 12, "two periods, three loads, a panel for each seed");
    assert!(svg.contains("seed = 1") && svg.contains("seed = 2") && svg.contains("how far"));
    assert!(text(&rig, "sweeps/small/report.html").contains("12 runs of dac-friction"));
    std::fs::remove_file(rig.path("sweeps/small/map.svg")).expect("a picture");
    rig.hil_sim(&["map", "sweeps/small"]).expect_status(0);
    assert_eq!(text(&rig, "sweeps/small/map.svg"), svg, "the same, drawn later");
    let few: Vec<String> = text(&rig, "sweeps/small/results.csv").lines().take(3).map(str::to_owned).collect();
    rig.write("sweeps/small/few.csv", &format!("{}\n", few.join("\n")));
    rig.hil_sim(&["map", "sweeps/small/few.csv"]).expect_status(0);
    assert!(text(&rig, "sweeps/small/report.html").contains("2 runs of dac-friction"), "the file that was named");
    rig.write("small.toml", &format!("{PLAN}{}", map.replace("\"period_s\"", "\"period\"")));
    let run = sweep(&rig, &["--out", "other"]).expect_status(2);
    assert!(run.stderr.contains("did you mean period_s?"), "{}", run.stderr);
}
