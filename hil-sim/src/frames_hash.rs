//! The hash that tells runs apart: the same frames at the same moments give the
//! same one.

use canloop::frame::Frame;
use canloop::time::Instant;

/// BLAKE3 over every frame's time, id and data in order: time as 8 bytes (ns,
/// little-endian), id as 4 (bit 31 set where it is extended).
pub struct FramesHash {
    hasher: blake3::Hasher,
    /// Frames are hashed in blocks, which is several times faster.
    block: Vec<u8>,
}

const BLOCK_BYTES: usize = 64 * 1024;

impl FramesHash {
    /// Of no frame yet.
    pub fn new() -> Self {
        Self { hasher: blake3::Hasher::new(), block: Vec::with_capacity(BLOCK_BYTES + 128) }
    }

    /// Takes the next frame.
    pub fn take(&mut self, at: Instant, frame: &Frame) {
        let marked_id = frame.id.raw() | u32::from(frame.id.is_extended()) << 31;
        self.block.extend_from_slice(&at.as_nanos().to_le_bytes());
        self.block.extend_from_slice(&marked_id.to_le_bytes());
        self.block.extend_from_slice(frame.payload());
        if self.block.len() >= BLOCK_BYTES {
            self.hasher.update(&self.block);
            self.block.clear();
        }
    }

    /// The hash in hexadecimal digits.
    pub fn finish(mut self) -> String {
        self.hasher.update(&self.block);
        self.hasher.finalize().to_hex().to_string()
    }
}

impl Default for FramesHash {
    fn default() -> Self {
        Self::new()
    }
}
