//! `canloop log` keeps what is on buses, whatever happens to it.

#[path = "../tcp_bus/mod.rs"]
mod tcp_bus;

mod crash;
mod rig;

use canloop::bus::Bus as _;
use canloop::frame::{CanId, Frame, FrameKind};

use rig::{Logging, frames_in, python_reads, python_reads_so_far};
use tcp_bus::{RunningHub, classic_frames, numbered};

#[test]
fn every_frame_of_every_bus_is_kept_raw_and_decoded() {
    let hubs = [RunningHub::start(), RunningHub::named("can1")];
    let dbc = concat!(env!("CARGO_MANIFEST_DIR"), "/dbc/wheel_drive.dbc");
    let mut logging = Logging::start(&[(&hubs[0], "can0"), (&hubs[1], "can1")], &["--dbc", dbc]);
    let mut senders = hubs.each_ref().map(RunningHub::join);
    for frame in classic_frames() {
        senders[0].send(&frame).expect("there is room");
    }
    let feedback = Frame::classic(CanId::Standard(0x181), &[1, 2, 3, 4, 5, 6, 7, 8]);
    let mut fd = Frame::zeroed(CanId::Extended(0x1234), 48);
    fd.kind = FrameKind::FdBitRateSwitch;
    for frame in [feedback, fd] {
        senders[1].send(&frame).expect("there is room");
    }
    logging.wait_for_frames(classic_frames().len() + 2);
    assert!(python_reads_so_far(&logging.path("bus.mcap")) >= classic_frames().len());
    let run = logging.interrupt();
    assert!(run.contains("can0: ") && run.contains(" 0 lost on the way, 0 lost here"), "{run}");
    let log = logging.path("bus.mcap");
    let found = frames_in(&log);
    assert_eq!(found.of("can0"), classic_frames());
    assert_eq!(found.of("can1"), [feedback, fd]);
    let topics = python_reads(&log);
    for topic in ["/can/can0", "/can/can1", "/can/can1/fd", "/can/can1/RightFeedback"] {
        assert!(topics.contains(&topic.to_owned()), "{topic} is missing: {topics:?}");
    }
}

#[test]
fn a_filter_is_candump_s() {
    let hub = RunningHub::start();
    let mut logging = Logging::start(&[(&hub, "can0")], &["--filter", "100:7F0,400~7FF,j"]);
    let mut sender = hub.join();
    let frames: Vec<Frame> = [0x0FF, 0x100, 0x10A, 0x400, 0x10F].into_iter().map(|id| numbered(id, 1)).collect();
    frames.iter().for_each(|frame| sender.send(frame).expect("there is room"));
    logging.wait_for_frames(3);
    logging.interrupt();
    assert_eq!(frames_in(&logging.path("bus.mcap")).of("can0"), [frames[1], frames[2], frames[4]]);
}

#[test]
fn a_log_goes_on_in_another_file_without_losing_a_frame() {
    let hub = RunningHub::start();
    let mut logging = Logging::start(&[(&hub, "can0")], &["--rotate-mb", "1"]);
    let mut sender = hub.join();
    let mut sent = 0;
    while logging.files().len() < 3 {
        for _ in 0..1000 {
            // Numbers that no compression makes small.
            let noise = (sent as u32).wrapping_mul(2_654_435_761);
            rig::send(
                &mut sender,
                &Frame::classic(CanId::Standard(1), &[(sent as u32).to_be_bytes(), noise.to_be_bytes()].concat()),
            );
            sent += 1;
        }
        logging.wait_for_frames(0);
    }
    logging.wait_for_frames(sent);
    logging.interrupt();
    let mut numbers = Vec::new();
    for file in logging.files() {
        python_reads(&file);
        numbers.extend(frames_in(&file).numbers("can0"));
    }
    assert_eq!(numbers, (0..sent as u32).collect::<Vec<_>>());
}

#[test]
fn a_bus_that_goes_away_is_said_and_what_it_brought_is_kept() {
    let hub = RunningHub::start();
    let mut logging = Logging::start(&[(&hub, "can0")], &[]);
    let mut sender = hub.join();
    sender.send(&numbered(1, 7)).expect("there is room");
    logging.wait_for_frames(1);
    drop(sender);
    hub.stop();
    let (status, told) = logging.end();
    assert_eq!(status, Some(1), "{told}");
    assert!(told.contains("is gone"), "{told}");
    assert_eq!(frames_in(&logging.path("bus.mcap")).numbers("can0"), [7]);
}

#[test]
fn a_full_disk_is_said_and_what_was_written_can_be_read() {
    let hub = RunningHub::start();
    // The shell's limit on the size of a file, in blocks of 1 KiB or 512 bytes.
    let mut logging = Logging::start_limited(&[(&hub, "can0")], 400);
    let mut sender = hub.join();
    let mut number = 0_u32;
    while logging.is_running() {
        let noise = number.wrapping_mul(2_654_435_761).to_be_bytes();
        rig::send(&mut sender, &Frame::classic(CanId::Standard(1), &[number.to_be_bytes(), noise].concat()));
        number += 1;
    }
    let (status, told) = logging.end();
    assert_eq!(status, Some(2), "{told}");
    assert!(told.contains("cannot go on writing") && told.contains("canloop repair"), "{told}");
    logging.repair("bus.mcap");
    let numbers = frames_in(&logging.path("bus.mcap")).numbers("can0");
    assert_eq!(numbers, (0..numbers.len() as u32).collect::<Vec<_>>());
    assert!(numbers.len() > 1000, "{}", numbers.len());
}

#[test]
fn bad_input_is_refused_before_anything_is_written() {
    let hub = RunningHub::start();
    let address = format!("tcp://{}/can0", hub.address);
    let bus = ["--bus", address.as_str()];
    let output = ["-o", "bus.mcap"];
    let cases: [(Vec<&str>, &str); 7] = [
        ([bus.as_slice(), &["-o", "bus.log"]].concat(), "no name for an MCAP file"),
        ([bus.as_slice(), &output, &["--filter", "12"]].concat(), "expected ID:MASK"),
        ([bus.as_slice(), &bus, &output].concat(), "two of the buses are called can0"),
        ([bus.as_slice(), &output, &["--dbc", "none.dbc"]].concat(), "cannot read none.dbc"),
        ([["--bus", "nothing at all"].as_slice(), &output].concat(), "is no bus"),
        ([bus.as_slice(), &["-o", "/nowhere/bus.mcap"]].concat(), "cannot create the log /nowhere/bus.mcap"),
        ([bus.as_slice(), &output, &["--rotate-s", "0"]].concat(), "--rotate-s"),
    ];
    for (args, says) in cases {
        let folder = tempfile::tempdir().expect("a folder");
        let run = rig::canloop(&["log"]).args(&args).current_dir(&folder).output().expect("the program");
        let told = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.code() == Some(2) && told.contains(says), "{args:?}: {told}");
        assert_eq!(std::fs::read_dir(&folder).expect("the folder").count(), 0, "{args:?}");
    }
}
