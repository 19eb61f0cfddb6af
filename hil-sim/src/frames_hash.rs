//! The hash that tells runs apart: the same frames at the same moments give the
//! same one.

use canloop::frame::Frame;
use canloop::time::Instant;

/// BLAKE3 over every frame's time, id and data in order: time as 8 bytes (ns,
/// little-endian), id as 4 (bit 31 set where it is extended).
pub struct FramesHash {
    hasher: blake3::Hasher,
    /// Frames are hashed in blocks, which is several times faster.
    block: Box<[u8; BLOCK_BYTES]>,
    /// How much of the block is in use.
    filled: usize,
}

const BLOCK_BYTES: usize = 64 * 1024;
/// Time, id and the longest payload.
const RECORD_BYTES: usize = 8 + 4 + Frame::CAPACITY;

impl FramesHash {
    /// Of no frame yet.
    pub fn new() -> Self {
        Self { hasher: blake3::Hasher::new(), block: Box::new([0; BLOCK_BYTES]), filled: 0 }
    }

    /// Takes the next frame.
    pub fn take(&mut self, at: Instant, frame: &Frame) {
        if self.filled + RECORD_BYTES > BLOCK_BYTES {
            self.hasher.update(&self.block[..self.filled]);
            self.filled = 0;
        }
        let marked_id = frame.id.raw() | u32::from(frame.id.is_extended()) << 31;
        let record = &mut self.block[self.filled..][..RECORD_BYTES];
        record[..8].copy_from_slice(&at.as_nanos().to_le_bytes());
        record[8..12].copy_from_slice(&marked_id.to_le_bytes());
        // The next record begins where the payload ends.
        record[12..].copy_from_slice(frame.storage());
        self.filled += 12 + frame.len();
    }

    /// The hash in hexadecimal digits.
    pub fn finish(mut self) -> String {
        self.hasher.update(&self.block[..self.filled]);
        self.hasher.finalize().to_hex().to_string()
    }
}

impl Default for FramesHash {
    fn default() -> Self {
        Self::new()
    }
}
