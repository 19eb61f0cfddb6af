//! Open loop: the plant under torques from a table, with no control and no bus.
//!
//! The table is CSV with the header `t_s,torque_right_nm,torque_left_nm`. Each
//! row holds until the next; the last one only ends the run.

use std::io::{self, Write};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use canloop::config::{Problem, Source};
use canloop::wheels::Wheels;

use crate::plant::{Plant, Torque};

const COLUMNS: [&str; 3] = ["t_s", "torque_right_nm", "torque_left_nm"];
const OUT_HEADER: &str = "t_s,x_m,y_m,heading_rad,theta_right_rad,theta_left_rad,omega_right_rad_s,omega_left_rad_s";
const HELP: &str = "the table is CSV: the header t_s,torque_right_nm,torque_left_nm, then three numbers a line";

/// One row of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueRow {
    /// From when on, s.
    pub t_s: f64,
    /// The torque at the wheels, N m.
    pub torque_nm: Wheels<f64>,
}

/// Reads a table of torques; it has at least one row, and time increases.
///
/// # Errors
/// The first thing wrong: an unreadable file, a header that differs, a line
/// with a gap, a field that is not a finite number, a time that is no later
/// than the one before, or no rows at all.
pub fn read(path: &Path) -> Result<Vec<TorqueRow>, Problem> {
    let name = path.display().to_string();
    let text = std::fs::read_to_string(path)
        .map_err(|error| Problem::bare(format!("cannot read {name}: {error}")).help(HELP))?;
    // Some spreadsheets begin a file with this invisible mark.
    parse(&Source::new(name, text.trim_start_matches('\u{feff}')))
}

/// The same from a text.
///
/// # Errors
/// See [`read`].
pub fn parse(source: &Arc<Source>) -> Result<Vec<TorqueRow>, Problem> {
    let mut lines = lines(source);
    check_header(source, lines.next().unwrap_or(0..0))?;
    let mut rows: Vec<TorqueRow> = Vec::new();
    for line in lines {
        let row = parse_row(source, line.clone())?;
        if let Some(last) = rows.last().filter(|last| row.t_s <= last.t_s) {
            let label = format!("found {} after {}, expected a later time", row.t_s, last.t_s);
            return Err(problem(source, fields(source, line)[0].clone(), "time does not increase", label));
        }
        rows.push(row);
    }
    if rows.is_empty() {
        let end = source.text.len();
        return Err(problem(source, end..end, "no torques", "found no row, expected at least one below the header"));
    }
    Ok(rows)
}

/// Drives `plant` through the table and writes its state at the time of each
/// row: CSV with a header, SI units, each number in the shortest form that
/// reads back as the same `f64`.
///
/// # Errors
/// When `out` cannot be written.
pub fn run_open_loop(mut plant: Plant, rows: &[TorqueRow], out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "{OUT_HEADER}")?;
    let mut before: Option<&TorqueRow> = None;
    for row in rows {
        if let Some(before) = before {
            plant.advance(row.t_s - before.t_s, before.torque_nm.map(Torque::constant));
        }
        write_state(&plant, row.t_s, out)?;
        before = Some(row);
    }
    Ok(())
}

fn write_state(plant: &Plant, t_s: f64, out: &mut impl Write) -> io::Result<()> {
    let state = plant.state();
    let numbers = [
        t_s,
        state.pose.x_m,
        state.pose.y_m,
        state.pose.heading_rad,
        state.angle_rad.right,
        state.angle_rad.left,
        state.speed_rad_s.right,
        state.speed_rad_s.left,
    ];
    for (index, number) in numbers.into_iter().enumerate() {
        // Adding zero makes -0 plain 0.
        write!(out, "{}{}", if index > 0 { "," } else { "" }, number + 0.0)?;
    }
    writeln!(out)
}

/// Where each line is, without its end; empty lines at the end left out.
fn lines(source: &Source) -> impl Iterator<Item = Range<usize>> {
    let mut start = 0;
    source.text.trim_end().split_inclusive('\n').map(move |line| {
        let span = start..start + line.trim_end_matches(['\r', '\n']).len();
        start += line.len();
        span
    })
}

/// Where the fields of a line are, without the spaces around them.
fn fields(source: &Source, line: Range<usize>) -> Vec<Range<usize>> {
    let mut start = line.start;
    let field = |text: &str| {
        let trimmed = start + (text.len() - text.trim_start().len());
        let span = trimmed..trimmed + text.trim().len();
        start += text.len() + 1;
        span
    };
    source.text[line].split(',').map(field).collect()
}

fn check_header(source: &Arc<Source>, line: Range<usize>) -> Result<(), Problem> {
    let end = line.end;
    let fields = fields(source, line);
    for index in 0..fields.len().max(COLUMNS.len()) {
        let span = fields.get(index).cloned().unwrap_or(end..end);
        let found = fields.get(index).map(|span| &source.text[span.clone()]);
        let expected = COLUMNS.get(index).copied();
        if found != expected {
            let label = format!("found {}, expected {}", quoted(found), quoted(expected));
            return Err(problem(source, span, "not the header of a torque table", label));
        }
    }
    Ok(())
}

/// Beyond any motor's torque, N m, and any run's time, s: with more the plant's
/// steps would be so short that it never came to an end.
const LARGEST: f64 = 1e6;

fn parse_row(source: &Arc<Source>, line: Range<usize>) -> Result<TorqueRow, Problem> {
    let end = line.end;
    if source.text[line.clone()].trim().is_empty() {
        return Err(problem(source, line, "a blank line in the table", "found nothing, expected three numbers"));
    }
    let fields = fields(source, line);
    let number = |index: usize| {
        let column = COLUMNS[index];
        let Some(span) = fields.get(index).cloned() else {
            let label = format!("found {} of 3 fields, expected `{column}` here", fields.len());
            return Err(problem(source, end..end, "a field is missing", label));
        };
        parse_number(source, span, column)
    };
    let row = TorqueRow { t_s: number(0)?, torque_nm: Wheels { right: number(1)?, left: number(2)? } };
    match fields.get(COLUMNS.len()) {
        None => Ok(row),
        Some(extra) => {
            let label = format!("found {} fields, expected 3", fields.len());
            Err(problem(source, extra.start..end, "more fields than columns", label))
        }
    }
}

fn parse_number(source: &Arc<Source>, span: Range<usize>, column: &str) -> Result<f64, Problem> {
    let text = &source.text[span.clone()];
    let title = match text.parse::<f64>() {
        Ok(number) if number.abs() <= LARGEST => return Ok(number),
        Ok(number) if number.is_finite() => {
            let label = format!("found `{text}`, expected a number from -{LARGEST} to {LARGEST} for `{column}`");
            return Err(problem(source, span, "a number out of range", label));
        }
        Ok(_) => "not a finite number",
        Err(_) if text.is_empty() => "a field is empty",
        Err(_) => "not a number",
    };
    let label = format!("found {}, expected a finite number for `{column}`", quoted(Some(text)));
    Err(problem(source, span, title, label))
}

fn quoted(field: Option<&str>) -> String {
    field.filter(|field| !field.is_empty()).map_or("nothing".to_owned(), |field| format!("`{field}`"))
}

fn problem(source: &Arc<Source>, span: Range<usize>, title: &str, label: impl Into<String>) -> Problem {
    Problem::at(source, span, title, label).help(HELP)
}
