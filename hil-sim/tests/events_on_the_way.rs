//! What a scenario plans happens at its moment, and the robot, the drives and
//! the stack do with it what real ones would.

mod rig;

use canloop::event::{Event, Mark, Sink, Truth};
use canloop::time::Instant;
use canloop::wheels::Wheels;
use hil_sim::bench;
use hil_sim::scenario::Scenario;
use rig::{Rig, number};

const BASE: &str = "base = \"dac-friction\"\nname = \"eventful\"\nduration_s = 20\nexpect = []\n\
    [safety]\nfollowing_error_rad = 1.0\nsaturation_timeout_s = 0.2\n[path]\nduration_s = 40\n";

/// The summary of a run with these events.
fn summary(events: &str) -> serde_json::Value {
    let rig = Rig::new();
    rig.write("eventful.toml", &format!("{BASE}{events}"));
    rig.hil_sim(&["run", "eventful.toml", "--no-log"]).expect_status(0);
    rig.summary("runs")
}

fn state_text(summary: &serde_json::Value) -> &str {
    summary["findings"][0].as_str().unwrap_or("the stack has not tripped")
}

#[track_caller]
fn assert_trips(event: &str, reason: &str) {
    let summary = summary(&format!("[[event]]\nat_s = 10\n{event}\n"));
    assert_eq!(summary["state"], "tripped", "{event}: {summary}");
    assert!(state_text(&summary).contains(reason), "{event}: {}", state_text(&summary));
}

#[track_caller]
fn assert_keeps_to_its_path(event: &str) {
    let summary = summary(&format!("[[event]]\nat_s = 10\n{event}\n"));
    assert_eq!(summary["state"], "running", "{event}: {}", state_text(&summary));
    let max_m = number(&summary, "/tracking/max_m");
    assert!(max_m < 0.1, "{event}: {max_m} m");
}

#[test]
fn what_goes_wrong_with_a_drive_trips_the_stack_for_what_it_is() {
    let cases = [
        ("kind = \"power-loss\"\nwheel = \"right\"", "sent no feedback"),
        ("kind = \"drive-fault\"\nfault = \"over_temperature\"\nwheel = \"left\"", "reported a fault"),
        ("kind = \"feedback-dropout\"", "sent no feedback"),
        ("kind = \"encoder-jump\"\njump_rad = 0.5\nwheel = \"left\"", "an encoder jumped"),
        ("kind = \"encoder-stuck\"\nwheel = \"right\"", "too far from where it should be"),
        ("kind = \"encoder-reversed\"\nwheel = \"right\"", "jumped"),
        ("kind = \"torque-limit\"\nlimit_nm = 1.0", "too far from where it should be"),
        ("kind = \"brown-out\"\nabove_nm = 5", "reported a fault"),
        ("kind = \"clock-drift\"\ndrift = 5", "gave no sign of life"),
        ("kind = \"emergency-stop\"", "an emergency stop"),
    ];
    cases.into_iter().for_each(|(event, reason)| assert_trips(event, reason));
}

#[test]
fn what_goes_wrong_on_the_bus_trips_the_stack_for_what_it_is() {
    let cases = [
        ("kind = \"drop\"\nmessage = \"RightFeedback\"", "sent no feedback"),
        ("kind = \"drop\"\nmessage = \"LeftHeartbeat\"", "gave no sign of life"),
        ("kind = \"drop\"\nmessage = \"LeftCommand\"", "reported a fault"),
        ("kind = \"delay\"\nmessage = \"LeftFeedback\"\nby_s = 0.02", "sent no feedback"),
        ("kind = \"corrupt\"\nmessage = \"LeftFeedback\"\ncrc = \"missed\"", "sent no feedback"),
        ("kind = \"corrupt\"\ncrc = \"missed\"\ncount = 1\nfor_s = 0.1\nevery_s = 0.2", "were damaged"),
        ("kind = \"silence\"\nnode = \"right\"", "sent no feedback"),
        ("kind = \"babble\"\nid = 1", "sent no feedback"),
        ("kind = \"bus-off\"\nnode = \"stack\"\nfor_s = 1", "went off the bus"),
        ("kind = \"bus-off\"\nnode = \"left\"", "sent no feedback"),
        ("kind = \"no-acknowledge\"\nnode = \"stack\"", "sent no feedback"),
        ("kind = \"cable-cut\"\nnode = \"stack\"", "sent no feedback"),
        ("kind = \"bit-errors\"\nrate = 0.02", "sent no feedback"),
        ("kind = \"bursty-loss\"\nturns_bad = 0.02\nturns_good = 0.02", "tripped"),
    ];
    cases.into_iter().for_each(|(event, reason)| assert_trips(event, reason));
}

