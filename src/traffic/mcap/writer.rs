//! Hands records to the log's own writer.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use crate::log::{FrameLog, LogError, LoggedBus, LoggedFrame};
use crate::traffic::losses::{Loss, Losses};
use crate::traffic::{Buses, Content, Direction, Record, Writer};

/// Writes `.mcap`.
pub(in crate::traffic) struct McapWriter {
    log: FrameLog,
    /// The log's index of each bus.
    buses: Vec<Option<usize>>,
    lost: u64,
    losses: Losses,
}

impl McapWriter {
    /// Makes or empties the file at `path`.
    pub fn create(path: &Path) -> Result<Self, LogError> {
        let version = BTreeMap::from([("version".to_owned(), env!("CARGO_PKG_VERSION").to_owned())]);
        let log = FrameLog::create(path, &version)?;
        Ok(Self { log, buses: Vec::new(), lost: 0, losses: Losses::default() })
    }

    fn bus(&mut self, bus: u16, buses: &Buses) -> io::Result<usize> {
        let index = usize::from(bus);
        if let Some(&Some(known)) = self.buses.get(index) {
            return Ok(known);
        }
        let added = self.log.add_bus(&LoggedBus { name: buses.name(bus), dbcs: Vec::new() });
        let added = added.map_err(io::Error::other)?;
        self.buses.resize(self.buses.len().max(index + 1), None);
        self.buses[index] = Some(added);
        Ok(added)
    }
}

impl Writer for McapWriter {
    fn put(&mut self, record: &Record, buses: &Buses) -> io::Result<()> {
        let (at, sent_by_stack) = (record.at, record.direction == Direction::Sent);
        // Of these messages only MCAP itself keeps a stamp, which has no sign.
        let is_stamped_by_mcap = match &record.content {
            Content::Frame(recorded) => recorded.is_fd(),
            Content::Error(_) => false,
            Content::Lost(_) => true,
        };
        if at.as_nanos() < 0 && is_stamped_by_mcap {
            self.losses.note(Loss::EarlierStamps);
        }
        match &record.content {
            Content::Frame(recorded) => {
                let (error_passive, dlc_above_8) = (recorded.error_passive, recorded.dlc_above_8);
                let frame = LoggedFrame { frame: &recorded.frame, sent_by_stack, error_passive, dlc_above_8 };
                let bus = self.bus(record.bus, buses)?;
                self.log.put(bus, at, &frame).map_err(io::Error::other)
            }
            Content::Error(error) => {
                let bus = self.bus(record.bus, buses)?;
                self.log.put_error(bus, at, error.class, error.data).map_err(io::Error::other)
            }
            Content::Lost(count) => {
                self.lost += u64::from(*count);
                let bus = self.bus(record.bus, buses)?;
                self.log.put_lost(bus, at, (*count).into(), self.lost).map_err(io::Error::other)
            }
        }
    }

    fn finish(self: Box<Self>) -> io::Result<Losses> {
        self.log.finish(self.lost).map_err(io::Error::other)?;
        Ok(self.losses)
    }
}
