//! `canloop budget` tells whether a bus can carry a robot's traffic in time, and
//! `canloop drive` does not start where it cannot.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

const SCENARIOS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/hil-sim/scenarios");

/// Status, output and errors of the program.
fn canloop(args: &[&str]) -> (i32, String, String) {
    let Output { status, stdout, stderr } =
        Command::new(env!("CARGO_BIN_EXE_canloop")).args(args).output().expect("the program starts");
    let text = |bytes| String::from_utf8(bytes).expect("text");
    (status.code().expect("a status"), text(stdout), text(stderr))
}

/// A folder with the paper's robot, and with the shipped scenario of this name
/// based on it.
struct Folder(tempfile::TempDir);

impl Folder {
    fn with(name: &str) -> (Self, String) {
        let folder = Self(tempfile::tempdir().expect("a folder"));
        for name in ["dac-friction", name] {
            let text = std::fs::read_to_string(Path::new(SCENARIOS).join(format!("{name}.toml"))).unwrap();
            folder.write(
                &format!("{name}.toml"),
                &text.replace("base = \"dac-friction\"", "base = \"dac-friction.toml\""),
            );
        }
        let path = folder.path(&format!("{name}.toml"));
        (folder, path)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.0.path().join(name), text).expect("the file is written");
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).display().to_string()
    }
}

fn json(config: &str, args: &[&str]) -> (i32, Value) {
    let (status, text, errors) = canloop(&[&["budget", "--json", config], args].concat());
    (status, serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error} in {text}{errors}")))
}

#[test]
fn every_shipped_scenario_is_in_time() {
    let files = std::fs::read_dir(SCENARIOS).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut seen = 0;
    for file in files.filter(|file| file != "dac-friction.toml") {
        let (_folder, path) = Folder::with(file.trim_end_matches(".toml"));
        // Some are based on others than the paper's robot, and some have no bus.
        let text = std::fs::read_to_string(&path).unwrap();
        if text.contains("base = \"dac-friction.toml\"") && !text.contains("link = \"ideal\"") {
            let (status, budget) = json(&path, &[]);
            assert_eq!((status, &budget["in_time"]), (0, &true.into()), "{file}: {budget:#}");
            seen += 1;
        }
    }
    assert!(seen >= 10, "{seen} scenarios");
}

#[test]
fn the_table_has_every_message_with_its_times_and_the_verdict() {
    let (_folder, path) = Folder::with("dac-friction");
    let (status, text, _) = canloop(&["budget", &path]);
    // 55 + 10 n bits of 2 us; the response as the published equations have it.
    for line in [
        "500000 bit/s, T 5.000 ms; times in ms, at worst",
        "0x080  Sync            Stack           1    5.000        0.130     0.400     5.000   4.600",
        "0x182  LeftFeedback    LeftDrive       8    5.000        0.270     0.860     5.000   4.140",
        "0x202  LeftCommand     Stack           4    5.000        0.190     1.200     5.000   3.800",
        "0x702  LeftHeartbeat   LeftDrive       2  100.000        0.150     1.350   100.000  98.650",
        "load        21.3 % when every frame is as long as it can be",
        "exchange    1.350 ms of 5.000 ms: 1 frame from the stack, then 2 frames from the drives, then 2 frames from",
        "bit rate    the lowest that would do for this T: 250000 bit/s",
        "T           the shortest that this bit rate can do: 1.350 ms",
        "verdict     in time",
    ] {
        assert!(text.contains(line), "no {line:?} in:\n{text}");
    }
    assert_eq!(status, 0);
}

#[test]
fn what_is_too_late_is_named_with_what_would_do() {
    let (_folder, path) = Folder::with("dac-friction");
    let (status, text, _) = canloop(&["budget", &path, "--set", "period_s=0.001"]);
    for line in [
        "too late    the exchange of a period takes up to 1.650 ms, expected at most 1.000 ms",
        "RightCommand takes up to 1.050 ms, expected at most 1.000 ms",
        "LeftCommand may wait for ever, expected at most 1.000 ms",
        "make `bus.bitrate_bit_s` 800000, or keep 500000 bit/s and make `period_s` 0.00135 or longer",
    ] {
        assert!(text.contains(line), "no {line:?} in:\n{text}");
    }
    assert_eq!(status, 1);
    for remedy in
        [["--bitrate", "800000", "--set", "period_s=0.001"], ["--bitrate", "500000", "--set", "period_s=0.00135"]]
    {
        assert_eq!(json(&path, &remedy).0, 0, "{remedy:?}");
    }
    assert_eq!(json(&path, &["--set", "period_s=0.00134"]).0, 1);
}

#[test]
fn two_drives_with_a_command_and_a_feedback_each_are_540_bits_a_period() {
    let (_folder, path) = Folder::with("damiao-dm4310");
    let at =
        |bit_rate: &str, period: &str| json(&path, &["--bitrate", bit_rate, "--set", &format!("period_s={period}")]);
    let percent = |budget: &Value| (budget["load_percent"].as_f64().unwrap() * 10.0).round() / 10.0;
    let (status, fast) = at("1000000", "0.001");
    assert_eq!((status, percent(&fast), &fast["exchange_us"]), (0, 54.0, &540.0.into()));
    let (status, slow) = at("500000", "0.001");
    assert_eq!((status, percent(&slow)), (1, 108.0));
    // 250 kbit/s end at 462 Hz.
    let (status, at_most) = at("250000", &format!("{}", 1.0 / 462.0));
    assert_eq!((status, &at_most["exchange_us"]), (0, &2160.0.into()));
    assert_eq!(at("250000", &format!("{}", 1.0 / 463.0)).0, 1);
}

