//! What crossed one bus.

use crate::bus::BitRates;
use crate::traffic::{Content, Direction, Record};

const SECOND_NS: i64 = 1_000_000_000;

/// Counts and load of a bus.
#[derive(Default)]
pub struct Bus {
    /// Frames.
    pub frames: u64,
    /// Of those, the ones that the one who logged sent.
    pub sent: u64,
    /// Of those, the CAN FD frames.
    pub fd: u64,
    /// Error frames.
    pub errors: u64,
    /// Frames that the one who logged lost.
    pub lost: u64,
    /// All frames together, on the wire, s.
    pub busy_s: f64,
    /// The second that is being counted, and how long frames took in it.
    second: i64,
    busy_in_second_s: f64,
    busiest_s: f64,
}

impl Bus {
    /// Takes a record into account.
    pub fn add(&mut self, record: &Record, rates: Option<BitRates>) {
        let recorded = match &record.content {
            Content::Frame(recorded) => recorded,
            Content::Error(_) => {
                self.errors += 1;
                return;
            }
            Content::Lost(count) => {
                self.lost += u64::from(*count);
                return;
            }
        };
        self.frames += 1;
        self.sent += u64::from(record.direction == Direction::Sent);
        self.fd += u64::from(recorded.is_fd());
        if let Some(rates) = rates {
            let second = record.at.as_nanos().div_euclid(SECOND_NS);
            self.busy(second, rates.frame(&recorded.frame).as_secs_f64());
        }
    }

    /// The share of the busiest second, 1 for all of it.
    pub fn busiest(&self) -> f64 {
        self.busiest_s.max(self.busy_in_second_s)
    }

    fn busy(&mut self, second: i64, seconds: f64) {
        if second != self.second {
            self.busiest_s = self.busiest();
            self.second = second;
            self.busy_in_second_s = 0.0;
        }
        self.busy_s += seconds;
        self.busy_in_second_s += seconds;
    }
}