#[test]
fn what_a_bus_gets_over_by_itself_leaves_the_robot_on_its_path() {
    let cases = [
        "kind = \"duplicate\"\nmessage = \"RightCommand\"",
        "kind = \"corrupt\"\nprobability = 0.1",
        "kind = \"drop\"\nmessage = \"RightFeedback\"\ncount = 1\nevery_s = 1\nfor_s = 0.5",
        "kind = \"bit-errors\"\nrate = 1e-5",
        "kind = \"babble\"\nid = 1\nperiod_s = 0.01",
    ];
    cases.into_iter().for_each(assert_keeps_to_its_path);
}

#[test]
fn what_the_control_method_is_there_for_disturbs_it_little() {
    let cases = [
        "kind = \"load\"\nmass_kg = 160",
        "kind = \"load\"\ncog_angle_rad = 0.5",
        "kind = \"friction\"\nfactor = 2",
        "kind = \"push\"\nforce_n = 100\nfor_s = 1",
        "kind = \"clock-drift\"\ndrift = 0.02",
        "kind = \"brown-out\"\nabove_nm = 100",
        "kind = \"slope\"\nangle_rad = 0.02\nuphill_rad = 1.5",
        "kind = \"wheel-lift\"\nwheel = \"left\"\nfor_s = 0.05",
        "kind = \"clock-phase\"\nby_s = 0.05",
    ];
    cases.into_iter().for_each(assert_keeps_to_its_path);
}

#[test]
fn the_method_needs_to_know_the_torque_that_was_applied() {
    let summary = summary("[[event]]\nat_s = 10\nkind = \"torque-sensor\"\ngain = 1.05\nwheel = \"left\"\n");
    let max_m = number(&summary, "/tracking/max_m");
    assert!(max_m > 0.2, "5 % of torque that are not there cost {max_m} m");
}

#[test]
fn power_that_comes_back_lets_the_operator_go_on() {
    let events = "[[event]]\nkind = \"power-loss\"\nwheel = \"left\"\nat_s = 5\nfor_s = 1\n\
        [[event]]\nkind = \"reset\"\nat_s = 8\n[[event]]\nkind = \"enable\"\nat_s = 9\n";
    assert_eq!(summary(events)["state"], "running");
    let without_reset = events.replace("reset", "enable");
    assert_eq!(summary(&without_reset)["state"], "tripped");
}

#[test]
fn a_new_path_waits_until_the_robot_has_stopped_and_is_enabled_again() {
    let path = "[event.path]\nkind = \"line\"\nfrom_m = [9.0, 5.0]\nto_m = [9.0, 9.0]\nduration_s = 8.0\n";
    let events = format!("[[event]]\nkind = \"new-path\"\nat_s = 2\n{path}");
    assert_eq!(summary(&events)["state"], "stopped");
    assert_eq!(summary(&format!("{events}[[event]]\nkind = \"enable\"\nat_s = 5\n"))["state"], "running");
}

