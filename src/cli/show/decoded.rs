//! Frames as lines of signals with their units and the names of their values.

use std::io::{self, Write};

use super::signals::{Seconds, find, layout_of};
use crate::config::Problem;
use crate::frame::{CanId, Frame, FrameKind};
use crate::schema::{Dbc, Signal};
use crate::traffic::{Buses, Content, Direction, Record};

/// Prints records.
pub struct Lines<'d> {
    dbcs: &'d [Dbc],
    /// None for all there is.
    only: Option<Vec<(CanId, &'d Signal)>>,
}

impl<'d> Lines<'d> {
    /// With the signals called `names`, or with all if there are none.
    ///
    /// # Errors
    /// There is no signal of such a name.
    pub fn find(dbcs: &'d [Dbc], names: &[String]) -> Result<Self, Problem> {
        let found: Vec<_> = names.iter().map(|name| find(dbcs, name)).collect::<Result<_, _>>()?;
        Ok(Self { dbcs, only: (!names.is_empty()).then(|| found.concat()) })
    }

    /// Writes a line for a record, unless it has none of the signals.
    pub fn put(&self, out: &mut dyn Write, record: &Record, buses: &Buses) -> io::Result<()> {
        let what = match &record.content {
            Content::Frame(recorded) => match self.frame(&recorded.frame) {
                Some(what) => what,
                None => return Ok(()),
            },
            _ if self.only.is_some() => return Ok(()),
            Content::Error(error) => format!("error frame {:08X} {:02X?}", error.class, error.data),
            Content::Lost(count) => format!("{count} frames lost before this"),
        };
        let sent = if record.direction == Direction::Sent { ">" } else { " " };
        let (at, bus) = (Seconds(record.at.as_nanos()), buses.name(record.bus));
        writeln!(out, "{at}  {bus}{sent} {what}")
    }

    /// What a frame says; `None` where nobody asked for it.
    fn frame(&self, frame: &Frame) -> Option<String> {
        let Some(layout) = layout_of(self.dbcs, frame.id).filter(|_| frame.kind != FrameKind::Remote) else {
            return self.only.is_none().then(|| frame.to_string());
        };
        let is_wanted = |signal: &Signal| {
            self.only
                .as_ref()
                .is_none_or(|only| only.iter().any(|(id, wanted)| *id == frame.id && wanted.name == signal.name))
        };
        let signals: Vec<String> = layout
            .decode(frame)
            .filter(|(signal, _)| is_wanted(signal))
            .map(|(s, value)| text(s, value, frame))
            .collect();
        if signals.is_empty() && self.only.is_some() {
            return None;
        }
        Some(format!("{} {}  {}", frame.id, layout.name, signals.join("  ")))
    }
}

/// `Speed=12.5 rad/s`, `State=Enabled`
fn text(signal: &Signal, value: f64, frame: &Frame) -> String {
    if let Some(named) = signal.decode_name(frame.storage()) {
        return format!("{}={named}", signal.name);
    }
    let unit = if signal.unit.is_empty() { String::new() } else { format!(" {}", signal.unit) };
    format!("{}={value}{unit}", signal.name)
}
