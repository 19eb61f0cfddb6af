//! CRC-8, which guards commands and feedback against what the bus's own CRC
//! cannot see: a gateway's or a drive's memory, a frame sent under the wrong id.

/// An 8-bit CRC, most significant bit first, without reflection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Crc8 {
    table: [u8; 256],
    initial: u8,
    final_xor: u8,
}

impl Crc8 {
    /// SAE J1850: polynomial 0x1D, initial value and final xor 0xFF.
    pub const fn sae_j1850() -> Self {
        Self::new(0x1D, 0xFF, 0xFF)
    }

    /// A CRC with this polynomial (x^8 not written), start and end.
    pub const fn new(polynomial: u8, initial: u8, final_xor: u8) -> Self {
        let mut table = [0; 256];
        let mut byte = 0;
        while byte < 256 {
            let mut remainder = byte as u8;
            let mut bit = 0;
            while bit < 8 {
                let carry = remainder & 0x80 != 0;
                remainder = (remainder << 1) ^ if carry { polynomial } else { 0 };
                bit += 1;
            }
            table[byte] = remainder;
            byte += 1;
        }
        Self { table, initial, final_xor }
    }

    /// The CRC of `bytes`.
    pub fn checksum(&self, bytes: &[u8]) -> u8 {
        self.finish(self.update(self.initial, bytes))
    }

    /// The running remainder before any byte.
    pub(super) const fn start(&self) -> u8 {
        self.initial
    }

    /// The running remainder after `bytes`.
    #[inline]
    pub(super) fn update(&self, remainder: u8, bytes: &[u8]) -> u8 {
        bytes.iter().fold(remainder, |remainder, byte| self.table[usize::from(remainder ^ byte)])
    }

    /// The running remainder after `bytes`, the last one first.
    pub(super) fn update_reversed(&self, remainder: u8, bytes: &[u8]) -> u8 {
        bytes.iter().rev().fold(remainder, |remainder, byte| self.table[usize::from(remainder ^ byte)])
    }

    /// The CRC that a running remainder ends in.
    #[inline]
    pub(super) const fn finish(&self, remainder: u8) -> u8 {
        remainder ^ self.final_xor
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_check_values_of_the_catalogue_come_out() {
        // From the catalogue of parametrised CRC algorithms, for "123456789".
        assert_eq!(Crc8::sae_j1850().checksum(b"123456789"), 0x4B);
        assert_eq!(Crc8::new(0x2F, 0xFF, 0xFF).checksum(b"123456789"), 0xDF, "AUTOSAR");
        assert_eq!(Crc8::new(0x07, 0x00, 0x00).checksum(b"123456789"), 0xF4, "SMBUS");
    }
}
