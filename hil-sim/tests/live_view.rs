//! What the live page is told of a run: the newest values, and charts and a
//! track of bounded size, each viewer only what is new.

use std::ops::ControlFlow;

use canloop::event::{Event, Sink, SyncEvent, Tick, Truth};
use canloop::live::Run;
use canloop::live::view::{Seen, View};
use canloop::log::LogContents;
use canloop::robot::Pose;
use canloop::time::Instant;
use hil_sim::bench;
use hil_sim::scenario::{Link, Scenario};
use serde_json::Value;

/// A view of a run of `scenario` before its first event.
fn view(scenario: &Scenario) -> View {
    let contents = LogContents {
        planned: scenario.events.iter().map(|event| event.name.clone()).collect(),
        ..LogContents::default()
    };
    let bit_rate_bit_s = match scenario.link {
        Link::Can(rates) => Some(rates.nominal_bit_s),
        Link::Ideal => None,
    };
    let run = Run {
        name: &scenario.name,
        program: "a test",
        start: Instant::ZERO,
        duration_s: Some(scenario.duration_s),
        stack: &scenario.stack,
        bit_rate_bit_s,
        contents: &contents,
    };
    View::new(&run, 1)
}

fn scenario(name: &str, overrides: &[&str]) -> Scenario {
    let overrides: Vec<_> = overrides.iter().map(|&set| set.to_owned()).collect();
    Scenario::load(name, &overrides).expect("a good scenario")
}

/// The view after a whole run.
fn after_run(name: &str, overrides: &[&str]) -> View {
    let scenario = scenario(name, overrides);
    let mut view = view(&scenario);
    bench::run(&scenario, &mut view, |_| ControlFlow::Continue(()));
    view
}

fn news(view: &View, seen: &mut Seen) -> Value {
    serde_json::from_str(&view.news(seen)).expect("JSON")
}

fn all(view: &View) -> Value {
    news(view, &mut Seen::default())
}

#[track_caller]
fn number(news: &Value, pointer: &str) -> f64 {
    let found = news.pointer(pointer);
    found.and_then(Value::as_f64).unwrap_or_else(|| panic!("{pointer} should be a number and is {found:?}"))
}

fn length(news: &Value, pointer: &str) -> usize {
    news.pointer(pointer).and_then(Value::as_array).map_or(0, Vec::len)
}

#[test]
fn the_newest_values_are_those_of_the_run() {
    let told = all(&after_run("dac-friction", &["duration_s=60.0"]));
    assert_eq!((&told["now"]["state"], &told["ended"]), (&"running".into(), &Value::Null));
    assert_eq!((&told["drives"]["right"], &told["drives"]["left"]), (&"enabled".into(), &"enabled".into()));
    assert!((60.0..60.01).contains(&number(&told, "/now/time_s")));
    assert!(number(&told, "/now/position_error_m") < 0.001);
    assert!((15.0..25.0).contains(&number(&told, "/load_percent")));
    assert!((60_000.0..63_000.0).contains(&number(&told, "/frames")));
    assert_eq!(number(&told, "/run/torque_limit_nm"), 90.0);
    assert_eq!(number(&told, "/run/half_track_m"), 0.27);
    assert!((3.0..9.0).contains(&number(&told, "/now/right/torque_sent_nm")));
}

#[test]
fn charts_keep_the_greatest_error_and_torque_of_the_whole_run() {
    let told = all(&after_run("dac-friction", &[]));
    let rows = told["whole"]["rows"].as_array().expect("rows");
    let most = |key: &str| rows.iter().filter_map(|row| row[key][1].as_f64()).fold(0.0, f64::max);
    assert!((most("position_error_m") - 0.032_234).abs() < 1e-6, "{}", most("position_error_m"));
    assert!((most("torque_left_nm").max(most("torque_right_nm")) - 60.33).abs() < 0.01);
    assert!((200..=600).contains(&rows.len()) && length(&told, "/recent/rows") == 600);
    assert_eq!(number(&told, "/recent/first") as usize + 600, (number(&told, "/now/time_s") * 10.0) as usize + 1);
}

#[test]
fn what_a_viewer_gets_is_bounded_however_long_the_run() {
    let view = after_run("rough-ride", &[]);
    let mut seen = Seen::default();
    let first = view.news(&mut seen).len();
    assert!(first < 300_000, "{first} bytes at first");
    let later = view.news(&mut seen).len();
    assert!(later < 2_500, "{later} bytes when nothing has happened");
}

/// Looks at a view each time so many events have come, and keeps all rows as a
/// page does.
struct Follower {
    view: View,
    every: u64,
    events: u64,
    seen: Seen,
    generations: [Value; 2],
    rows: Vec<Value>,
    places: Vec<Value>,
}

impl Follower {
    fn look(&mut self) {
        let told = news(&self.view, &mut self.seen);
        let generations = ["whole", "track"].map(|list| told[list]["generation"].clone());
        if generations[0] != self.generations[0] {
            self.rows.clear();
        }
        if generations[1] != self.generations[1] {
            self.places.clear();
        }
        self.generations = generations;
        self.rows.truncate(number(&told, "/whole/first") as usize);
        self.rows.extend(told["whole"]["rows"].as_array().expect("rows").iter().cloned());
        self.places.extend(told["track"]["places_m"].as_array().expect("places").iter().cloned());
    }
}

impl Sink for Follower {
    fn event(&mut self, at: Instant, event: &Event) {
        self.view.event(at, event);
        self.events += 1;
        if self.events.is_multiple_of(self.every) {
            self.look();
        }
    }
}

