//! `--live`: a page shows a run as it goes on. It looks on: it commands
//! nothing, holds up nothing, and is for this machine alone.

#![cfg(target_os = "linux")]

mod rig;
#[path = "real_bus/two_programs.rs"]
mod two_programs;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use rig::builds::other_build;
use rig::{Rig, finish, number};
use serde_json::Value;
use two_programs::{Bench, Running, canloop, free_port};

/// Longer than an answer takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// `hil-sim run` as somebody looks at it, once it serves.
fn watched(bench: &Bench, address: &str, args: &[&str]) -> Running {
    let mut command = bench.rig.command(&[["run"].as_slice(), args, &["--live", address]].concat());
    let mut run = bench.start("run", &mut command);
    run.wait_until("it serves", |run| run.told().contains("live view  "));
    run
}

/// The address that a program has said its page is at.
fn address(run: &Running) -> String {
    let told = run.told();
    let line = told.lines().find(|line| line.starts_with("live view")).expect("it says where the page is");
    line.split("http://").nth(1).expect("a URL").trim_end_matches('/').to_owned()
}

/// A script with the address of a page.
fn script(bench: &Bench, name: &'static str, file: &str, args: &[&str]) -> Running {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    bench.start(name, Command::new(two_programs::python()).arg(tests.join(file)).args(args))
}

/// The answer to a request, up to its end.
fn ask(address: &str, request: &str) -> String {
    let mut stream = request_to(address, request);
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("an answer in UTF-8");
    answer
}

fn request_to(address: &str, request: &str) -> TcpStream {
    let mut stream = TcpStream::connect(address).expect("the page is served");
    stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
    let request = request.replace("HOST", address).replace('\n', "\r\n") + "\r\n\r\n";
    stream.write_all(request.as_bytes()).expect("it listens");
    stream
}

/// The updates from this page as a browser gets them.
fn updates(address: &str) -> impl Iterator<Item = Value> + use<> {
    let stream = BufReader::new(request_to(address, "GET /updates HTTP/1.1\nHost: HOST"));
    let data = stream.lines().map_while(Result::ok).filter_map(|line| line.strip_prefix("data: ").map(str::to_owned));
    data.map(|data| serde_json::from_str(&data).expect("JSON"))
}

#[test]
fn a_browser_shows_a_run_as_it_goes_on_and_comes_back_with_the_next() {
    let bench = Bench::over_tcp();
    let page = format!("127.0.0.1:{}", free_port());
    let picture = Path::new(env!("CARGO_TARGET_TMPDIR")).join("live_page");
    let args = ["rough-ride", "--no-log", "--no-report", "--real-time-factor", "10", "--set", "duration_s=1e5"];
    let run = watched(&bench, &page, &args);
    let mut browser = script(
        &bench,
        "browser",
        "live_page.py",
        &[&format!("http://{page}/"), "rough-ride", "line", &picture.display().to_string()],
    );
    browser.wait_until("it has seen the run go on", |browser| browser.told().contains("goes on"));
    run.signal("INT");
    run.finish().expect_status(130);
    browser.wait_until("it shows the last state", |browser| browser.told().contains("last state"));
    let next = watched(&bench, &page, &[&["line"], &args[1..]].concat());
    browser.finish().expect_status(0);
    next.signal("INT");
    next.finish().expect_status(130);
}

#[test]
fn a_viewer_who_never_reads_neither_changes_nor_holds_up_a_run_and_is_counted() {
    let bench = Bench::over_tcp();
    let args = ["dac-friction", "--no-log", "--no-report", "--set", "duration_s=20", "--set", "expect=[]"];
    bench.rig.hil_sim(&[["run"].as_slice(), &args, &["--out", "alone"]].concat()).expect_status(0);
    let run = watched(&bench, "127.0.0.1:0", &args);
    let viewers = script(&bench, "viewers", "live_viewers.py", &[&address(&run)]);
    run.finish().expect_status(0);
    let told = viewers.finish().expect_status(0).stdout;
    assert!(told.contains("passed") && told.contains("updates missed"), "{told}");
    assert_eq!(bench.rig.summary("runs")["frames_blake3"], bench.rig.summary("alone")["frames_blake3"]);
}

