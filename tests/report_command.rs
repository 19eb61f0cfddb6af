//! A log, whatever its format, becomes a page that opens offline.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use canloop::event::{BusFrame, Event, Notice, Sink, Tick};
use canloop::frame::{CanId, Frame};
use canloop::log::{LogContents, LoggedBus, McapLog, WhenFull};
use canloop::schema::Profile;
use canloop::time::Instant;

fn report(args: &[&Path]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_canloop")).arg("report").args(args).output().expect("the program")
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

fn page(log: &Path, more: &[&Path]) -> String {
    let output = report(&[&[log], more].concat());
    assert!(output.status.success(), "{}", told(&output));
    std::fs::read_to_string(log.with_extension("html")).expect("a page")
}

/// A log as `canloop drive` writes it.
fn driven(folder: &Path) -> PathBuf {
    let path = folder.join("drive.mcap");
    let profile = Profile::builtin("wheel_drive").expect("it is built in");
    let text = |name: &str, text: &str| (name.to_owned(), "text/plain".to_owned(), text.into());
    let contents = LogContents {
        buses: vec![LoggedBus { name: "can0", dbcs: vec![&profile.dbc] }],
        attachments: vec![text("robot.toml", "period_s = 0.005"), text("wheel_drive.dbc", &profile.dbc.source.text)],
        ..LogContents::default()
    };
    let mut log = McapLog::create(&path, &contents, WhenFull::Wait).expect("the log begins");
    for tick in 0..1000_u64 {
        let at = Instant::from_nanos(tick as i64 * 5_000_000);
        let frame = Frame::classic(CanId::Standard(0x181), &[tick as u8, 2, 3, 4, 5, 6, 7, 8]);
        log.event(at, &Event::Frame(BusFrame { bus: 0, sent_by_stack: false, frame }));
        log.event(at, &Event::Tick(Tick { tick, state: if tick < 700 { 3 } else { 14 }, ..Tick::default() }));
        if tick == 700 {
            log.event(at, &Event::Notice(Notice { kind: "tripped", text: "tripped: <a wheel> & so on" }));
        }
    }
    log.finish().expect("the log ends");
    path
}

#[test]
fn a_log_of_a_stack_shows_its_way_and_every_signal_without_being_told_of_a_dbc() {
    let folder = tempfile::tempdir().expect("a folder");
    let page = page(&driven(folder.path()), &[Path::new("--bitrate"), Path::new("500000")]);
    for wanted in ["Track in the plane", "State of the stack", "RightFeedback", "TorqueApplied", "Bus load", "3.500"] {
        assert!(page.contains(wanted), "{wanted}");
    }
    assert!(page.contains("tripped: &lt;a wheel&gt; &amp; so on"));
    assert!(!page.contains("http://") || !page.contains("src="), "it asks for nothing from elsewhere");
}

#[test]
fn any_other_log_shows_what_is_on_its_buses() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bus.log");
    let line = |nth: u32| format!("({}.{:06}) can{} 181#{nth:08X}00000000\n", nth / 100, nth % 100 * 10_000, nth % 2);
    std::fs::write(&path, (0..500).map(line).collect::<String>()).expect("writable");
    let dbc = concat!(env!("CARGO_MANIFEST_DIR"), "/dbc/wheel_drive.dbc");
    let bare = page(&path, &[]);
    assert!(
        bare.contains("can0") && bare.contains("can1") && bare.contains("kbit/s") && !bare.contains("RightFeedback")
    );
    assert!(page(&path, &[Path::new("--dbc"), Path::new(dbc)]).contains("RightFeedback"));
}

#[test]
fn a_damaged_log_is_shown_as_far_as_it_goes_and_said_to_be() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = driven(folder.path());
    let whole = std::fs::read(&path).expect("the log");
    std::fs::write(&path, &whole[..whole.len() / 2]).expect("writable");
    let output = report(&[&path]);
    assert_eq!(output.status.code(), Some(2), "{}", told(&output));
    assert!(told(&output).contains("drive.mcap") && path.with_extension("html").exists(), "{}", told(&output));
    let output = report(&[Path::new("none.mcap")]);
    assert!(output.status.code() == Some(2) && told(&output).contains("cannot open none.mcap"), "{}", told(&output));
}
