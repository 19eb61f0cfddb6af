//! Somebody else on the bus sends what he likes, as fast as he can. What is
//! nobody's business changes nothing; what is sent in a drive's name, corrupt
//! or not, stops the robot, and it stays stopped.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use canloop::bus::{Arrival, BusError, OpenOptions, open};
use canloop::frame::{CanId, Frame, FrameKind};
use canloop::run::Clock;
use canloop::schema::{Message, Profile};
use canloop::time::Duration;

use crate::rig::{Run, python};
use crate::two_programs::Bench;

const FOR_4_S: [&str; 2] = ["--set", "duration_s=4"];

/// A client of the bus that sends frames until it is told to stop.
struct Troublemaker {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<u64>,
}

impl Troublemaker {
    /// Sends what `next` makes of each frame that it has heard, or of none.
    fn start(address: &str, mut next: impl FnMut(Option<Frame>) -> Option<Frame> + Send + 'static) -> Self {
        let (clock, stop) = (Clock::new(), Arc::new(AtomicBool::new(false)));
        let mut bus = open(address, &OpenOptions::default(), clock).unwrap_or_else(|problem| panic!("{problem}"));
        let stopped = stop.clone();
        let thread = std::thread::spawn(move || {
            let mut sent = 0;
            while !stopped.load(Ordering::Relaxed) {
                let heard = match bus.receive(clock.now() + Duration::from_micros(20)) {
                    Ok(Some((_, Arrival::Frame(frame)))) => Some(frame),
                    Ok(_) => None,
                    Err(_) => break,
                };
                match next(heard).map_or(Err(BusError::Full), |frame| bus.send(&frame)) {
                    Ok(()) => sent += 1,
                    Err(BusError::Full) => {}
                    Err(_) => break,
                }
            }
            sent
        });
        Self { stop, thread }
    }

    /// Stops it; gives the number of frames that it sent.
    fn stop(self) -> u64 {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().expect("it does not panic")
    }
}

/// Numbers without a pattern (Marsaglia's xorshift).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// A frame of any kind, length and contents; half of them with one of
    /// these ids.
    fn frame(&mut self, ids: &[u16]) -> Frame {
        let number = self.next();
        let id = match number % 4 {
            0 => CanId::Standard((self.next() % 0x800) as u16),
            1 => CanId::Extended((self.next() % 0x2000_0000) as u32),
            _ => CanId::Standard(ids[self.next() as usize % ids.len()]),
        };
        let mut frame = Frame::zeroed(id, (self.next() % 9) as usize);
        frame.kind = match self.next() % 8 {
            0 => FrameKind::Remote,
            1 => FrameKind::Fd,
            _ => FrameKind::Classic,
        };
        if frame.kind != FrameKind::Remote {
            let bytes = self.next().to_le_bytes();
            frame.payload_mut().iter_mut().zip(bytes).for_each(|(byte, noise)| *byte = noise);
        }
        frame
    }
}

/// Ids of what the stack sends, and that of the marker.
const STACK_IDS: [u16; 4] = [128, 513, 514, 2046];
/// Ids of what drives send.
const DRIVE_IDS: [u16; 6] = [129, 130, 385, 386, 1793, 1794];

const MARKER: CanId = CanId::Standard(2046);