#[test]
fn a_run_at_full_speed_is_the_same_whoever_looks_on() {
    let bench = Bench::over_tcp();
    let args = ["dac-friction", "--no-log", "--no-report"];
    bench.rig.hil_sim(&[["run"].as_slice(), &args, &["--out", "alone"]].concat()).expect_status(0);
    let run = watched(&bench, "127.0.0.1:0", &[args.as_slice(), &["--real-time-factor", "max"]].concat());
    run.finish().expect_status(0);
    let (seen, alone) = (bench.rig.summary("runs"), bench.rig.summary("alone"));
    assert_eq!(seen["frames_blake3"], alone["frames_blake3"]);
    assert_eq!(number(&seen, "/simulated_s"), 150.0);
}

#[test]
fn the_last_update_tells_how_the_run_ended() {
    let bench = Bench::over_tcp();
    let args = ["dac-friction", "--no-log", "--no-report", "--set", "duration_s=3"];
    let run = watched(&bench, "127.0.0.1:0", &[args.as_slice(), &["--set", "expect=[]"]].concat());
    let updates: Vec<_> = updates(&address(&run)).collect();
    run.finish().expect_status(0);
    let last = updates.last().expect("updates");
    assert_eq!(last["ended"], "passed");
    assert!((3.0..3.01).contains(&number(last, "/now/time_s")), "{last}");
    assert_eq!(number(last, "/frames"), number(&bench.rig.summary("runs"), "/bus/frames"));
    assert_eq!(number(last, "/viewing/events_lost"), 0.0);
    assert!(updates.iter().filter(|update| !update["run"].is_null()).count() == 1, "the facts are told once");
    assert!(updates.len() > 3, "{} updates in 3 s", updates.len());
}

#[test]
fn several_scenarios_follow_one_another_on_the_same_page() {
    let bench = Bench::over_tcp();
    let args = ["dac-friction", "line", "--no-log", "--no-report", "--set", "duration_s=1", "--set", "expect=[]"];
    let run = watched(&bench, "127.0.0.1:0", &args);
    let names: Vec<_> =
        updates(&address(&run)).filter_map(|update| update["run"]["name"].as_str().map(str::to_owned)).collect();
    run.finish().expect_status(0);
    assert_eq!(names, ["dac-friction", "line"]);
}

#[test]
fn the_drives_and_the_stack_of_two_programs_have_a_page_each() {
    let bench = Bench::over_tcp();
    let live = ["--live", "127.0.0.1:0", "--set", "duration_s=1e5"];
    let serve = bench.serve(&[live.as_slice(), &["--no-log"]].concat());
    let mut drive = bench.drive(&live[..2]);
    drive.wait_until("it serves", |drive| drive.told().contains("live view  "));
    let is_running = |update: &Value| number(update, "/now/time_s") > 0.5;
    let stack = updates(&address(&drive)).find(is_running).expect("updates of the stack");
    let drives = updates(&address(&serve)).find(is_running).expect("updates of the drives");
    assert_eq!((&stack["now"]["state"], &drives["now"]["state"]), (&"running".into(), &Value::Null));
    for update in [&stack, &drives] {
        assert_eq!((&update["drives"]["right"], &update["drives"]["left"]), (&"enabled".into(), &"enabled".into()));
        assert!(number(update, "/now/position_error_m") < 0.1 && number(update, "/frames") > 100.0);
        assert!(update["now"]["right"]["torque_applied_nm"].is_f64() && update["now"]["robot"]["x_m"].is_f64());
    }
    drive.signal("INT");
    drive.finish().expect_status(0);
}

#[test]
fn a_loop_by_the_clock_shows_how_punctual_it_is() {
    let bench = Bench::over_tcp();
    let serve = bench.serve(&["--time", "wall", "--no-log", "--set", "duration_s=1e5"]);
    let mut drive = bench.drive_in_real_time(&["--live", "127.0.0.1:0", "--set", "safety.overrun_periods=1000"]);
    drive.wait_until("it serves", |drive| drive.told().contains("live view  "));
    let update = updates(&address(&drive)).find(|update| update["now"]["lateness_s"].is_f64());
    let update = update.expect("updates");
    assert!(number(&update, "/now/worst_lateness_s") >= number(&update, "/now/lateness_s"), "{update}");
    assert_eq!(update["run"]["program"].as_str().unwrap_or("canloop drive"), "canloop drive");
    drop((drive, serve));
}

