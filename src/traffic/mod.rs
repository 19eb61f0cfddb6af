//! Recorded traffic: the files that CAN tools keep it in, read and written as
//! one list of [`Record`]s.
//!
//! ```text
//! file -> open() -> records and findings -> Writer -> file
//!                                        \-> Survey -> what is in it
//! ```
//!
//! Readers go through a file once and keep no more of it in memory than a
//! line or a chunk. What is damaged is a [`Finding`] with its place, and
//! reading goes on behind it where the format allows. Writers count what
//! their format cannot hold ([`Losses`]).
//!
//! Formats are told by what is in a file, or by its extension ([`Format`]);
//! each has a folder or a file of its own here and knows of no other.
//! Dates that a file gives without a time zone are taken for UTC, and written
//! so.

mod asc;
mod blf;
mod busmaster;
mod bytes;
mod candump;
mod carbus;
mod convert;
mod csv;
mod date;
mod finding;
mod format;
mod line_reader;
mod lines;
mod losses;
mod mcap;
mod number;
mod numbering;
mod open;
mod pcap;
mod record;
mod socketcan;
pub mod survey;
mod trc;
mod words;

pub use convert::{Conversion, convert};
pub use finding::{Finding, Place};
pub use format::{Format, TrcVersion};
pub use losses::{Loss, Losses};
pub use open::{Reader, Writer, create, open, read};
pub use record::{Buses, Content, Direction, ErrorFrame, Record, RecordedFrame, TooManyBuses};
pub use survey::Survey;
