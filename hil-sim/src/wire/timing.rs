//! How long things take on the wire.

use canloop::bus::{data_phase_bits, frame_bits};
use canloop::frame::{Frame, FrameKind};
use canloop::time::Duration;

/// Bit rates of a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitRates {
    /// Of everything but the data phase of CAN FD frames that switch, bit/s.
    pub nominal_bit_s: u32,
    /// Of that phase, bit/s.
    pub data_bit_s: u32,
}

/// Recessive bits after every frame (10.4.6 of ISO 11898-1:2015).
pub(super) const INTER_FRAME_SPACE: u32 = 3;
/// Error delimiter (10.4.4) and the inter-frame space after it.
const AFTER_FLAG: u32 = 8 + INTER_FRAME_SPACE;
/// Six dominant bits of one node break the stuffing rule for the others, whose
/// own six follow.
const FLAGS: u32 = 12;
/// What remains of a frame from the end of its acknowledge slot on: that
/// delimiter, end of frame, inter-frame space.
const AFTER_ACKNOWLEDGE: u32 = 1 + 7 + INTER_FRAME_SPACE;
/// For how long an error-passive transmitter leaves the bus to others.
const SUSPEND: u32 = 8;
/// Recessive bits in a row that a node off the bus waits for, many times.
const RECESSIVE: u32 = 11;

impl BitRates {
    /// The same for both.
    pub const fn both(bit_s: u32) -> Self {
        Self { nominal_bit_s: bit_s, data_bit_s: bit_s }
    }

    /// Start of frame to the end of the inter-frame space.
    pub fn frame(self, frame: &Frame) -> Duration {
        let all = frame_bits(frame);
        if frame.kind != FrameKind::FdBitRateSwitch {
            return self.bits(all);
        }
        let fast = data_phase_bits(frame);
        let fast_ns = i64::from(fast) * 1_000_000_000 / i64::from(self.data_bit_s);
        self.bits(all - fast) + Duration::from_nanos(fast_ns)
    }

    /// A frame that is cut short by an error in its bit number `bit`, counted
    /// from the start of frame, with the error frame after it.
    pub fn broken_off(self, frame: &Frame, bit: u32) -> Duration {
        let all = i64::from(frame_bits(frame));
        let until = self.frame(frame).as_nanos() * i64::from(bit + 1).min(all) / all;
        Duration::from_nanos(until) + self.bits(FLAGS + AFTER_FLAG)
    }

    /// What is left of a frame that is destroyed at this moment.
    pub fn error_frame(self) -> Duration {
        self.bits(FLAGS + AFTER_FLAG)
    }

    /// A frame that receivers find damaged by its CRC: their flags begin after
    /// the acknowledge delimiter, the transmitter's one bit later.
    pub fn failed_crc(self, frame: &Frame) -> Duration {
        self.frame(frame) - self.bits(AFTER_ACKNOWLEDGE - 1) + self.bits(7 + AFTER_FLAG)
    }

    /// A frame that nobody acknowledges, with the transmitter's own flag.
    pub fn not_acknowledged(self, frame: &Frame) -> Duration {
        self.frame(frame) - self.bits(AFTER_ACKNOWLEDGE) + self.bits(6 + AFTER_FLAG)
    }

    /// After its frame, for how long an error-passive transmitter waits.
    pub fn suspend(self) -> Duration {
        self.bits(SUSPEND)
    }

    /// The idle time that counts as one of the 128 that a node off the bus
    /// waits for.
    pub fn recessive(self) -> Duration {
        self.bits(RECESSIVE)
    }

    /// So many bits at the nominal rate.
    pub fn bits(self, bits: u32) -> Duration {
        Duration::from_nanos(i64::from(bits) * 1_000_000_000 / i64::from(self.nominal_bit_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canloop::frame::CanId;

    const RATES: BitRates = BitRates { nominal_bit_s: 1_000_000, data_bit_s: 5_000_000 };

    fn frame() -> Frame {
        Frame::classic(CanId::Standard(0x123), &[1, 2, 3])
    }

    #[test]
    fn only_the_data_phase_is_fast() {
        let mut fd = Frame::zeroed(CanId::Standard(0x123), 64);
        fd.kind = FrameKind::FdBitRateSwitch;
        let (all, fast) = (i64::from(frame_bits(&fd)), i64::from(data_phase_bits(&fd)));
        assert_eq!(RATES.frame(&fd), Duration::from_nanos((all - fast) * 1_000 + fast * 200));
        fd.kind = FrameKind::Fd;
        assert_eq!(RATES.frame(&fd), Duration::from_nanos(i64::from(frame_bits(&fd)) * 1_000));
    }

    #[test]
    fn an_error_frame_follows_the_bit_that_was_wrong() {
        // 10 bits with the wrong one, 12 of flags, 8 of delimiter, 3 of space.
        assert_eq!(RATES.broken_off(&frame(), 9), Duration::from_micros(10 + 12 + 8 + 3));
    }

    #[test]
    fn a_frame_that_fails_late_takes_a_little_longer_than_one_that_does_not() {
        let longer = |time: Duration| (time - RATES.frame(&frame())).as_nanos() / 1_000;
        assert_eq!(longer(RATES.failed_crc(&frame())), 8);
        assert_eq!(longer(RATES.not_acknowledged(&frame())), 6);
    }
}
