//! What a log holds, whatever its format.

use std::fmt;

use crate::frame::{Frame, FrameKind};
use crate::time::Instant;

/// One thing that happened on a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// When: since the Unix epoch where the log says so, else since its beginning.
    pub at: Instant,
    /// On which bus: an index into [`Buses`].
    pub bus: u16,
    /// Who sent it. Logs that do not say have received everything.
    pub direction: Direction,
    /// What it was.
    pub content: Content,
}

/// Whether the one who logged sent a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Direction {
    /// Somebody else did.
    #[default]
    Received,
    /// The one who logged did.
    Sent,
}

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(clippy::large_enum_variant, reason = "records are read by the million; a box would allocate each")]
pub enum Content {
    /// A frame crossed the bus.
    Frame(RecordedFrame),
    /// A controller or its driver told of an error.
    Error(ErrorFrame),
    /// The one who logged lost so many frames before this moment.
    Lost(u32),
}

/// A frame with what only logs tell of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordedFrame {
    /// The frame.
    pub frame: Frame,
    /// Whether its sender was error-passive; CAN FD frames only.
    pub error_passive: bool,
    /// The length code of a classic frame of 8 bytes, where it was 9 to 15.
    pub dlc_above_8: Option<u8>,
}

/// An error frame in the terms of SocketCAN (`linux/can/error.h`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ErrorFrame {
    /// Classes of error, or-ed.
    pub class: u32,
    /// What the classes say more: byte 1 the controller, 2 and 3 the protocol
    /// violation and its place, 6 and 7 the error counters.
    pub data: [u8; 8],
}

/// The names of the buses in a log, in order of their appearance.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Buses {
    names: Vec<String>,
    /// By number, for formats that number buses from 1.
    numbers: Vec<Option<u16>>,
}

/// A log that names more buses than there can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooManyBuses;

/// No machine has so many; a damaged log may seem to.
const MOST_BUSES: usize = 256;

impl Record {
    /// The frame, if it is one.
    pub const fn frame(&self) -> Option<&Frame> {
        match &self.content {
            Content::Frame(recorded) => Some(&recorded.frame),
            _ => None,
        }
    }
}

impl From<Frame> for RecordedFrame {
    fn from(frame: Frame) -> Self {
        Self { frame, error_passive: false, dlc_above_8: None }
    }
}

impl RecordedFrame {
    /// Whether it is a CAN FD frame.
    pub const fn is_fd(&self) -> bool {
        matches!(self.frame.kind, FrameKind::Fd | FrameKind::FdBitRateSwitch)
    }

    /// The length code that was on the wire, 0 to 15.
    pub fn dlc(&self) -> u8 {
        self.dlc_above_8.unwrap_or_else(|| dlc_of(self.frame.len()))
    }
}

impl ErrorFrame {
    /// Set in the id of an error frame (`CAN_ERR_FLAG`).
    pub const FLAG: u32 = 0x2000_0000;
    /// A protocol violation (`CAN_ERR_PROT`).
    pub const PROTOCOL: u32 = 0x008;
    /// An error on the bus (`CAN_ERR_BUSERROR`).
    pub const BUS_ERROR: u32 = 0x080;
    /// One of which nothing more is known.
    pub const UNSPECIFIED: Self = Self { class: Self::BUS_ERROR, data: [0; 8] };
}

impl Buses {
    /// The index of the bus called `name`, which is a new one if it has not
    /// been heard of.
    ///
    /// # Errors
    /// There are too many already.
    pub fn index(&mut self, name: &str) -> Result<u16, TooManyBuses> {
        if let Some(known) = self.names.iter().position(|known| known == name) {
            return Ok(known as u16);
        }
        if self.names.len() == MOST_BUSES {
            return Err(TooManyBuses);
        }
        self.names.push(name.to_owned());
        Ok((self.names.len() - 1) as u16)
    }

    /// As [`Self::index`], of a name that may be no text.
    ///
    /// # Errors
    /// There are too many already.
    pub fn index_of_bytes(&mut self, name: &[u8]) -> Result<u16, TooManyBuses> {
        match self.names.iter().position(|known| known.as_bytes() == name) {
            Some(known) => Ok(known as u16),
            None => self.index(&String::from_utf8_lossy(name)),
        }
    }

    /// The index of the bus that a log calls by `number`, from 1: `can0` is
    /// number 1, unless [`Self::declare`] has said otherwise.
    ///
    /// # Errors
    /// There are too many already.
    pub fn numbered(&mut self, number: u32) -> Result<u16, TooManyBuses> {
        if let Some(&Some(known)) = self.numbers.get(number as usize) {
            return Ok(known);
        }
        let name = number.checked_sub(1).map_or_else(|| "can".to_owned(), |from_0| format!("can{from_0}"));
        self.declare(number, &name)
    }

    /// Says what the bus that a log calls by `number` is called.
    ///
    /// # Errors
    /// There are too many already.
    pub fn declare(&mut self, number: u32, name: &str) -> Result<u16, TooManyBuses> {
        let at = usize::try_from(number).ok().filter(|&at| at <= MOST_BUSES).ok_or(TooManyBuses)?;
        let index = self.index(name)?;
        self.numbers.resize(self.numbers.len().max(at + 1), None);
        self.numbers[at] = Some(index);
        Ok(index)
    }

    /// The name of a bus.
    pub fn name(&self, index: u16) -> &str {
        self.names.get(usize::from(index)).map_or("", String::as_str)
    }

    /// All names.
    pub fn names(&self) -> &[String] {
        &self.names
    }
}

impl fmt::Display for TooManyBuses {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "no log has more than {MOST_BUSES} buses")
    }
}

/// The code of a length; one that has none gets the next longer one's.
pub(super) fn dlc_of(len: usize) -> u8 {
    match len {
        0..=8 => len as u8,
        9..=24 => (len.div_ceil(4) + 6) as u8,
        _ => (len.div_ceil(16) + 11) as u8,
    }
}

/// The bytes that a length code of CAN FD stands for.
pub(super) const fn fd_len_of(dlc: u8) -> usize {
    match dlc {
        0..=8 => dlc as usize,
        9..=12 => (dlc as usize - 6) * 4,
        13..=15 => (dlc as usize - 11) * 16,
        _ => 64,
    }
}
