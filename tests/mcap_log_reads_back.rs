//! What goes into a log comes out of it, with the readers that others wrote.

mod log_events;

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;
use std::process::Command;

use canloop::event::{Event, Mark, Sink, Tick, Timing, Truth};
use canloop::frame::FrameKind;
use canloop::log::{LogContents, LogReport, LoggedBus, McapLog, WhenFull};
use canloop::time::Instant;
use mcap::records::Record;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use serde_json::{Value, json};

/// Long enough for several batches and chunks.
const PERIODS: u64 = 2_500;

#[test]
fn python_readers_and_cantools_find_what_was_written() {
    let folder = tempfile::tempdir().expect("a folder for the log");
    let log = folder.path().join("run.mcap");
    let report = write(&log, &log_events::events(PERIODS));
    assert_eq!(report.events_lost, 0);

    let dbc = folder.path().join("made_up.dbc");
    std::fs::write(&dbc, log_events::DBC).expect("the DBC is written");
    let expected = folder.path().join("expected.jsonl");
    let mut lines = std::fs::File::create(&expected).expect("a file");
    for (at, event) in log_events::events(PERIODS) {
        if let Some(line) = expectation(at, &event) {
            writeln!(lines, "{line}").expect("the line is written");
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let checked = Command::new(root.join("scripts/python"))
        .arg(root.join("tests/mcap_log_reads_back.py"))
        .args([&log, &dbc, &expected])
        .output()
        .expect("scripts/python runs");
    let (out, err) = (String::from_utf8_lossy(&checked.stdout), String::from_utf8_lossy(&checked.stderr));
    assert!(checked.status.success(), "{out}{err}");
    assert!(out.contains(&format!("{} messages", report.messages)), "{out}");
}

#[test]
fn the_rust_reader_finds_every_checksum_right() {
    let bytes = written(&log_events::events(PERIODS));
    let options = LinearReaderOptions::default()
        .with_validate_chunk_crcs(true)
        .with_prevalidate_chunk_crcs(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true);
    let mut reader = LinearReader::new_with_options(options);
    let (mut rest, mut messages) = (bytes.as_slice(), 0);
    while let Some(event) = reader.next_event() {
        match event.expect("the file is right") {
            LinearReadEvent::ReadRequest(wanted) => {
                let (now, later) = rest.split_at(wanted.min(rest.len()));
                reader.insert(now.len()).copy_from_slice(now);
                reader.notify_read(now.len());
                rest = later;
            }
            LinearReadEvent::Record { opcode, data } => match mcap::parse_record(opcode, data).expect("a record") {
                Record::Message { .. } => messages += 1,
                // A checksum of 0 would mean that there is none.
                Record::DataEnd(end) => assert_ne!(end.data_section_crc, 0),
                Record::Footer(footer) => assert_ne!(footer.summary_crc, 0),
                _ => {}
            },
        }
    }
    let summary = mcap::Summary::read(&bytes).expect("the summary is right").expect("there is a summary");
    assert_eq!(messages, summary.stats.expect("there are statistics").message_count);
    let attachment = mcap::read::attachment(&bytes, &summary.attachment_indexes[0]).expect("its checksum is right");
    assert_eq!(attachment.data.as_ref(), log_events::DBC.as_bytes());
}

#[test]
fn every_entry_of_the_index_leads_to_its_message() {
    let bytes = written(&log_events::events(PERIODS));
    let summary = mcap::Summary::read(&bytes).expect("the summary is right").expect("there is a summary");
    assert!(summary.chunk_indexes.len() > 2, "too few chunks to say much");
    let mut messages = 0;
    for chunk in &summary.chunk_indexes {
        for (channel, entries) in summary.read_message_indexes(&bytes, chunk).expect("an index behind the chunk") {
            // Each lookup inflates the chunk again, so not all of them.
            for entry in [entries.first(), entries.get(entries.len() / 2), entries.last()].into_iter().flatten() {
                let message = summary.seek_message(&bytes, chunk, entry).expect("a message where the index says");
                assert_eq!((message.channel.id, message.log_time), (channel.id, entry.log_time));
            }
            messages += entries.len() as u64;
        }
    }
    assert_eq!(messages, summary.stats.expect("there are statistics").message_count);
}

#[test]
fn the_same_events_give_the_same_bytes() {
    let events = log_events::events(PERIODS);
    assert!(written(&events) == written(&events));
}

#[test]
fn a_log_of_nothing_is_a_log() {
    let bytes = written(&[]);
    let summary = mcap::Summary::read(&bytes).expect("the summary is right").expect("there is a summary");
    assert_eq!(summary.stats.expect("there are statistics").message_count, 0);
    assert_eq!(summary.attachment_indexes.len(), 1);
    assert_eq!(mcap::MessageStream::new(&bytes).expect("a log").count(), 0);
}

/// The bytes of a log of `events`.
fn written(events: &[(Instant, Event)]) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder for the log");
    let path = folder.path().join("run.mcap");
    write(&path, events);
    std::fs::read(path).expect("the log is there")
}

fn write(path: &Path, events: &[(Instant, Event)]) -> LogReport {
    let dbc = log_events::dbc();
    let contents = LogContents {
        buses: vec![LoggedBus { name: "can0", dbcs: vec![&dbc] }, LoggedBus { name: "can 1", dbcs: vec![&dbc] }],
        attachments: vec![("made_up.dbc".to_owned(), "text/plain".to_owned(), log_events::DBC.into())],
        planned: vec!["a push".to_owned()],
        metadata: BTreeMap::from([("version".to_owned(), "1.2.3".to_owned())]),
    };
    let mut log = McapLog::create(path, &contents, WhenFull::Wait).expect("the log begins");
    events.iter().for_each(|(at, event)| log.event(*at, event));
    log.finish().expect("the log ends")
}

/// What a reader should find of an event, apart from decoded signals.
fn expectation(at: Instant, event: &Event) -> Option<Value> {
    let (topic, value) = match event {
        Event::Frame(on_bus) => {
            let (frame, bus) = (&on_bus.frame, ["can0", "can 1"][usize::from(on_bus.bus)]);
            let fd = matches!(frame.kind, FrameKind::Fd | FrameKind::FdBitRateSwitch);
            let value = json!({
                "bus": bus,
                "id": frame.id.raw(),
                "is_extended": frame.id.is_extended(),
                "is_rtr": frame.kind == FrameKind::Remote,
                "bit_rate_switch": frame.kind == FrameKind::FdBitRateSwitch,
                "sent": on_bus.sent_by_stack,
                "data": frame.payload(),
            });
            (format!("/can/{bus}{}", if fd { "/fd" } else { "" }), value)
        }
        Event::Sync(_) => return None,
        Event::Tick(tick) => ("/canloop/stack".to_owned(), json!(by_name(&Tick::NAMES, &tick.values()))),
        Event::Truth(truth) => ("/canloop/truth".to_owned(), json!(by_name(&Truth::NAMES, &truth.values()))),
        Event::Timing(timing) => ("/canloop/loop".to_owned(), json!(by_name(&Timing::NAMES, &timing.values()))),
        Event::Notice(notice) => ("/canloop/notices".to_owned(), json!({"name": notice.kind, "message": notice.text})),
        Event::Mark(Mark { event, has_begun }) => {
            let name = if *event == 0 { "a push" } else { "an event" };
            let message = format!("{name} {}", if *has_begun { "begins" } else { "ends" });
            ("/canloop/notices".to_owned(), json!({"name": "event", "message": message}))
        }
        Event::Exchange(exchange) => ("/canloop/exchange".to_owned(), json!({"what": exchange.word()})),
    };
    Some(json!({"topic": topic, "at": at.as_nanos(), "value": value}))
}

fn by_name<'a>(names: &[&'a str], values: &[f64]) -> BTreeMap<&'a str, f64> {
    names.iter().copied().zip(values.iter().copied()).collect()
}
