//! What can be expected of a run: each kind of `[[expect]]` holds where it
//! should, fails where it should, and says when and by how much.

mod rig;

use rig::Rig;
use serde_json::Value;

/// Five seconds of the paper's circle. The faster wheel passes 0.3 rad/s at
/// 3.8 s, which trips the stack.
const TRIPS: &str = r#"
base = "dac-friction"
name = "trips"
duration_s = 5.0
path.duration_s = 150.0
safety.wheel_speed_limit_rad_s = 0.3
"#;

/// The verdicts of a run that trips at 3.8 s on these expectations.
#[track_caller]
fn verdicts(expectations: &str) -> Vec<Value> {
    let rig = Rig::new();
    rig.write("trips.toml", &format!("{TRIPS}{expectations}"));
    let run = rig.run("trips.toml", &[]);
    assert!(matches!(run.status, Some(0 | 1)), "{}", run.stderr);
    rig.summary("runs")["expectations"].as_array().expect("a list").clone()
}

/// Whether one expectation holds, and what came of it.
#[track_caller]
fn judged(keys: &str) -> (bool, String) {
    let verdicts = verdicts(&format!("[[expect]]\n{keys}\n"));
    assert_eq!(verdicts.len(), 1, "{keys}");
    (verdicts[0]["passed"] == true, verdicts[0]["result"].as_str().expect("a sentence").to_owned())
}

#[track_caller]
fn holds(keys: &str) {
    let (passed, result) = judged(keys);
    assert!(passed, "{keys}\n{result}");
}

#[track_caller]
fn fails(keys: &str, words: &[&str]) {
    let (passed, result) = judged(keys);
    assert!(!passed, "{keys}\n{result}");
    words.iter().for_each(|words| assert!(result.contains(words), "{words} is not in: {result}"));
}

#[test]
fn a_bound_must_hold_all_through_its_span() {
    holds("signal = \"position_error_m\"\nmax = 0.04");
    holds("signal = \"position_error_m\"\nmax = 0.01\nuntil_s = 2.0");
    fails("signal = \"position_error_m\"\nmax = 0.01", &["from 2.1", "worst 0.03", "too high"]);
    fails("signal = \"torque_sent_left_nm\"\nmin = 1", &["worst 0 at 0.000 s, 1 too low"]);
}

#[test]
fn a_bound_may_be_reached_within_a_time() {
    holds("signal = \"torque_sent_left_nm\"\nmin = 50\nwithin_s = 4");
    holds("signal = \"position_error_m\"\nmax = 0.001\nwithin_s = 0");
    fails("signal = \"torque_sent_left_nm\"\nmin = 50\nwithin_s = 1", &["nearest", "at 1.000 s", "too low"]);
    fails(
        "signal = \"torque_sent_left_nm\"\nmin = 50\nfrom_s = 4.2\nwithin_s = 0.5",
        &["nearest 0 at 4.200 s, 50 too low"],
    );
}

#[test]
fn a_signal_settles_when_it_stays_in_its_band_for_a_time() {
    let still = "signal = \"true_speed_left_rad_s\"\nmin = -0.001\nmax = 0.001\nafter = \"tripped\"";
    holds(&format!("{still}\nwithin_s = 0.5\nfor_s = 0.5"));
    fails(&format!("{still}\nwithin_s = 0.05\nfor_s = 0.5"), &["nearest", "too high"]);
    // It stood still before it broke loose, but not for that long.
    let before = "signal = \"true_speed_left_rad_s\"\nmin = -0.001\nmax = 0.001";
    fails(&format!("{before}\nwithin_s = 1\nfor_s = 3.9"), &["within bounds for 3.", "at most, from 0.000 s on"]);
}

#[test]
fn torque_is_zero_and_nothing_moves_from_some_time_after_a_trip_on() {
    let torque = "signal = [\"torque_right_nm\", \"torque_left_nm\"]\nmin = 0\nmax = 0\nafter = \"tripped\"";
    let both = verdicts(&format!("[[expect]]\n{torque}\nfrom_s = 0.01\n[[expect]]\n{torque}\nfrom_s = 0\n"));
    let passed: Vec<_> = both.iter().map(|verdict| verdict["passed"] == true).collect();
    assert_eq!(passed, [true, true, false, false], "each wheel for itself: {both:?}");
    let speed = "min = -0.001\nmax = 0.001\nafter = \"over-speed\"";
    holds(&format!("signal = \"true_speed_left_rad_s\"\n{speed}\nfrom_s = 0.3"));
    fails(&format!("signal = \"true_speed_left_rad_s\"\n{speed}"), &["too high"]);
}

