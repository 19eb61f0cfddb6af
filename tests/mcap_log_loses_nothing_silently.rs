//! A log that could not be written as fast, as long or as completely as it
//! should says so, and keeps what it has.

mod log_events;

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{JoinHandle, spawn};
use std::time::Duration;

use canloop::event::{Event, Sink, Tick};
use canloop::frame::{CanId, Frame};
use canloop::log::{LogContents, LogError, LoggedBus, McapLog, WhenFull};
use canloop::time::Instant;
use mcap::{MessageStream, Summary};

#[test]
fn what_finds_no_room_is_counted_in_report_and_file() {
    let pipe = Pipe::new();
    let mut log = create(&pipe.path, WhenFull::Drop);
    let events = log_events::events(14_000);
    let (before, after) = events.split_at(events.len() - 2_000);
    before.iter().for_each(|(at, event)| log.event(*at, event));
    pipe.let_flow();
    wait_for_the_thread();
    after.iter().for_each(|(at, event)| log.event(*at, event));
    let report = log.finish().expect("a slow disk is no error");
    let bytes = pipe.content();

    assert!(report.events_lost > 100, "the pipe took everything: {report:?}");
    let logged = Logged::from(&bytes);
    let given = events.iter().filter(|(_, event)| !matches!(event, Event::Sync(_))).count() as u64;
    assert_eq!(logged.events + report.events_lost, given);
    assert_eq!(logged.losses_noticed, report.events_lost, "the log itself should say where events are missing");
    assert_eq!(losses_in_metadata(&bytes), report.events_lost.to_string());
    let last = logged.last.expect("messages");
    assert_eq!(last, events[events.len() - 1].0, "the log should go on after the loss");
}

#[test]
fn a_simulation_waits_and_loses_nothing() {
    let pipe = Pipe::new();
    let mut log = create(&pipe.path, WhenFull::Wait);
    let events = log_events::events(3_000);
    pipe.let_flow_after(Duration::from_millis(50));
    events.iter().for_each(|(at, event)| log.event(*at, event));
    let report = log.finish().expect("a slow disk is no error");
    assert!(report.waits > 0 && report.events_lost == 0, "{report:?}");
    let given = events.iter().filter(|(_, event)| !matches!(event, Event::Sync(_))).count() as u64;
    assert_eq!(Logged::from(&pipe.content()).events, given);
}

#[test]
fn a_frame_of_a_bus_that_the_log_was_not_told_of_is_counted() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut log =
        McapLog::create(&folder.path().join("run.mcap"), &LogContents::default(), WhenFull::Wait).expect("a log");
    log.event(Instant::ZERO, &log_events::received(Frame::zeroed(CanId::Standard(1), 1)));
    log.event(Instant::ZERO, &Event::Tick(Tick::default()));
    let report = log.finish().expect("the log ends");
    assert_eq!((report.messages, report.events_lost), (1, 1));
}

#[test]
fn a_log_dropped_without_finish_is_complete() {
    let folder = tempfile::tempdir().expect("a folder");
    let events = log_events::events(100);
    let [finished, dropped] = ["finished.mcap", "dropped.mcap"].map(|name| folder.path().join(name));
    for path in [&finished, &dropped] {
        let mut log = create(path, WhenFull::Wait);
        events.iter().for_each(|(at, event)| log.event(*at, event));
        if path == &finished {
            log.finish().expect("the log ends");
        }
    }
    assert!(std::fs::read(finished).expect("a log") == std::fs::read(dropped).expect("a log"));
}

#[test]
fn a_log_cut_anywhere_gives_every_whole_chunk() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.mcap");
    let mut log = create(&path, WhenFull::Wait);
    log_events::events(3_000).iter().for_each(|(at, event)| log.event(*at, event));
    log.finish().expect("the log ends");
    let bytes = std::fs::read(&path).expect("the log");
    let all: Vec<_> =
        MessageStream::new(&bytes).expect("a log").map(|message| message.expect("whole").log_time).collect();
    let chunks = Summary::read(&bytes).expect("a summary").expect("a summary").chunk_indexes;
    assert!(chunks.len() > 2, "too few chunks to say much");

    // Steps by a prime, so that cuts fall into every sort of record.
    for cut in (1_000..bytes.len()).step_by(20_011) {
        let ends = chunks.iter().map(|chunk| chunk.chunk_start_offset + chunk.chunk_length);
        let whole = ends.filter(|&end| end <= cut as u64).count();
        let start_of_lost = chunks.get(whole).map_or(u64::MAX, |chunk| chunk.message_start_time);
        let read: Vec<_> = MessageStream::new(&bytes[..cut]).expect("a log").map_while(Result::ok).collect();
        let read: Vec<_> = read.into_iter().map(|message| message.log_time).collect();
        assert!(all.starts_with(&read), "cut at {cut}: other messages than before");
        assert!(all.get(read.len()).is_none_or(|&next| next >= start_of_lost), "cut at {cut}: {} read", read.len());
    }
}

#[test]
fn a_log_that_cannot_be_begun_says_so() {
    let missing = Path::new("/no/such/folder/run.mcap");
    let Err(error) = McapLog::create(missing, &LogContents::default(), WhenFull::Wait) else {
        panic!("it was created")
    };
    let text = error.to_string();
    assert!(text.contains("/no/such/folder/run.mcap") && text.contains("No such file"), "{text}");
}

#[test]
fn a_reader_that_goes_away_is_an_error_at_the_end_and_no_panic() {
    let pipe = Pipe::new();
    let mut log = create(&pipe.path, WhenFull::Wait);
    drop(pipe);
    log_events::events(5_000).iter().for_each(|(at, event)| log.event(*at, event));
    assert!(log.failed(), "a program should learn of it before the end");
    let Err(LogError::Write { source, .. }) = log.finish() else { panic!("no error") };
    assert_eq!(source.kind(), io::ErrorKind::BrokenPipe);
}