#[test]
fn frames_that_switch_the_bit_rate_leave_more_of_the_bus_to_others() {
    let babble = "[[event]]\nkind = \"babble\"\nat_s = 1\nid = 2000\nbytes = 64\nperiod_s = 0.005\n";
    let load = |frame: &str, rate: &str| {
        let summary = summary(&format!("{babble}frame = \"{frame}\"\n[bus]\ndata_bitrate_bit_s = {rate}\n"));
        assert_eq!(summary["state"], "running");
        number(&summary, "/bus/load_percent")
    };
    // 64 bytes are some 600 bits: a quarter of a period of 5 ms at 500 kbit/s, an eighth of that at 4 Mbit/s.
    let (slow, fast) = (load("fd", "4000000"), load("fd-brs", "4000000"));
    assert!(slow > fast + 18.0, "{slow} %, {fast} %");
    assert!((load("fd-brs", "500000") - slow).abs() < 0.5);
}

#[test]
fn an_event_s_chance_is_its_own_whatever_else_is_planned() {
    let noise = "[[event]]\nkind = \"drop\"\nname = \"noise\"\nat_s = 6\nprobability = 0.05\n\
        message = \"RightHeartbeat\"\nfor_s = 9\n";
    // Before it, and without any effect.
    let other = "[[event]]\nkind = \"drop\"\nat_s = 1\nprobability = 0.0\n";
    let hash = |events: &str| summary(events)["frames_blake3"].to_string();
    assert_eq!(hash(noise), hash(&format!("{other}{noise}")));
    assert_ne!(hash(noise), hash(&noise.replace("\"noise\"", "\"other noise\"")));
}

#[test]
fn the_operator_s_stop_ends_in_stopped() {
    assert_eq!(summary("[[event]]\nkind = \"stop\"\nat_s = 10\n")["state"], "stopped");
}

/// What is told of a run, apart from frames.
#[derive(Default)]
struct Told {
    marks: Vec<(Instant, Mark)>,
    truths: Vec<Truth>,
}

impl Sink for Told {
    fn event(&mut self, at: Instant, event: &Event) {
        match event {
            Event::Mark(mark) => self.marks.push((at, *mark)),
            Event::Truth(truth) => self.truths.push(*truth),
            _ => {}
        }
    }
}

