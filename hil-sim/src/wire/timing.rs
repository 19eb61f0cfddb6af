//! How long things take on the wire.

use canloop::bus::{BitRates, frame_bits};
use canloop::frame::Frame;
use canloop::time::Duration;

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

/// How long things take besides frames that cross.
pub(super) trait ErrorTiming {
    /// A frame that is cut short by an error in its bit number `bit`, counted
    /// from the start of frame, with the error frame after it.
    fn broken_off(self, frame: &Frame, bit: u32) -> Duration;

    /// What is left of a frame that is destroyed at this moment.
    fn error_frame(self) -> Duration;

    /// A frame that receivers find damaged by its CRC: their flags begin after
    /// the acknowledge delimiter, the transmitter's one bit later.
    fn failed_crc(self, frame: &Frame) -> Duration;

    /// A frame that nobody acknowledges, with the transmitter's own flag.
    fn not_acknowledged(self, frame: &Frame) -> Duration;

    /// After its frame, for how long an error-passive transmitter waits.
    fn suspend(self) -> Duration;

    /// The idle time that counts as one of the 128 that a node off the bus
    /// waits for.
    fn recessive(self) -> Duration;
}

impl ErrorTiming for BitRates {
    fn broken_off(self, frame: &Frame, bit: u32) -> Duration {
        let all = i64::from(frame_bits(frame));
        let until = self.frame(frame).as_nanos() * i64::from(bit + 1).min(all) / all;
        Duration::from_nanos(until) + self.bits(FLAGS + AFTER_FLAG)
    }

    fn error_frame(self) -> Duration {
        self.bits(FLAGS + AFTER_FLAG)
    }

    fn failed_crc(self, frame: &Frame) -> Duration {
        self.frame(frame) - self.bits(AFTER_ACKNOWLEDGE - 1) + self.bits(7 + AFTER_FLAG)
    }

    fn not_acknowledged(self, frame: &Frame) -> Duration {
        self.frame(frame) - self.bits(AFTER_ACKNOWLEDGE) + self.bits(6 + AFTER_FLAG)
    }

    fn suspend(self) -> Duration {
        self.bits(SUSPEND)
    }

    fn recessive(self) -> Duration {
        self.bits(RECESSIVE)
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