#[test]
fn what_is_nobody_s_business_or_a_corrupt_frame_of_the_stack_changes_no_frame_of_the_run() {
    let bench = Bench::over_tcp();
    let run = bench.rig.hil_sim(&[["run", "dac-friction", "--no-log", "--out", "alone"].as_slice(), &FOR_4_S].concat());
    run.expect_status(0);
    let serve = bench.serve(&[["--no-log"].as_slice(), &FOR_4_S].concat());
    let (profile, mut noise) = (Profile::builtin("wheel_drive").expect("it is built in"), Noise(1));
    let troublemaker = Troublemaker::start(bench.address(), move |_| {
        let frame = noise.frame(&STACK_IDS);
        let passes = profile.decode(&frame).is_ok() || (frame.id == MARKER && frame.len() == 5);
        (!passes && !profile.is_sent_by_drives(frame.id)).then_some(frame)
    });
    let drive = bench.drive(&[]).finish().expect_status(0);
    let sent = troublemaker.stop();
    let serve = serve.finish().expect_status(0);
    assert!(sent > 1000, "{sent} frames are not much");
    assert!(serve.stdout.contains("frames that were corrupt or not meant for the drives"), "{}", serve.stdout);
    assert!(drive.stdout.contains("could not be decoded") && !drive.stdout.contains("tripped"), "{}", drive.stdout);
    assert_eq!(bench.rig.summary("runs")["frames_blake3"], bench.rig.summary("alone")["frames_blake3"]);
}

#[test]
fn corrupt_frames_in_the_drives_names_stop_the_robot_for_good() {
    let (profile, mut noise) = (Profile::builtin("wheel_drive").expect("it is built in"), Noise(2));
    let drive = drive_beside_trouble(move |_| {
        let frame = noise.frame(&DRIVE_IDS);
        profile.decode(&frame).is_err().then_some(frame)
    });
    assert!(drive.stdout.contains("tripped: too many frames of the drives were damaged"), "{}", drive.stdout);
}

#[test]
fn replayed_feedback_stops_the_robot_for_good() {
    let drive = drive_beside_a_replay(|message| matches!(message, Message::Feedback(..)));
    assert!(drive.stdout.contains("tripped: a drive's feedback counted further"), "{}", drive.stdout);
}

#[test]
fn a_second_sender_of_sync_stops_the_robot_for_good() {
    let drive = drive_beside_a_replay(|message| matches!(message, Message::Sync { .. }));
    assert!(drive.stdout.contains("tripped: "), "{}", drive.stdout);
}

#[test]
fn replayed_faults_and_heartbeats_and_all_else_stop_the_robot_for_good() {
    let drive = drive_beside_a_replay(|_| true);
    assert!(drive.stdout.contains("tripped: "), "{}", drive.stdout);
}

/// Drives while somebody sends again and again the last frames that he heard
/// and that `are_wanted`. The robot has to trip and to stay so.
#[track_caller]
fn drive_beside_a_replay(are_wanted: fn(&Message) -> bool) -> Run {
    let profile = Profile::builtin("wheel_drive").expect("it is built in");
    let (mut heard, mut number) = (Vec::new(), 0);
    drive_beside_trouble(move |frame| {
        let wanted = frame.filter(|frame| heard.len() < 100 && profile.decode(frame).is_ok_and(|m| are_wanted(&m)));
        heard.extend(wanted);
        number += 1;
        (heard.len() == 100).then(|| heard[number % 100])
    })
}

/// Drives, and once the robot is under way somebody sends what `next` makes of
/// each frame that he has heard. The robot has to trip and to stay so.
#[track_caller]
fn drive_beside_trouble(next: impl FnMut(Option<Frame>) -> Option<Frame> + Send + 'static) -> Run {
    let bench = Bench::over_tcp();
    let mut serve = bench.serve(&["--set", "duration_s=1e4", "--dead-man-s", "3"]);
    let drive = bench.drive(&["--log", "drive.mcap", "--dead-man-s", "3"]);
    serve.wait_for_bytes(&bench.rig.path("runs/run.mcap"), 300_000);
    let troublemaker = Troublemaker::start(bench.address(), next);
    serve.wait_until("the robot trips", |_| drive.told().contains("tripped"));
    // A replayed enable must not bring motion back either.
    let size = bench.rig.path("runs/run.mcap").metadata().expect("there is a log").len();
    serve.wait_for_bytes(&bench.rig.path("runs/run.mcap"), size + 100_000);
    drive.signal("TERM");
    let drive = drive.finish().expect_status(1);
    assert!(troublemaker.stop() > 100);
    python("real_bus/stays_tripped.py", &[&bench.rig.path("drive.mcap")]);
    drop(serve);
    drive
}
