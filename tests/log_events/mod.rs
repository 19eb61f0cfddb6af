//! Events of a made-up run, and the DBC of its buses, for the tests of logs.

use canloop::event::{BusFrame, Event, Mark, Notice, SyncEvent, Tick, Timing, Truth};
use canloop::frame::{CanId, Frame, FrameKind};
use canloop::robot::Pose;
use canloop::schema::Dbc;
use canloop::time::Instant;
use canloop::wheels::Wheels;

/// Every sort of signal, and names that protobuf or its readers trip over.
pub const DBC: &str = r#"VERSION ""
NS_ :
BS_:
BU_: Stack Drive

BO_ 385 Feedback: 8 Drive
 SG_ Position : 0|32@1- (1,0) [0|0] "counts" Stack
 SG_ Torque : 39|16@0- (0.005,-1.5) [0|0] "N m" Stack
 SG_ State : 48|4@1+ (1,0) [0|3] "" Stack
 SG_ Counter : 52|4@1+ (1,0) [0|15] "" Stack
 SG_ Crc : 56|8@1+ (1,0) [0|255] "" Stack

BO_ 2147484033 message: 8 Drive
 SG_ None : 0|64@1+ (1,0) [0|0] "" Stack

BO_ 130 fd: 8 Drive
 SG_ Speed1 : 0|32@1- (1,0) [0|0] "rad/s" Stack
 SG_ Speed_1 : 32|32@1- (0.001,0) [0|0] "rad/s" Stack

BO_ 131 Bits: 3 Drive
 SG_ B1 : 0|1@1+ (1,0) [0|0] "" Stack
 SG_ B2 : 1|1@1- (1,0) [0|0] "" Stack
 SG_ B3 : 2|1@1+ (1,0) [0|0] "" Stack
 SG_ B4 : 3|1@1+ (1,0) [0|0] "" Stack
 SG_ B5 : 4|1@1+ (1,0) [0|0] "" Stack
 SG_ B6 : 5|1@1+ (1,0) [0|0] "" Stack
 SG_ B7 : 6|1@1+ (1,0) [0|0] "" Stack
 SG_ B8 : 7|1@1+ (1,0) [0|0] "" Stack
 SG_ B9 : 8|1@1+ (1,0) [0|0] "" Stack
 SG_ B10 : 9|1@1+ (1,0) [0|0] "" Stack
 SG_ B11 : 10|1@1+ (1,0) [0|0] "" Stack
 SG_ B12 : 11|1@1+ (1,0) [0|0] "" Stack
 SG_ B13 : 12|1@1+ (1,0) [0|0] "" Stack
 SG_ B14 : 13|1@1+ (1,0) [0|0] "" Stack
 SG_ B15 : 14|1@1+ (1,0) [0|0] "" Stack
 SG_ B16 : 15|1@1+ (1,0) [0|0] "" Stack
 SG_ B17 : 23|8@0- (0.25,10) [0|0] "" Stack

BO_ 132 Wide: 24 Drive
 SG_ Single : 0|32@1- (1,0) [0|0] "" Stack
 SG_ Double : 64|64@1- (1,0) [0|0] "" Stack
 SG_ Last : 183|16@0+ (1,0) [0|0] "" Stack

BO_ 133 Modes: 6 Drive
 SG_ Mode M : 0|2@1+ (1,0) [0|0] "" Stack
 SG_ Always : 8|8@1+ (1,0) [0|0] "" Stack
 SG_ InOne m1 : 16|16@1- (1,0) [0|0] "" Stack
 SG_ InTwo m2 : 16|32@1+ (0.1,0) [0|0] "" Stack
 SG_ InThree m3 : 16|32@1- (1,0) [0|0] "" Stack

CM_ SG_ 385 Position "Latched at SYNC.";
VAL_ 385 State 0 "Boot" 1 "Ready" 2 "Enabled" 3 "Fault" ;
SIG_VALTYPE_ 130 Speed1 : 1;
SIG_VALTYPE_ 132 Single : 1;
SIG_VALTYPE_ 132 Double : 2;
VAL_ 133 Mode 0 "Nothing" ;
"#;

