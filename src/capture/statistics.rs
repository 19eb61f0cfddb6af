//! What a bus has brought.

use crate::bus::{Arrival, frame_bits};
use crate::traffic::Content;

/// Counts of one bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BusStatistics {
    /// Frames.
    pub frames: u64,
    /// Error frames.
    pub errors: u64,
    /// Bit times that the frames took, data phases of CAN FD counted as the rest.
    pub bits: u64,
    /// Frames that were lost before they could be heard: the kernel's receive
    /// buffer, or the card's, was full.
    pub lost_on_the_way: u64,
    /// Frames that were heard and found no room in the queue to the file.
    pub lost_here: u64,
}

impl BusStatistics {
    /// Counts something heard.
    pub fn take(&mut self, arrival: &Arrival) {
        match arrival {
            Arrival::Heard(_, Content::Frame(recorded)) => {
                self.frames += 1;
                self.bits += u64::from(frame_bits(&recorded.frame));
            }
            Arrival::Heard(_, Content::Error(_)) => self.errors += 1,
            Arrival::Heard(_, Content::Lost(frames)) | Arrival::Lost(frames) => {
                self.lost_on_the_way += u64::from(*frames);
            }
            _ => {}
        }
    }

    /// All that is not in the log.
    pub const fn lost(&self) -> u64 {
        self.lost_on_the_way + self.lost_here
    }

    /// What has come since `before`.
    pub const fn since(&self, before: &Self) -> Self {
        Self {
            frames: self.frames - before.frames,
            errors: self.errors - before.errors,
            bits: self.bits - before.bits,
            lost_on_the_way: self.lost_on_the_way - before.lost_on_the_way,
            lost_here: self.lost_here - before.lost_here,
        }
    }
}