/// Runs itself again under a limit of file size, which is the nearest thing
/// to a full disk that needs no rights.
#[test]
fn a_full_disk_is_an_error_and_what_it_took_can_be_read() {
    const LIMIT: u64 = 600 * 1024;
    if let Some(path) = std::env::var_os("CANLOOP_TEST_LOG_UNDER_LIMIT") {
        return fill_the_disk(Path::new(&path));
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.mcap");
    let test = std::env::current_exe().expect("this program");
    // Without the trap the system would kill the program instead of refusing the write.
    let limited = format!("trap '' XFSZ; ulimit -f {}; exec \"$0\" --exact \"$1\"", LIMIT / 1024);
    let child = Command::new("bash")
        .args(["-c", &limited])
        .arg(test)
        .arg("a_full_disk_is_an_error_and_what_it_took_can_be_read")
        .env("CANLOOP_TEST_LOG_UNDER_LIMIT", &path)
        .output()
        .expect("bash runs");
    assert!(child.status.success(), "{}", String::from_utf8_lossy(&child.stdout));

    let bytes = std::fs::read(&path).expect("the log");
    assert!(bytes.len() as u64 <= LIMIT);
    let messages = MessageStream::new(&bytes).expect("a log").map_while(Result::ok).count();
    assert!(messages > 5_000, "{messages} messages");
    assert_eq!(end_of_last_whole_record(&bytes), bytes.len(), "part of a record is left at the end");
}

/// What the limited program does.
fn fill_the_disk(path: &Path) {
    let mut log = create(path, WhenFull::Wait);
    log_events::events(5_000).iter().for_each(|(at, event)| log.event(*at, event));
    assert!(log.failed());
    let Err(error) = log.finish() else { panic!("no error") };
    assert!(error.to_string().contains("File too large"), "{error}");
}

fn create(path: &Path, when_full: WhenFull) -> McapLog {
    let dbc = log_events::dbc();
    let bus = |name| LoggedBus { name, dbcs: vec![&dbc] };
    let contents = LogContents { buses: vec![bus("can0"), bus("can1")], ..LogContents::default() };
    McapLog::create(path, &contents, when_full).expect("the log begins")
}

#[allow(clippy::disallowed_methods, reason = "the test waits for the log's thread")]
fn wait_for_the_thread() {
    std::thread::sleep(Duration::from_secs(1));
}

/// Every record is an opcode, the length of the rest as 8 bytes, and the rest.
fn end_of_last_whole_record(bytes: &[u8]) -> usize {
    let mut end = mcap::MAGIC.len();
    while let Some(len) = bytes.get(end + 1..end + 9) {
        let next = end + 9 + u64::from_le_bytes(len.try_into().expect("8 bytes")) as usize;
        if next > bytes.len() {
            break;
        }
        end = next;
    }
    end
}

fn losses_in_metadata(bytes: &[u8]) -> String {
    let summary = Summary::read(bytes).expect("a summary").expect("a summary");
    let index = summary.metadata_indexes.iter().find(|index| index.name == "canloop.log").expect("counts at the end");
    mcap::read::metadata(bytes, index).expect("metadata").metadata["events_lost"].clone()
}

/// What a log has, counted.
#[derive(Default)]
struct Logged {
    /// Messages, without decoded frames and what the log says of itself.
    events: u64,
    /// How many events are missing, going by its notices.
    losses_noticed: u64,
    last: Option<Instant>,
}

impl Logged {
    fn from(bytes: &[u8]) -> Self {
        let mut logged = Self::default();
        for message in MessageStream::new(bytes).expect("a log") {
            let message = message.expect("a message");
            let text = String::from_utf8_lossy(&message.data);
            let topic = message.channel.topic.as_str();
            if let Some(before) = text.find(" events are not in this log") {
                let digits = text[..before].rsplit(|c: char| !c.is_ascii_digit()).next().expect("a number");
                logged.losses_noticed += digits.parse::<u64>().expect("a number");
                continue;
            }
            let raw = ["/can/can0", "/can/can1", "/can/can0/fd", "/can/can1/fd"].contains(&topic);
            logged.events += u64::from(raw || topic.starts_with("/canloop/"));
            logged.last = Some(Instant::from_nanos(message.log_time as i64));
        }
        logged
    }
}

/// A named pipe whose reader reads nothing until it is let.
struct Pipe {
    path: PathBuf,
    flow: Sender<Duration>,
    reader: JoinHandle<Vec<u8>>,
    _folder: tempfile::TempDir,
}

impl Pipe {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("pipe");
        assert!(Command::new("mkfifo").arg(&path).status().expect("mkfifo runs").success());
        let (flow, may_flow) = channel();
        let from = path.clone();
        let reader = spawn(move || read_when_let(&from, &may_flow));
        Self { path, flow, reader, _folder: folder }
    }

    fn let_flow(&self) {
        self.let_flow_after(Duration::ZERO);
    }

    fn let_flow_after(&self, wait: Duration) {
        self.flow.send(wait).expect("the reader waits");
    }

    fn content(self) -> Vec<u8> {
        self.reader.join().expect("the reader ends")
    }
}

/// Nothing if it is never let.
#[allow(clippy::disallowed_methods, reason = "it is there to be slow")]
fn read_when_let(from: &Path, may_flow: &Receiver<Duration>) -> Vec<u8> {
    let mut pipe = File::open(from).expect("the pipe opens");
    let mut content = Vec::new();
    if let Ok(wait) = may_flow.recv() {
        std::thread::sleep(wait);
        pipe.read_to_end(&mut content).expect("the pipe is read");
    }
    content
}
