//! The length of a frame on the wire is known to the bit.

use canloop::bus::{data_phase_bits, frame_bits, worst_case_frame_bits};
use canloop::frame::{CanId, Frame, FrameKind};
use proptest::prelude::*;

/// A frame bit by bit, as the standard's figures draw it.
struct Wire(Vec<bool>);

impl Wire {
    fn push(&mut self, value: u32, width: u32) {
        self.0.extend((0..width).rev().map(|bit| value >> bit & 1 != 0));
    }

    /// Start of frame to the bit before the CRC, of a classic frame.
    fn classic(frame: &Frame) -> Self {
        let mut wire = Self(Vec::new());
        let remote = u32::from(frame.kind == FrameKind::Remote);
        wire.push(0, 1);
        match frame.id {
            CanId::Standard(id) => {
                wire.push(id.into(), 11);
                wire.push(remote, 1);
                wire.push(0b00, 2);
            }
            CanId::Extended(id) => {
                wire.push(id >> 18, 11);
                wire.push(0b11, 2);
                wire.push(id & 0x3_FFFF, 18);
                wire.push(remote, 1);
                wire.push(0b00, 2);
            }
        }
        wire.push(frame.len() as u32, 4);
        if remote == 0 {
            frame.payload().iter().for_each(|&byte| wire.push(byte.into(), 8));
        }
        wire
    }

    /// Start of frame to the last data bit of an FD frame, and the number of
    /// bits up to BRS.
    fn fd(frame: &Frame) -> (Self, usize) {
        let mut wire = Self(Vec::new());
        wire.push(0, 1);
        match frame.id {
            CanId::Standard(id) => {
                wire.push(id.into(), 11);
                wire.push(0b00, 2);
            }
            CanId::Extended(id) => {
                wire.push(id >> 18, 11);
                wire.push(0b11, 2);
                wire.push(id & 0x3_FFFF, 18);
                wire.push(0b0, 1);
            }
        }
        wire.push(0b10, 2);
        wire.push(u32::from(frame.kind == FrameKind::FdBitRateSwitch), 1);
        let slow = wire.0.len();
        let lengths = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];
        wire.push(0, 1);
        wire.push(lengths.iter().position(|&len| len == frame.len()).unwrap() as u32, 4);
        frame.payload().iter().for_each(|&byte| wire.push(byte.into(), 8));
        (wire, slow)
    }

    fn append_crc15(&mut self) {
        let mut crc = 0_u32;
        for &bit in &self.0 {
            let invert = bit != (crc & 0x4000 != 0);
            crc = (crc << 1) & 0x7FFF ^ if invert { 0x4599 } else { 0 };
        }
        self.push(crc, 15);
    }

    /// After which bits one more is inserted.
    fn stuffed_after(&self) -> Vec<usize> {
        let mut places = Vec::new();
        let mut run = (true, 0);
        for (index, &bit) in self.0.iter().enumerate() {
            run = if index > 0 && bit == run.0 { (bit, run.1 + 1) } else { (bit, 1) };
            if run.1 == 5 {
                places.push(index);
                run = (!bit, 1);
            }
        }
        places
    }
}

fn naive_classic(frame: &Frame) -> u32 {
    let mut wire = Wire::classic(frame);
    wire.append_crc15();
    (wire.0.len() + wire.stuffed_after().len() + 13) as u32
}

/// All bits of an FD frame, and those after BRS up to the CRC delimiter.
fn naive_fd(frame: &Frame) -> (u32, u32) {
    let (wire, slow) = Wire::fd(frame);
    let last = wire.0.len() - 1;
    let stuffed: Vec<usize> = wire.stuffed_after().into_iter().filter(|&at| at < last).collect();
    let crc_field = if frame.len() <= 16 { 4 + 17 + 6 } else { 4 + 21 + 7 };
    let all = wire.0.len() + stuffed.len() + crc_field + 13;
    let fast_stuffed = stuffed.iter().filter(|&&at| at >= slow).count();
    (all as u32, (wire.0.len() - slow + fast_stuffed + crc_field + 1) as u32)
}

fn ids() -> impl Strategy<Value = CanId> {
    prop_oneof![(0..0x800_u16).prop_map(CanId::Standard), (0..0x2000_0000_u32).prop_map(CanId::Extended)]
}

/// Bytes with long runs, which random ones seldom have.
fn bytes(len: usize) -> impl Strategy<Value = Vec<u8>> {
    let byte = prop_oneof![any::<u8>(), Just(0x00), Just(0xFF), Just(0xF8), Just(0x1F), Just(0xE0)];
    prop::collection::vec(byte, len)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 5000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_classic_frame_is_as_long_as_its_bits_written_out(
        id in ids(),
        payload in (0..=8_usize).prop_flat_map(bytes),
        remote in any::<bool>(),
    ) {
        let mut frame = Frame::classic(id, &payload);
        if remote {
            frame.kind = FrameKind::Remote;
        }
        prop_assert_eq!(frame_bits(&frame), naive_classic(&frame));
        prop_assert_eq!(data_phase_bits(&frame), 0);
    }

    #[test]
    fn an_fd_frame_is_as_long_as_its_bits_written_out(
        id in ids(),
        payload in prop::sample::select(vec![0, 1, 5, 8, 12, 16, 20, 24, 32, 48, 64]).prop_flat_map(bytes),
        switch in any::<bool>(),
    ) {
        let mut frame = Frame::zeroed(id, payload.len());
        frame.payload_mut().copy_from_slice(&payload);
        frame.kind = if switch { FrameKind::FdBitRateSwitch } else { FrameKind::Fd };
        let (all, fast) = naive_fd(&frame);
        prop_assert_eq!(frame_bits(&frame), all);
        prop_assert!(all <= worst_case_frame_bits(id, frame.len(), frame.kind));
        prop_assert_eq!(data_phase_bits(&frame), if switch { fast } else { 0 });
    }

    /// At best no bit is inserted, at worst one after the first five and then
    /// after every fourth: 111 to 135 bits for 8 bytes under a standard id.
    #[test]
    fn a_classic_frame_stays_within_the_known_bounds(id in ids(), payload in (0..=8_usize).prop_flat_map(bytes)) {
        let stuffed = if id.is_extended() { 54 } else { 34 } + 8 * payload.len() as u32;
        let bounds = stuffed + 13..=stuffed + (stuffed - 1) / 4 + 13;
        prop_assert!(bounds.contains(&frame_bits(&Frame::classic(id, &payload))), "{bounds:?}");
        prop_assert_eq!(*bounds.end(), worst_case_frame_bits(id, payload.len(), FrameKind::Classic));
    }
}

/// Id 0 without data is dominant up to the end of its CRC, 34 bits, with one
/// inserted after every five.
#[test]
fn a_frame_of_zeros_has_the_length_worked_out_by_hand() {
    assert_eq!(frame_bits(&Frame::classic(CanId::Standard(0), &[])), 34 + 6 + 13);
}