#[test]
fn each_signal_of_a_list_is_called_by_a_name_of_its_own() {
    let both = verdicts("[[expect]]\nname = \"weak\"\nsignal = [\"torque_right_nm\", \"torque_left_nm\"]\nmax = 90\n");
    let names: Vec<_> = both.iter().map(|verdict| verdict["name"].clone()).collect();
    assert_eq!(names, ["weak, torque_right_nm", "weak, torque_left_nm"]);
}

#[test]
fn a_state_is_called_by_its_name_or_by_the_reason_of_a_trip() {
    holds("state = \"running\"\nfrom_s = 0.1\nuntil_s = 3.5");
    holds("state = \"tripped\"\nwithin_s = 4");
    holds("state = \"over-speed\"\nfrom_s = 4");
    fails("state = \"drive-fault\"\nfrom_s = 4", &["over-speed at 4.000 s"]);
    fails("state = \"running\"\nfrom_s = 0.1", &["over-speed at 3.8"]);
    fails("state = \"stopping\"\nwithin_s = 4", &["nearest"]);
}

#[test]
fn changes_are_bounded_per_second() {
    holds("rate_of = \"torque_sent_left_nm\"\nmin = -20000\nmax = 1000");
    // The trip takes 39 N m away in one period of 5 ms.
    fails("rate_of = \"torque_sent_left_nm\"\nmin = -5000", &["worst -7795", "at 3.8", "too low"]);
    holds("rate_of = \"torque_sent_left_nm\"\nmin = -5000\nafter = \"tripped\"");
}

#[test]
fn notices_frames_and_samples_are_counted() {
    holds("notices = \"tripped\"\nmin = 1\nmax = 1");
    holds("notices = \"over-speed\"\nmin = 1");
    holds("notices = \"drive-fault\"\nmax = 0");
    fails("notices = \"tripped\"\nmax = 0", &["counted 1", "one too many at 3.8"]);
    fails("notices = \"stopping\"\nmin = 1", &["counted 0, too few"]);
    holds("frames = \"RightFeedback\"\nmin = 999\nmax = 1001");
    holds("frames = \"RightFeedback\"\nmin = 199\nmax = 201\nfrom_s = 1\nuntil_s = 2");
    fails("frames = \"RightFeedback\"\nmax = 10", &["one too many at 0.05"]);
    holds("samples = \"position_error_m\"\nabove = 0.04\nmax = 0");
    fails("samples = \"position_error_m\"\nabove = 0.01\nmax = 10", &["one too many at 2.1"]);
    fails("samples = \"position_error_m\"\nbelow = 0.01\nmin = 1000", &["too few"]);
}

#[test]
fn signals_of_the_frames_on_the_bus_are_looked_at_too() {
    holds("signal = \"LeftFeedback.TorqueApplied\"\nmax = 61");
    fails("signal = \"LeftFeedback.TorqueApplied\"\nmax = 50", &["worst 60", "too high"]);
}

#[test]
fn what_is_to_follow_something_that_never_happened_fails() {
    fails("signal = \"position_error_m\"\nmax = 1\nafter = \"drive-fault\"", &["`drive-fault` never happened"]);
    fails("notices = \"tripped\"\nmax = 9\nafter = \"stopping\"", &["`stopping` never happened"]);
    fails("signal = \"position_error_m\"\nmax = 1\nafter = \"tripped\"\nuntil_s = 3", &["the run ended before"]);
}

#[test]
fn what_a_shorter_run_does_not_reach_is_not_held_against_it() {
    let rig = Rig::new();
    let expectations = [
        "state = \"tripped\"\nwithin_s = 4",
        "signal = \"position_error_m\"\nmax = 1\nafter = \"tripped\"",
        "signal = \"position_error_m\"\nmax = 1\nfrom_s = 4",
    ];
    rig.write("trips.toml", &format!("{TRIPS}[[expect]]\n{}\n", expectations.join("\n[[expect]]\n")));
    let run = rig.run("trips.toml", &["duration_s=2"]).expect_status(0);
    assert_eq!(run.stdout.matches("not reached, the run was made shorter").count(), 3, "{}", run.stdout);
}