/// The DBC, parsed.
pub fn dbc() -> Dbc {
    Dbc::parse(&canloop::config::Source::new("made_up.dbc", DBC)).expect("the DBC of the tests is right")
}

/// `periods` milliseconds of events, the first frame 5 ms before the origin.
pub fn events(periods: u64) -> Vec<(Instant, Event)> {
    let mut random = Random(7);
    let early = received(Frame::classic(CanId::Standard(385), &[1; 8]));
    let mut events = vec![(Instant::from_nanos(-5_000_001), early)];
    for tick in 0..periods {
        let start = tick as i64 * 1_000_000;
        let mut at = |nanos: i64, event| events.push((Instant::from_nanos(start + nanos), event));
        at(0, Event::Sync(SyncEvent { tick, ..SyncEvent::default() }));
        for (order, frame) in frames(tick, &mut random).into_iter().enumerate() {
            let event = if order % 2 == 0 { received(frame) } else { sent(frame) };
            at(1 + 50_000 * order as i64, event);
        }
        at(500_000, Event::Tick(stack(tick, &mut random)));
        at(999_999, Event::Truth(truth(tick, &mut random)));
        at(999_999, Event::Timing(Timing { tick, lateness_s: 1e-5, round_trip_s: 3e-4, ..Timing::default() }));
        if tick % 100 == 18 {
            at(999_999, Event::Mark(Mark { event: (tick % 200 > 100).into(), has_begun: tick % 300 > 100 }));
        }
        if tick % 100 == 17 {
            at(999_999, Event::Notice(Notice { kind: "tripped", text: "The robot stopped: Räder blockiert." }));
        }
    }
    events
}

/// A frame that the stack received.
pub fn received(frame: Frame) -> Event {
    Event::Frame(BusFrame { bus: 0, sent_by_stack: false, frame })
}

fn sent(frame: Frame) -> Event {
    Event::Frame(BusFrame { bus: 1, sent_by_stack: true, frame })
}

fn frames(tick: u64, random: &mut Random) -> Vec<Frame> {
    let mut remote = Frame::zeroed(CanId::Standard(385), 8);
    remote.kind = FrameKind::Remote;
    let mut wide = Frame::zeroed(CanId::Standard(132), 24);
    wide.payload_mut().copy_from_slice(&random.bytes::<24>());
    wide.kind = if tick.is_multiple_of(2) { FrameKind::Fd } else { FrameKind::FdBitRateSwitch };
    let too_short = Frame::classic(CanId::Standard(131), &random.bytes::<2>());
    let unknown = Frame::classic(CanId::Standard(0x7FF), &random.bytes::<3>());
    let mut frames = vec![
        Frame::classic(CanId::Standard(385), &random.bytes::<8>()),
        Frame::classic(CanId::Extended(385), &random.bytes::<8>()),
        Frame::classic(CanId::Standard(130), &random.bytes::<8>()),
        Frame::classic(CanId::Standard(131), &random.bytes::<3>()),
    ];
    if tick.is_multiple_of(10) {
        frames.push(Frame::classic(CanId::Standard(133), &random.bytes::<6>()));
        frames.extend([remote, wide, too_short, unknown, Frame::zeroed(CanId::Standard(131), 3)]);
    }
    frames
}

fn stack(tick: u64, random: &mut Random) -> Tick {
    let pose = Pose { x_m: random.number(), y_m: 0.0, heading_rad: random.number() };
    Tick { tick, state: 3, odometry: pose, torque_sent_nm: random.pair(), ..Tick::default() }
}

fn truth(tick: u64, random: &mut Random) -> Truth {
    Truth { tick, angle_rad: random.pair(), torque_nm: random.pair(), ..Truth::default() }
}

/// Knuth's linear congruential generator.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 32
    }

    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        std::array::from_fn(|_| self.next() as u8)
    }

    fn number(&mut self) -> f64 {
        self.next() as f64 / 1e9 - 2.0
    }

    fn pair(&mut self) -> Wheels<f64> {
        Wheels { right: self.number(), left: self.number() }
    }
}
