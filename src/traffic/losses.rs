//! What a format could not hold of the records that it was given.

use std::collections::BTreeMap;

/// One kind of thing that a format may have no room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Loss {
    /// CAN FD frames, left out.
    FdFrames,
    /// Remote requests, left out.
    RemoteFrames,
    /// Error frames, left out.
    ErrorFrames,
    /// What an error frame says beyond that there was an error.
    ErrorDetails,
    /// Whether the sender of a CAN FD frame was error-passive.
    ErrorPassive,
    /// The length code above 8 of a classic frame of 8 bytes.
    LengthCodes,
    /// Who sent a frame: sent frames seem received.
    Directions,
    /// Which bus a frame was on: all are one.
    Buses,
    /// Characters in the names of buses.
    BusNames,
    /// The end of stamps: the most that one lost is kept, in nanoseconds.
    Nanoseconds(i64),
    /// How far stamps go back behind the first.
    EarlierStamps,
    /// How many frames were lost when the log was made.
    LostCounts,
}

/// How often each loss happened.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Losses(BTreeMap<u8, (Loss, u64)>);

impl Losses {
    /// Counts a loss.
    pub fn note(&mut self, loss: Loss) {
        let (noted, count) = self.0.entry(loss.order()).or_insert((loss, 0));
        *noted = (*noted).max(loss);
        *count += 1;
    }

    /// Counts a stamp of which the part below `unit` nanoseconds is cut off.
    pub fn note_stamp(&mut self, nanos: i64, unit: i64) {
        let lost = (nanos % unit).abs();
        if lost > 0 {
            self.note(Loss::Nanoseconds(lost));
        }
    }

    /// All of them, each with its count.
    pub fn iter(&self) -> impl Iterator<Item = (Loss, u64)> {
        self.0.values().copied()
    }

    /// Whether nothing was lost.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A line for each, in words, for the format called `name`.
    pub fn messages(&self, name: &str) -> Vec<String> {
        self.iter().map(|(loss, count)| loss.message(name, count)).collect()
    }
}

impl Loss {
    /// A number for each kind.
    const fn order(self) -> u8 {
        match self {
            Self::FdFrames => 0,
            Self::RemoteFrames => 1,
            Self::ErrorFrames => 2,
            Self::ErrorDetails => 3,
            Self::ErrorPassive => 4,
            Self::LengthCodes => 5,
            Self::Directions => 6,
            Self::Buses => 7,
            Self::BusNames => 8,
            Self::Nanoseconds(_) => 9,
            Self::EarlierStamps => 10,
            Self::LostCounts => 11,
        }
    }

    fn message(self, name: &str, count: u64) -> String {
        match self {
            Self::FdFrames => format!("{name} holds no CAN FD frames: {count} left out"),
            Self::RemoteFrames => format!("{name} holds no remote requests: {count} left out"),
            Self::ErrorFrames => format!("{name} holds no error frames: {count} left out"),
            Self::ErrorDetails => format!("{name} keeps little of what an error frame says: {count} cut down"),
            Self::ErrorPassive => {
                format!("{name} does not say whether a sender is error-passive (ESI): {count} frames were from one")
            }
            Self::LengthCodes => format!("{name} holds no length code above 8 of 8 bytes: {count} became 8"),
            Self::Directions => format!("{name} does not say who sent a frame: {count} sent ones seem received"),
            Self::Buses => format!("{name} does not tell buses apart: {count} frames of others are on the first"),
            Self::BusNames => {
                format!("{name} cannot keep the names of all buses: {count} records will be read under another")
            }
            Self::Nanoseconds(most) => {
                format!("{name} keeps coarser stamps: {count} were cut down, by up to {}", time(most))
            }
            Self::EarlierStamps => {
                format!("{name} holds no stamps before its first: {count} earlier ones were put there")
            }
            Self::LostCounts => format!("{name} holds no word of lost frames: {count} times it was left out"),
        }
    }
}

/// Nanoseconds in a unit that suits.
fn time(nanos: i64) -> String {
    match nanos {
        ..1_000 => format!("{nanos} ns"),
        1_000..1_000_000 => format!("{:.1} us", nanos as f64 / 1e3),
        _ => format!("{:.1} ms", nanos as f64 / 1e6),
    }
}
