//! How long frames take on the wire.

use super::{data_phase_bits, frame_bits};
use crate::frame::{Frame, FrameKind};
use crate::time::Duration;

/// Bit rates of a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitRates {
    /// Of everything but the data phase of CAN FD frames that switch, bit/s.
    pub nominal_bit_s: u32,
    /// Of that phase, bit/s.
    pub data_bit_s: u32,
}

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

    /// So many bits at the nominal rate.
    pub fn bits(self, bits: u32) -> Duration {
        Duration::from_nanos(i64::from(bits) * 1_000_000_000 / i64::from(self.nominal_bit_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::CanId;

    const RATES: BitRates = BitRates { nominal_bit_s: 1_000_000, data_bit_s: 5_000_000 };

    #[test]
    fn only_the_data_phase_is_fast() {
        let mut fd = Frame::zeroed(CanId::Standard(0x123), 64);
        fd.kind = FrameKind::FdBitRateSwitch;
        let (all, fast) = (i64::from(frame_bits(&fd)), i64::from(data_phase_bits(&fd)));
        assert_eq!(RATES.frame(&fd), Duration::from_nanos((all - fast) * 1_000 + fast * 200));
        fd.kind = FrameKind::Fd;
        assert_eq!(RATES.frame(&fd), Duration::from_nanos(i64::from(frame_bits(&fd)) * 1_000));
    }
}