#[test]
fn nothing_but_looking_on_is_answered_and_not_to_everybody() {
    let bench = Bench::over_tcp();
    let run = watched(&bench, "127.0.0.1:0", &["dac-friction", "--no-log", "--no-report"]);
    let page = address(&run);
    let page_text = ask(&page, "GET / HTTP/1.1\nHost: HOST");
    assert!(page_text.starts_with("HTTP/1.1 200") && page_text.contains("<h1 id=\"name\">"), "{page_text}");
    let lower = page_text.to_lowercase();
    assert!(lower.contains("content-security-policy: default-src 'none'") && !lower.contains("access-control"));
    for method in ["POST", "PUT", "DELETE", "HEAD", "OPTIONS", "PATCH"] {
        let answer = ask(&page, &format!("{method} /updates HTTP/1.1\nHost: HOST\nContent-Length: 0"));
        assert!(answer.starts_with("HTTP/1.1 405"), "{method}: {answer}");
    }
    assert!(ask(&page, "GET /stop HTTP/1.1\nHost: HOST").starts_with("HTTP/1.1 404"));
    assert!(ask(&page, "GET / HTTP/1.1\nHost: robots.example.org").starts_with("HTTP/1.1 421"));
    assert!(ask(&page, "nonsense").starts_with("HTTP/1.1 400"));
    let viewers: Vec<_> = (0..16).map(|_| updates(&page)).map(|mut updates| (updates.next(), updates)).collect();
    assert!(viewers.iter().all(|(first, _)| first.is_some()));
    assert!(ask(&page, "GET /updates HTTP/1.1\nHost: HOST").starts_with("HTTP/1.1 503"));
    drop(viewers);
    run.signal("INT");
    run.finish().expect_status(130);
}

/// The commands that somebody can look at, each in a form that would run.
fn commands(rig: &Rig) -> [Command; 3] {
    rig.write("robot.toml", &rig.hil_sim(&["scenario", "dac-friction"]).expect_status(0).stdout);
    let bus = format!("tcp-listen://127.0.0.1:{}/can0", free_port());
    let mut drive = Command::new(canloop());
    drive.args(["drive", "--bus", &bus, "--config", "robot.toml"]).current_dir(rig.path("."));
    [rig.command(&["run", "dac-friction"]), rig.command(&["serve", "dac-friction", "--bus", &bus]), drive]
}

#[test]
fn an_address_that_others_could_reach_is_refused() {
    let rig = Rig::new();
    for option in ["--live", "--foxglove"] {
        for mut command in commands(&rig) {
            let run = finish(command.args([option, "0.0.0.0:8766"])).expect_status(2);
            assert!(run.stderr.contains("loopback only") && run.stderr.contains("ssh -L 8766"), "{}", run.stderr);
        }
    }
    assert_eq!(rig.files(), ["robot.toml"]);
}

#[test]
fn a_port_that_is_taken_is_refused_with_another_one() {
    let rig = Rig::new();
    let taken = TcpListener::bind("127.0.0.1:0").expect("there are free ports");
    let address = taken.local_addr().expect("it is bound").to_string();
    for mut command in commands(&rig) {
        let run = finish(command.args(["--live", &address])).expect_status(2);
        assert!(run.stderr.contains(&format!("cannot serve the live view at {address}")), "{}", run.stderr);
        assert!(run.stderr.contains("choose another address, such as --live 127.0.0.1:"), "{}", run.stderr);
    }
    assert_eq!(rig.files(), ["robot.toml"]);
}

#[test]
fn a_scenario_that_is_taken_for_an_address_is_said_to_be_one() {
    let run = Rig::new().hil_sim(&["run", "--live", "dac-friction"]).expect_status(2);
    assert!(run.stderr.contains("expected ADDR:PORT") && run.stderr.contains("before this option"), "{}", run.stderr);
}

#[test]
fn a_pace_that_the_clock_sets_is_not_asked_for_twice() {
    let bus = format!("tcp-listen://127.0.0.1:{}/can0", free_port());
    let args = ["serve", "dac-friction", "--bus", &bus, "--time", "wall", "--real-time-factor", "2"];
    let run = Rig::new().hil_sim(&args).expect_status(2);
    assert!(run.stderr.contains("--time wall") && run.stderr.contains("leave one of the two out"), "{}", run.stderr);
}

#[test]
fn a_program_that_was_built_without_says_how_to_build_it_with() {
    let rig = Rig::new();
    let program = other_build();
    for (option, feature) in [("--live", "live"), ("--foxglove", "foxglove")] {
        let mut command = Command::new(&program);
        let run = finish(command.args(["run", "dac-friction", option]).current_dir(rig.path("."))).expect_status(2);
        assert!(run.stderr.contains(&format!("--features {feature}")), "{}", run.stderr);
    }
    assert_eq!(rig.files(), [""; 0]);
}