#[test]
fn one_that_fails_shows_the_signal_around_the_worst() {
    let rig = Rig::new();
    rig.write(
        "trips.toml",
        &format!("{TRIPS}[[expect]]\nname = \"tracks\"\nsignal = \"position_error_m\"\nmax = 0.01\n"),
    );
    let run = rig.run("trips.toml", &[]).expect_status(1);
    let verdict = &rig.summary("runs")["expectations"][0];
    let around = verdict["around"].as_array().expect("samples");
    assert_eq!((around.len(), &around[2]["value"]), (5, &verdict["worst"]));
    assert_eq!(
        (&verdict["name"], &verdict["file"], &verdict["line"]),
        (&"tracks".into(), &"trips.toml".into(), &7.into())
    );
    let lines: Vec<_> = run.stdout.lines().skip_while(|line| !line.contains("tracks: ")).collect();
    assert!(lines[0].contains("FAILED") && lines[3].contains(">    3.8"), "{}", run.stdout);
}

#[test]
fn one_that_fails_says_how_to_run_it_again() {
    let rig = Rig::new();
    rig.write("it's.toml", TRIPS);
    let sets = ["expect=[{state=\"running\"}]", "seed=7"];
    let run = rig.run("it's.toml", &sets).expect_status(1);
    let line = run.stdout.lines().find_map(|line| line.trim().strip_prefix("reproduce")).expect("a line").trim();
    assert_eq!(line, r#"hil-sim run 'it'\''s.toml' --set 'expect=[{state="running"}]' --set seed=7"#);
    assert_eq!(rig.summary("runs")["reproduce"], line);
    let path = std::path::Path::new(env!("CARGO_BIN_EXE_hil-sim")).parent().expect("a folder");
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", &format!("PATH={}:$PATH; {line} --out again", path.display())]).current_dir(rig.path(""));
    rig::finish(&mut shell).expect_status(1);
    assert_eq!(rig.summary("again")["frames_blake3"], rig.summary("runs")["frames_blake3"]);
    let run = rig.run("dac-friction", &["duration_s=0.5", "expect=[{state=\"boot\"}]"]).expect_status(1);
    assert!(run.stdout.contains("--set seed=1"), "the seed is always said: {}", run.stdout);
}

#[test]
fn an_expectation_that_means_nothing_is_refused_where_it_stands() {
    for (keys, words) in [
        ("max = 3", &["found none of `signal`, `rate_of`, `state`"][..]),
        ("signal = \"x_m\"\nstate = \"running\"", &["trips.toml:9:9", "found `state` beside `signal`"]),
        ("state = \"runing\"", &["no such state", "did you mean `running`?"]),
        ("state = \"running\"\nmax = 3", &["found a bound on a state's name"]),
        ("notices = \"trip\"\nmax = 0", &["no such kind of notice", "did you mean `tripped`?"]),
        ("frames = \"RightFeedbak\"\nmax = 0", &["no such message", "did you mean `RightFeedback`?"]),
        ("signal = \"RightFedback.State\"\nmax = 0", &["no such message", "did you mean `RightFeedback`?"]),
        ("signal = \"RightFeedback.Sate\"\nmax = 0", &["no such signal", "did you mean `State`?"]),
        ("signal = [3]\nmax = 0", &["expected a name, or a list of names"]),
        ("signal = []\nmax = 0", &["expected a name, or a list of names"]),
        ("samples = \"x_m\"\nmax = 0", &["expected `above` or `below`"]),
        ("signal = \"x_m\"\nabove = 1\nmax = 0", &["unknown key `expect[0].above`"]),
        ("signal = \"x_m\"\nmax = 0\nafter = \"triped\"", &["no such event", "did you mean `tripped`?"]),
        ("signal = \"x_m\"\nmax = 0\nfor_s = 1", &["found without `within_s`"]),
        ("signal = \"x_m\"\nmax = 0\nwithin_s = 1\nuntil_s = 2", &["found beside `within_s`"]),
        ("signal = \"x_m\"\nmax = 0\nwithin_s = 3\nfor_s = 3", &["found 6, expected no more than `duration_s`, 5"]),
        ("notices = \"tripped\"\nmax = 0\nwithin_s = 1", &["found with a count, expected `until_s`"]),
        ("notices = \"tripped\"\nmax = -1", &["found -1, expected a finite number, 0 or more"]),
        ("signal = \"x_m\"\nmax = 0\nname = 3", &["expected a string"]),
    ] {
        let rig = Rig::new();
        rig.write("trips.toml", &format!("{TRIPS}[[expect]]\n{keys}\n"));
        let run = rig.hil_sim(&["run", "trips.toml"]).expect_status(2);
        words.iter().for_each(|words| assert!(run.stderr.contains(words), "{keys}\n{}", run.stderr));
        assert!(run.stderr.contains("trips.toml:"), "{}", run.stderr);
        assert_eq!(rig.files(), ["trips.toml"]);
    }
}
