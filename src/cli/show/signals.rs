//! Signals as columns of a CSV file.

use std::io::{self, Write};

use crate::config::{Problem, nearest};
use crate::frame::CanId;
use crate::schema::{Dbc, MessageLayout, Signal};
use crate::traffic::Record;

/// The columns that were asked for.
pub struct Columns<'d> {
    dbcs: &'d [Dbc],
    columns: Vec<Column<'d>>,
}

/// One of them: all signals that its name stands for.
struct Column<'d> {
    name: String,
    signals: Vec<(CanId, &'d Signal)>,
}

impl<'d> Columns<'d> {
    /// Finds the signals called `names`: each `Signal` or `Message.Signal`.
    ///
    /// # Errors
    /// There is none of that name.
    pub fn find(dbcs: &'d [Dbc], names: &[String]) -> Result<Self, Problem> {
        let columns = names.iter().map(|name| {
            let signals = find(dbcs, name)?;
            Ok(Column { name: name.clone(), signals })
        });
        Ok(Self { dbcs, columns: columns.collect::<Result<_, Problem>>()? })
    }

    /// Writes the names of the columns.
    pub fn put_header(&self, out: &mut dyn Write) -> io::Result<()> {
        write!(out, "time_s")?;
        for column in &self.columns {
            write!(out, ",{}", column.name)?;
        }
        writeln!(out)
    }

    /// Writes a row if the record has one of the signals; a column whose
    /// signal it has not stays empty.
    pub fn put_row(&self, out: &mut dyn Write, record: &Record) -> io::Result<()> {
        let Some(frame) = record.frame() else { return Ok(()) };
        let Some(layout) = layout_of(self.dbcs, frame.id) else { return Ok(()) };
        let wanted = |(id, _): &(CanId, &Signal)| *id == frame.id;
        if !self.columns.iter().any(|column| column.signals.iter().any(wanted)) {
            return Ok(());
        }
        let values: Vec<(&Signal, f64)> = layout.decode(frame).collect();
        let value = |column: &Column<'_>| {
            let (_, signal) = column.signals.iter().find(|signal| wanted(signal))?;
            values.iter().find(|(carried, _)| carried.name == signal.name).map(|(_, value)| *value)
        };
        if self.columns.iter().all(|column| value(column).is_none()) {
            return Ok(());
        }
        write!(out, "{}", Seconds(record.at.as_nanos()))?;
        for column in &self.columns {
            match value(column) {
                Some(value) => write!(out, ",{value}")?,
                None => write!(out, ",")?,
            }
        }
        writeln!(out)
    }
}

/// Nanoseconds, printed as seconds without a detour over `f64`.
pub struct Seconds(pub i64);

impl std::fmt::Display for Seconds {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let sign = if self.0 < 0 { "-" } else { "" };
        let nanos = self.0.unsigned_abs();
        write!(out, "{sign}{}.{:09}", nanos / 1_000_000_000, nanos % 1_000_000_000)
    }
}

/// The message with that id in the first file that knows it.
pub fn layout_of(dbcs: &[Dbc], id: CanId) -> Option<&MessageLayout> {
    dbcs.iter().find_map(|dbc| dbc.message_by_id(id))
}

/// All signals that a name stands for.
///
/// # Errors
/// There is none.
pub fn find<'d>(dbcs: &'d [Dbc], name: &str) -> Result<Vec<(CanId, &'d Signal)>, Problem> {
    let all =
        || dbcs.iter().flat_map(|dbc| &dbc.messages).flat_map(|layout| layout.signals.iter().map(move |s| (layout, s)));
    let is_meant = |layout: &MessageLayout, signal: &Signal| match name.split_once('.') {
        Some((message, rest)) => layout.name == message && signal.name == rest,
        None => signal.name == name,
    };
    let found: Vec<_> = all().filter(|(layout, signal)| is_meant(layout, signal)).map(|(l, s)| (l.id, s)).collect();
    if !found.is_empty() {
        return Ok(found);
    }
    let problem = Problem::bare(format!("no message of the DBC files has a signal called {name}"));
    let wanted = name.rsplit('.').next().unwrap_or(name);
    Err(match nearest(wanted, all().map(|(_, signal)| signal.name.as_str())) {
        Some(near) => problem.help(format!("did you mean {near}?")),
        None => problem,
    })
}
