//! Traffic made up at random.

use canloop::frame::{CanId, Frame, FrameKind};
use canloop::time::Instant;
use canloop::traffic::{Buses, Content, Direction, ErrorFrame, Record, RecordedFrame};
use proptest::prelude::*;

use crate::rig::Log;

/// Names as other people give them, too.
const BUSES: [&str; 5] = ["can0", "can1", "vcan0", "Powertrain, front", "can7"];

/// A log of up to `most` records.
pub fn log(most: usize) -> impl Strategy<Value = Log> {
    let start = prop_oneof![Just(0_i64), Just(1_436_509_052_249_713_000), 0_i64..2_000_000_000_000_000_000];
    let records = prop::collection::vec((step(), 0..BUSES.len(), any::<bool>(), content()), 0..most);
    (start, records).prop_map(|(start, records)| {
        let mut log = Log { records: Vec::new(), buses: Buses::default() };
        let mut at = start;
        for (step, bus, sent, content) in records {
            at = (at + step).max(0);
            let bus = log.buses.index(BUSES[bus]).expect("few buses");
            let is_frame = matches!(content, Content::Frame(_));
            let direction = if sent && is_frame { Direction::Sent } else { Direction::Received };
            log.records.push(Record { at: Instant::from_nanos(at), bus, direction, content });
        }
        log
    })
}

/// Nanoseconds from one record to the next; now and then back.
fn step() -> impl Strategy<Value = i64> {
    prop_oneof![
        4 => 0..5_000_000_i64,
        4 => (0..20_000_i64).prop_map(|micros| micros * 1_000),
        2 => Just(0),
        1 => -3_000_000..0_i64,
        1 => 0..100_000_000_000_i64,
    ]
}

fn content() -> impl Strategy<Value = Content> {
    prop_oneof![
        6 => classic().prop_map(Content::Frame),
        1 => (id(), 0..=15_u8).prop_map(|(id, dlc)| Content::Frame(remote(id, dlc))),
        3 => fd().prop_map(Content::Frame),
        1 => error().prop_map(Content::Error),
        1 => Just(Content::Error(ErrorFrame::UNSPECIFIED)),
        1 => (1..100_u32).prop_map(Content::Lost),
    ]
}

fn id() -> impl Strategy<Value = CanId> {
    prop_oneof![
        (0..0x800_u16).prop_map(CanId::Standard),
        (0..0x2000_0000_u32).prop_map(CanId::Extended),
        (0..0x800_u32).prop_map(CanId::Extended),
    ]
}

fn classic() -> impl Strategy<Value = RecordedFrame> {
    (id(), prop::collection::vec(any::<u8>(), 0..=8), prop::option::weighted(0.2, 9..=15_u8)).prop_map(
        |(id, data, dlc)| RecordedFrame {
            frame: Frame::classic(id, &data),
            error_passive: false,
            dlc_above_8: dlc.filter(|_| data.len() == 8),
        },
    )
}

fn remote(id: CanId, dlc: u8) -> RecordedFrame {
    let mut frame = Frame::zeroed(id, usize::from(dlc.min(8)));
    frame.kind = FrameKind::Remote;
    RecordedFrame { frame, error_passive: false, dlc_above_8: Some(dlc).filter(|dlc| *dlc > 8) }
}

fn fd() -> impl Strategy<Value = RecordedFrame> {
    let len = prop::sample::select(vec![0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64]);
    (id(), len, any::<[u8; 32]>(), any::<bool>(), any::<bool>()).prop_map(|(id, len, noise, switch, error_passive)| {
        let mut frame = Frame::zeroed(id, len);
        frame.kind = if switch { FrameKind::FdBitRateSwitch } else { FrameKind::Fd };
        frame.payload_mut().iter_mut().zip(noise.iter().cycle()).for_each(|(byte, noise)| *byte = *noise);
        RecordedFrame { frame, error_passive, dlc_above_8: None }
    })
}

fn error() -> impl Strategy<Value = ErrorFrame> {
    let class = prop_oneof![Just(0x88_u32), (0..0x400_u32)];
    (class, any::<[u8; 8]>()).prop_map(|(class, data)| ErrorFrame { class, data })
}