#[test]
fn who_follows_from_the_beginning_knows_what_is_told_to_who_comes_last() {
    let scenario = scenario("dac-friction", &["duration_s=70.0"]);
    for every in [97, 5003, 100_001] {
        let mut follower = Follower {
            view: view(&scenario),
            every,
            events: 0,
            seen: Seen::default(),
            generations: [Value::Null, Value::Null],
            rows: Vec::new(),
            places: Vec::new(),
        };
        bench::run(&scenario, &mut follower, |_| ControlFlow::Continue(()));
        follower.look();
        let told = all(&follower.view);
        assert_eq!(&Value::from(follower.rows.clone()), &told["whole"]["rows"], "every {every}");
        assert!(follower.generations.iter().all(|generation| generation != 0), "both were made anew on the way");
        assert_eq!(&Value::from(follower.places.clone()), &told["track"]["places_m"], "every {every}");
    }
}

#[test]
fn what_is_planned_and_what_trips_is_told_with_its_time() {
    let told = all(&after_run("rough-ride", &["duration_s=45.0"]));
    let kept = told["happened"]["kept"].as_array().expect("happenings");
    let at_s = |text: &str| kept.iter().find(|happening| happening["text"] == text).map(|push| number(push, "/at_s"));
    assert!(at_s("a push begins").is_some_and(|at_s| (40.0..40.01).contains(&at_s)), "{kept:?}");
    assert!(at_s("a push ends").is_some_and(|at_s| (40.5..40.51).contains(&at_s)), "{kept:?}");

    let told = all(&after_run("dac-friction", &["duration_s=5.0", "safety.wheel_speed_limit_rad_s=0.3"]));
    assert_eq!(told["now"]["state"], "tripped");
    assert_eq!(told["now"]["state_text"], "tripped: a wheel turned too fast");
    let kept = told["happened"]["kept"].as_array().expect("happenings");
    assert!(
        kept.iter().any(|happening| happening["kind"] == "tripped" && number(happening, "/at_s") > 3.0),
        "{kept:?}"
    );
}

#[test]
fn a_link_without_a_bus_has_no_load() {
    let told = all(&after_run("dac-ideal", &["duration_s=2.0"]));
    assert_eq!((&told["load_percent"], &told["run"]["bit_rate_bit_s"]), (&Value::Null, &Value::Null));
    assert!(number(&told, "/now/position_error_m") < 0.01 && told["drives"]["right"].is_null());
}

/// A view that is not told everything.
struct Only(View, fn(&Event) -> bool);

impl Sink for Only {
    fn event(&mut self, at: Instant, event: &Event) {
        if (self.1)(event) {
            self.0.event(at, event);
        }
    }
}

#[test]
fn a_stack_without_a_simulation_shows_its_odometry() {
    let scenario = scenario("dac-friction", &["duration_s=40.0"]);
    let mut only = Only(view(&scenario), |event| !matches!(event, Event::Truth(_)));
    bench::run(&scenario, &mut only, |_| ControlFlow::Continue(()));
    let told = all(&only.0);
    assert!(number(&told, "/now/position_error_m") < 0.01 && length(&told, "/track/places_m") > 100);
    assert!(told["whole"]["rows"][100]["position_error_m"][0].is_f64());
}

#[test]
fn drives_without_a_stack_show_their_torques() {
    let scenario = scenario("dac-friction", &["duration_s=40.0"]);
    let is_told = |event: &Event| matches!(event, Event::Truth(_) | Event::Frame(_) | Event::Mark(_));
    let mut only = Only(view(&scenario), is_told);
    bench::run(&scenario, &mut only, |_| ControlFlow::Continue(()));
    let told = all(&only.0);
    assert!(told["now"]["state"].is_null() && told["now"]["right"]["torque_sent_nm"].is_null());
    assert!(number(&told, "/now/right/torque_applied_nm") > 1.0);
    assert!(told["whole"]["rows"][100]["torque_left_nm"][0].is_f64());
}

#[test]
fn periods_whose_feedback_stayed_out_are_counted() {
    let scenario = scenario("dac-friction", &[]);
    let mut view = view(&scenario);
    for tick in 0..10 {
        view.event(Instant::ZERO, &Event::Sync(SyncEvent { tick, ..SyncEvent::default() }));
        if !(3..6).contains(&tick) {
            view.event(Instant::ZERO, &Event::Tick(Tick { tick, ..Tick::default() }));
        }
    }
    assert_eq!(number(&all(&view), "/now/lost/periods_unanswered"), 3.0);
}

#[test]
fn a_robot_that_is_nowhere_is_shown_as_nothing() {
    let scenario = scenario("dac-friction", &[]);
    let mut view = view(&scenario);
    let nowhere = Pose { x_m: f64::NAN, y_m: f64::INFINITY, heading_rad: f64::NEG_INFINITY };
    let truth = Truth { pose: nowhere, position_error_m: f64::NAN, ..Truth::default() };
    let tick = Tick { odometry: nowhere, reference: nowhere, state: 255, ..Tick::default() };
    for at_nanos in [i64::MIN / 2, -1, 0, 1, i64::MAX / 2] {
        view.event(Instant::from_nanos(at_nanos), &Event::Tick(tick));
        view.event(Instant::from_nanos(at_nanos), &Event::Truth(truth));
    }
    let told = all(&view);
    assert!(told["now"]["robot"]["x_m"].is_null() && told["now"]["position_error_m"].is_null(), "{told}");
    assert!(told["now"]["state"].is_null() && length(&told, "/track/places_m") == 0, "{told}");
}
