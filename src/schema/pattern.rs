//! Values of a signal, some of its bits left out perhaps.

use super::signal::Signal;

/// A few values, any of which will do; the first is the one to write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Pattern {
    /// The one to write.
    pub first: Masked,
    pub others: Vec<Masked>,
}

/// The bits of a signal that count, and what they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Masked {
    pub mask: u64,
    pub value: u64,
}

/// A signal and what it should hold.
#[derive(Clone, Debug)]
pub(super) struct Field {
    pub signal: Signal,
    pub pattern: Pattern,
}

impl Pattern {
    /// Whether the bits of a signal fit.
    #[inline]
    pub fn fits(&self, bits: u64) -> bool {
        self.first.fits(bits) || self.others.iter().any(|masked| masked.fits(bits))
    }

    /// Writes the bits that count and leaves the others alone.
    #[inline]
    pub fn write(&self, signal: &Signal, data: &mut [u8; 64]) {
        let Masked { mask, value } = self.first;
        let kept = signal.decode_bits(data) & !mask;
        signal.encode_bits(data, kept | value);
    }
}

impl Masked {
    #[inline]
    const fn fits(self, bits: u64) -> bool {
        bits & self.mask == self.value
    }
}

impl Field {
    /// Writes what the signal should hold.
    #[inline]
    pub fn write(&self, data: &mut [u8; 64]) {
        self.pattern.write(&self.signal, data);
    }

    /// Whether it holds that.
    #[inline]
    pub fn fits(&self, data: &[u8; 64]) -> bool {
        self.pattern.fits(self.signal.decode_bits(data))
    }
}