#[test]
fn lateness_of_stack_and_drives_is_taken_off_what_is_left() {
    let (_folder, path) = Folder::with("dac-friction");
    let (_, budget) = json(&path, &["--jitter-us", "300", "--answer-us", "200"]);
    // The stack speaks twice, the drives answer once.
    assert_eq!(budget["exchange_us"], 1350.0 + 2.0 * 300.0 + 200.0);
    let sync = &budget["messages"][0];
    assert_eq!(
        (&sync["message"], &sync["response_us"], &sync["slack_us"]),
        (&"Sync".into(), &700.0.into(), &4300.0.into())
    );
    assert_eq!(json(&path, &["--jitter-us", "2000"]).0, 1);
}

#[test]
fn a_request_waits_with_the_stack_s_queue_and_goes_after_data_of_its_id() {
    let (_folder, path) = Folder::with("odrive-0.6");
    let (_, budget) = json(&path, &[]);
    let messages = budget["messages"].as_array().unwrap();
    let at = messages.iter().position(|message| message["is_remote"] == true).unwrap();
    let (data, request) = (&messages[at - 1], &messages[at]);
    assert_eq!((&data["id"], &data["is_remote"]), (&request["id"], &false.into()));
    assert_eq!((&request["bytes"], &request["transmission_us"]), (&0.into(), &55.0.into()));
    // Behind the commands that were queued before it, the left one's id is higher.
    let left = messages.iter().find(|message| message["message"] == "Axis2_Set_Input_Torque").unwrap();
    assert!(request["response_us"].as_f64() >= left["response_us"].as_f64(), "{request} {left}");
}

#[test]
fn without_a_bit_rate_the_usual_one_is_taken_and_said() {
    let (folder, path) = Folder::with("dac-friction");
    let text = std::fs::read_to_string(&path).unwrap().replace("bitrate_bit_s = 500000", "");
    folder.write("robot.toml", &text);
    let (status, said, _) = canloop(&["budget", &folder.path("robot.toml")]);
    assert!(said.contains("robot.toml says no bus.bitrate_bit_s") && said.contains("500000 bit/s, T"), "{said}");
    assert_eq!(status, 0);
}

#[test]
fn bad_input_ends_with_2_and_says_why() {
    let (_folder, path) = Folder::with("dac-friction");
    for (args, part) in [
        (&["budget", "missing.toml"][..], "cannot read missing.toml"),
        (&["budget"], "CONFIG"),
        (&["budget", &path, "--bitrate", "5"], "10000..=1000000"),
        (&["budget", &path, "--set", "period_s=-1"], "found -1, expected a number from 1e-5 to 10"),
        (&["budget", &path, "--jitter-us", "-1"], "unexpected argument"),
        (&["budget", &path, "--jitter-us=-1"], "--jitter-us will not do: found -1, expected 0 to 10000000"),
        (&["budget", &path, "--answer-us", "nan"], "--answer-us will not do: found NaN"),
    ] {
        let (status, _, errors) = canloop(args);
        assert!(errors.contains(part), "no {part:?} in:\n{errors}");
        assert_eq!(status, 2, "{args:?}");
    }
}

#[test]
fn the_busiest_and_the_slowest_bus_are_budgeted_at_once() {
    for name in ["odrive-0.6", "vesc", "cia402"] {
        let (_folder, path) = Folder::with(name);
        for period in ["0.00001", "0.0013", "0.1"] {
            for bit_rate in ["10000", "500000", "1000000"] {
                let (status, budget) = json(&path, &["--bitrate", bit_rate, "--set", &format!("period_s={period}")]);
                assert_eq!(status == 0, budget["in_time"] == true, "{name} {period} {bit_rate}: {budget}");
            }
        }
    }
}

/// `drive` on a bus that is not there: what it says before or about that.
fn drive(path: &str, args: &[&str]) -> String {
    let (status, _, errors) =
        canloop(&[&["drive", "--bus", "tcp://127.0.0.1:1/can0", "--config", path], args].concat());
    assert_eq!(status, 2, "{errors}");
    errors
}

#[test]
fn drive_refuses_what_the_bus_cannot_carry_in_time_unless_told_to_go_on() {
    let (_folder, path) = Folder::with("dac-friction");
    let fast = ["--set", "period_s=0.001"];
    let refused = drive(&path, &fast);
    for part in [
        "a bus of 500000 bit/s cannot carry this in time: the exchange of a period takes up to 1.650 ms, expected at most",
        "make `bus.bitrate_bit_s` 800000, or keep 500000 bit/s and make `period_s` 0.00135 or longer",
        "--over-budget drives all the same",
    ] {
        assert!(refused.contains(part), "no {part:?} in:\n{refused}");
    }
    for on in [&["--over-budget"][..], &["--pace", "lockstep"], &["--set", "bus.bitrate_bit_s=800000"]] {
        let said = drive(&path, &[&fast, on].concat());
        assert!(said.contains("127.0.0.1:1") && !said.contains("in time"), "{on:?}: {said}");
    }
}

#[test]
fn drive_does_not_judge_a_bus_of_which_it_knows_no_bit_rate() {
    let (folder, path) = Folder::with("dac-friction");
    let text = std::fs::read_to_string(&path).unwrap().replace("bitrate_bit_s = 500000", "");
    folder.write("robot.toml", &text);
    let said = drive(&folder.path("robot.toml"), &["--set", "period_s=0.001"]);
    assert!(said.contains("127.0.0.1:1") && !said.contains("in time"), "{said}");
}
