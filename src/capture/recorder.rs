//! Writes what is heard.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use super::{BusStatistics, Hearing, Rotation};
use crate::bus::Arrival;
use crate::log::{FrameLog, LogError, LoggedBus, LoggedFrame};
use crate::schema::Dbc;
use crate::time::Instant;
use crate::traffic::{Content, Direction, ErrorFrame, RecordedFrame};

/// Takes what several buses bring and writes it to one file after the other.
pub struct Recorder<'d> {
    path: PathBuf,
    rotation: Rotation,
    metadata: BTreeMap<String, String>,
    dbcs: Vec<&'d Dbc>,
    hearings: Vec<Hearing>,
    statistics: Vec<BusStatistics>,
    /// None once a file has failed.
    log: Option<FrameLog>,
    files: Vec<PathBuf>,
    /// The stamp with which the present file begins.
    begun: Option<Instant>,
    /// The latest stamp.
    now: Instant,
    messages: u64,
    bytes: u64,
}

/// What was logged.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoggedTraffic {
    /// Files written.
    pub files: Vec<PathBuf>,
    /// Messages in them.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
}

/// Taken of one bus before the next one has its turn.
const TURN: usize = 512;

impl<'d> Recorder<'d> {
    /// Makes the first file.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn create(
        path: &Path,
        rotation: Rotation,
        metadata: BTreeMap<String, String>,
        dbcs: Vec<&'d Dbc>,
        hearings: Vec<Hearing>,
    ) -> Result<Self, LogError> {
        let statistics = vec![BusStatistics::default(); hearings.len()];
        let mut recorder = Self {
            path: path.to_owned(),
            rotation,
            metadata,
            dbcs,
            hearings,
            statistics,
            log: None,
            files: Vec::new(),
            begun: None,
            now: Instant::ZERO,
            messages: 0,
            bytes: 0,
        };
        recorder.begin_file()?;
        Ok(recorder)
    }

    /// Writes what has come so far; says whether there was anything.
    ///
    /// # Errors
    /// The file takes no more.
    pub fn write(&mut self) -> Result<bool, LogError> {
        let mut has_any = false;
        for bus in 0..self.hearings.len() {
            // Asked of the system once a turn: a turn is less than a chunk.
            let mut bytes = self.rotation.bytes.map_or(0, |_| self.log.as_ref().map_or(0, FrameLog::bytes));
            for _ in 0..TURN {
                let Ok((at, arrival)) = self.hearings[bus].queue.pop() else { break };
                has_any = true;
                self.note_what_found_no_room(bus, at)?;
                if self.rotate(at, bytes)? {
                    bytes = 0;
                }
                self.put(bus, at, &arrival)?;
            }
        }
        Ok(has_any)
    }

    /// Sees to it that what has come is in the file, though a chunk is not full.
    ///
    /// # Errors
    /// The file takes no more.
    pub fn flush(&mut self) -> Result<(), LogError> {
        self.log.as_mut().map_or(Ok(()), FrameLog::flush)
    }

    /// Whether no bus brings anything more.
    pub fn has_ended(&self) -> bool {
        self.hearings.iter().all(Hearing::has_ended)
    }

    /// Names of the buses and what they have brought.
    pub fn statistics(&self) -> impl Iterator<Item = (&str, &BusStatistics)> {
        self.hearings.iter().map(|hearing| hearing.name.as_str()).zip(&self.statistics)
    }

    /// Bytes in all files so far.
    pub fn bytes(&self) -> u64 {
        self.bytes + self.log.as_ref().map_or(0, FrameLog::bytes)
    }

    /// Ends the last file. Gives back the buses, whose threads may have ended
    /// for a reason of their own.
    pub fn finish(mut self) -> (Result<LoggedTraffic, LogError>, Vec<Hearing>) {
        let ended = self.end_file();
        let logged = LoggedTraffic { files: self.files, messages: self.messages, bytes: self.bytes };
        (ended.map(|()| logged), self.hearings)
    }

    fn begin_file(&mut self) -> Result<(), LogError> {
        let path = self.rotation.path(&self.path, self.files.len() as u32 + 1);
        let texts = self.dbcs.iter().map(|dbc| {
            let name = Path::new(&dbc.source.name).file_name().unwrap_or_default().to_string_lossy().into_owned();
            (name, "text/plain".to_owned(), dbc.source.text.clone().into_bytes())
        });
        let mut log = FrameLog::with_attachments(&path, &self.metadata, &texts.collect::<Vec<_>>())?;
        for hearing in &self.hearings {
            log.add_bus(&LoggedBus { name: &hearing.name, dbcs: self.dbcs.clone() })?;
        }
        self.files.push(path);
        self.log = Some(log);
        self.begun = None;
        Ok(())
    }

    fn end_file(&mut self) -> Result<(), LogError> {
        let Some(log) = self.log.take() else { return Ok(()) };
        let lost = self.statistics.iter().map(BusStatistics::lost).sum();
        let report = log.finish(lost)?;
        self.messages += report.messages;
        self.bytes += report.bytes;
        Ok(())
    }

    /// Goes on in another file if the present one, of so many bytes, is full at
    /// this moment; says whether it was.
    fn rotate(&mut self, at: Instant, bytes: u64) -> Result<bool, LogError> {
        let begun = *self.begun.get_or_insert(at);
        let is_due = self.rotation.is_due(begun, at, bytes);
        if is_due {
            self.end_file()?;
            self.begin_file()?;
            self.begun = Some(at);
        }
        Ok(is_due)
    }

    fn note_what_found_no_room(&mut self, bus: usize, at: Instant) -> Result<(), LogError> {
        let lost = self.hearings[bus].lost.load(Ordering::Relaxed);
        let newly = lost - self.statistics[bus].lost_here;
        if newly == 0 {
            return Ok(());
        }
        self.statistics[bus].lost_here = lost;
        self.tell_lost(bus, at, newly)
    }

    fn put(&mut self, bus: usize, at: Instant, arrival: &Arrival) -> Result<(), LogError> {
        self.now = self.now.max(at);
        self.statistics[bus].take(arrival);
        let Some(log) = &mut self.log else { return Ok(()) };
        let name = &self.hearings[bus].name;
        match arrival {
            Arrival::Heard(direction, Content::Frame(recorded)) => log.put(bus, at, &logged(*direction, recorded)),
            Arrival::Heard(_, Content::Error(ErrorFrame { class, data })) => log.put_error(bus, at, *class, *data),
            Arrival::Heard(_, Content::Lost(frames)) | Arrival::Lost(frames) => {
                self.tell_lost(bus, at, u64::from(*frames))
            }
            Arrival::State(state) => {
                log.notice(at, state.word(), &format!("{name}: its controller is {}", state.word()))
            }
            Arrival::Down => log.notice(at, "down", &format!("{name}: the interface went down or away")),
            Arrival::Up => log.notice(at, "up", &format!("{name}: the interface is back")),
            Arrival::Frame(frame) => log.put(bus, at, &logged(Direction::Received, &(*frame).into())),
        }
    }

    fn tell_lost(&mut self, bus: usize, at: Instant, frames: u64) -> Result<(), LogError> {
        let total = self.statistics[bus].lost();
        self.log.as_mut().map_or(Ok(()), |log| log.put_lost(bus, at, frames, total))
    }
}

fn logged(direction: Direction, recorded: &RecordedFrame) -> LoggedFrame<'_> {
    LoggedFrame {
        frame: &recorded.frame,
        sent_by_stack: direction == Direction::Sent,
        error_passive: recorded.error_passive,
        dlc_above_8: recorded.dlc_above_8,
    }
}
