//! `report.html` beside a run's summary: all of it in one file that opens
//! offline, in light and dark, small enough to attach.

mod rig;

use std::process::Command;

use rig::Rig;

/// A run that trips at 3.8 s, and what is expected of it.
const TRIPS: &str = r#"
base = "dac-friction"
name = "trips"
duration_s = 5.0
path.duration_s = 150.0
safety.wheel_speed_limit_rad_s = 0.3
[[expect]]
name = "tracks <closely> & well"
signal = "position_error_m"
max = 0.01
[[expect]]
state = "over-speed"
within_s = 4
[[expect]]
notices = "drive-fault"
max = 0
[[expect]]
rate_of = "torque_sent_left_nm"
max = 1000
"#;

/// The page of that run.
fn page(rig: &Rig) -> String {
    rig.write("trips.toml", TRIPS);
    rig.hil_sim(&["run", "trips.toml", "--no-log"]).expect_status(1);
    std::fs::read_to_string(rig.path("runs/report.html")).expect("a page")
}

#[test]
fn it_tells_every_expectation_and_draws_the_signals() {
    let page = page(&Rig::new());
    for words in [
        "trips: failed",
        "3 of 4 expectations held over 5.000 s",
        "tracks &lt;closely&gt; &amp; well: position_error_m &lt;= 0.01 from 0 s to 5 s",
        "worst 0.03",
        "state is over-speed within 4 s",
        "The stack tripped: a wheel turned too fast",
        "hil-sim run trips.toml --set seed=1",
    ] {
        assert!(page.contains(words), "{words}");
    }
    for title in [
        "1. tracks &lt;closely&gt; &amp; well",
        "2. state",
        "4. torque_sent_left_nm",
        "Track in the plane",
        "Position error",
        "Torque sent",
        "Bus load",
        "State of the stack",
        "States of the drives",
    ] {
        assert!(page.contains(&format!("<title>{title}</title>")), "{title}");
    }
    assert!(page.contains("class=\"limit\"") && !page.contains("no data"));
    assert!(page.matches("<title>tripped</title>").count() >= 5, "every chart over time marks the trip");
}

#[test]
fn it_asks_for_nothing_from_anywhere() {
    let page = page(&Rig::new()).replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for word in ["http:", "https:", "src=", "@import", "url(", "<script", "<link"] {
        assert!(!page.contains(word), "{word}");
    }
    assert!(page.contains("default-src 'none'") && page.contains("prefers-color-scheme: dark"));
}

#[test]
fn a_long_run_makes_a_page_that_can_be_attached() {
    let rig = Rig::new();
    rig.hil_sim(&["run", "dac-friction", "--no-log"]).expect_status(0);
    let length = rig.path("runs/report.html").metadata().expect("a page").len();
    assert!(length < 200_000, "{length} bytes for 150 s");
}

#[test]
fn a_run_on_an_ideal_link_has_a_page_without_a_bus() {
    let rig = Rig::new();
    rig.hil_sim(&["run", "dac-ideal", "--no-log", "--set", "duration_s=1"]).expect_status(0);
    let page = std::fs::read_to_string(rig.path("runs/report.html")).expect("a page");
    assert!(page.contains("Torque sent") && !page.contains("Bus load") && !page.contains("no data"));
}

#[test]
fn the_same_run_makes_the_same_page() {
    assert_eq!(page(&Rig::new()), page(&Rig::new()));
}

#[test]
fn a_browser_opens_it_without_complaint() {
    let rig = Rig::new();
    page(&rig);
    let mut chromium = Command::new("chromium");
    chromium.args(["--headless=new", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--dump-dom"]);
    chromium.arg("--host-resolver-rules=MAP * ~NOTFOUND");
    chromium.arg(format!("--user-data-dir={}", rig.path("browser").display()));
    chromium.arg(rig.path("runs/report.html"));
    let output = chromium.output().expect("chromium starts (Debian: apt-get install chromium)");
    let (page, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{said}");
    assert!(page.matches("<svg").count() >= 18, "a chart has two: {page}");
    assert!(!said.contains("CONSOLE"), "{said}");
}