fn told(events: &str) -> Told {
    let rig = Rig::new();
    rig.write("eventful.toml", &format!("{BASE}{events}"));
    let path = rig.path("eventful.toml").display().to_string();
    let scenario = Scenario::load(&path, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    let mut told = Told::default();
    bench::run(&scenario, &mut told, |_| std::ops::ControlFlow::Continue(()));
    told
}

#[test]
fn beginnings_and_ends_are_told_at_their_moments() {
    let told = told("[[event]]\nkind = \"push\"\nforce_n = 1\nat_s = 5\nfor_s = 0.5\nevery_s = 7\n");
    // The SYNC that begins the period takes a moment to arrive.
    let at_s: Vec<(f64, bool)> =
        told.marks.iter().map(|(at, mark)| ((at.as_nanos() / 1_000_000) as f64 / 1e3, mark.has_begun)).collect();
    assert_eq!(at_s, [(5.0, true), (5.5, false), (12.0, true), (12.5, false), (19.0, true), (19.5, false)]);
}

#[test]
fn a_condition_begins_an_event_where_the_robot_is_then() {
    let told = told("[[event]]\nkind = \"push\"\nforce_n = 1\nwhen = \"y_m > 6.0\"\n");
    let (at, _) = told.marks[0];
    let truth = told.truths.iter().rev().find(|truth| truth.tick as i64 * 5_000_000 <= at.as_nanos());
    let y_m = truth.expect("it has begun").pose.y_m;
    assert!((6.0..6.02).contains(&y_m), "{y_m}");
}

#[test]
fn a_push_on_a_robot_without_torque_accelerates_it_as_its_mass_says() {
    let told = told(
        "[robot]\nfriction = { viscous_nm_s_per_rad = 0, static_nm = 0, coulomb_nm = 0, stribeck_s_per_rad = 0 }\n\
         [[event]]\nkind = \"emergency-stop\"\nat_s = 0\n\
         [[event]]\nkind = \"push\"\nforce_n = 10\nat_s = 1\nfor_s = 2\n",
    );
    let at_s = |s: usize| &told.truths[s * 200];
    assert_eq!(at_s(1).speed_rad_s, Wheels::default(), "nothing moved before");
    let wheels = at_s(5).speed_rad_s;
    assert_eq!(wheels, at_s(4).speed_rad_s, "and nothing slows it down after");
    // Eq 5: what 20 N s at the axle make of both wheels' speeds.
    let torque_nm_s = 20.0 * 0.122 / 2.0;
    let (m11, m12, m22) = (0.638_813_13, 0.080_828_39, 1.336_156_09);
    let determinant = m11 * m22 - m12 * m12;
    let expected = Wheels { right: (m22 - m12) / determinant, left: (m11 - m12) / determinant } * torque_nm_s;
    assert!((wheels - expected).all(|off| off.abs() < 1e-6), "{wheels:?} instead of {expected:?}");
}

#[test]
fn what_is_wrong_with_an_event_is_said_with_its_place() {
    let cases = [
        ("kind = \"explosion\"\nat_s = 1", "expected one of \"stop\""),
        ("kind = \"stop\"", "expected a finite number"),
        ("kind = \"stop\"\nat_s = 1\nwhen = \"x_m < 1\"", "expected one of the two"),
        ("kind = \"stop\"\nwhen = \"speed < 1\"", "expected one of x_m"),
        ("kind = \"push\"\nat_s = 1", "found a push without"),
        ("kind = \"load\"\nat_s = 3\nuntil_s = 2", "expected a time after `at_s`"),
        ("kind = \"load\"\nwhen = \"x_m < 1\"\nuntil_s = 2", "expected `for_s`"),
        ("kind = \"friction\"\nfactor = 1\nat_s = 1\nradius_m = 1", "center_m"),
        ("kind = \"push\"\nforce_n = 1\nat_s = 1\nfor_s = 3\nevery_s = 2", "expected at least the 3 s"),
        ("kind = \"stop\"\nat_s = 21", "a moment after the end, expected one until 20 s"),
        ("kind = \"load\"\nat_s = 3\n[[event]]\nkind = \"load\"\nat_s = 5", "expected one at a time"),
        ("kind = \"enable\"\nat_s = 3\n[[event]]\nkind = \"stop\"\nat_s = 3", "two wishes of the operator"),
        (
            "kind = \"power-loss\"\nat_s = 3\nwheel = \"left\"\n\
             [[event]]\nkind = \"drive-fault\"\nat_s = 5\nfault = \"overload\"",
            "expected a drive with power",
        ),
        ("kind = \"new-path\"\nat_s = 1", "event[0].path.kind"),
        ("kind = \"clock-phase\"\nat_s = 1\nby_s = -1", "by_s"),
        ("kind = \"babble\"\nat_s = 1\nid = 7\nframe = \"fd\"\nbytes = 13", "expected up to 8, 12, 16"),
        ("kind = \"stop\"\nat_s = 1\nwheel = \"right\"", "`wheel`"),
        ("kind = \"drop\"\nat_s = 1\nmessage = \"RightFeedbak\"", "did you mean `RightFeedback`?"),
        ("kind = \"silence\"\nat_s = 1\nnode = \"front\"", "expected one of \"stack\""),
    ];
    for (event, says) in cases {
        let rig = Rig::new();
        rig.write("eventful.toml", &format!("{BASE}[[event]]\n{event}\n"));
        let run = rig.hil_sim(&["run", "eventful.toml", "--no-log"]).expect_status(2);
        assert!(run.stderr.contains(says) && run.stderr.contains("eventful.toml:"), "{event}: {}", run.stderr);
    }
}
