//! A budget for people, as a table, and for programs, as JSON.

use std::fmt;

use serde::Serialize;

use super::{Budget, Row, lowest_bit_rate, shortest_period};
use crate::frame::FrameKind;
use crate::schema::{Cause, Profile};
use crate::time::Duration;

/// A budget, what is too late in it, and what would do instead.
#[derive(Clone, Debug)]
pub struct Report {
    /// The budget.
    pub budget: Budget,
    /// What is too late, one sentence each: found and expected.
    pub failures: Vec<String>,
    /// The lowest standard bit rate that would do at this period, bit/s.
    pub lowest_bit_rate_bit_s: Option<u32>,
    /// The shortest period that this bit rate can do.
    pub shortest_period: Option<Duration>,
}

/// The whole as JSON. Times are in microseconds; `null` is for ever.
#[derive(Serialize)]
struct Json<'r> {
    bit_rate_bit_s: u32,
    period_us: f64,
    lateness_us: f64,
    answer_us: f64,
    load_percent: f64,
    messages: Vec<JsonRow<'r>>,
    exchange_us: Option<f64>,
    in_time: bool,
    failures: &'r [String],
    lowest_bit_rate_bit_s: Option<u32>,
    shortest_period_us: Option<f64>,
}

/// One message in it.
#[derive(Serialize)]
struct JsonRow<'r> {
    id: u32,
    is_extended: bool,
    is_remote: bool,
    message: &'r str,
    sender: &'r str,
    bytes: usize,
    period_us: f64,
    transmission_us: f64,
    response_us: Option<f64>,
    deadline_us: f64,
    slack_us: Option<f64>,
}

const HEADER: [&str; 9] = ["id", "message", "sender", "bytes", "every", "on the wire", "response", "deadline", "slack"];

impl Report {
    /// Makes the report of a profile's budget.
    pub fn of(profile: &Profile, budget: Budget) -> Self {
        let terms = budget.terms;
        Self {
            failures: failures(&budget),
            lowest_bit_rate_bit_s: lowest_bit_rate(profile, &terms),
            shortest_period: shortest_period(profile, &terms),
            budget,
        }
    }

    /// What to do about a budget that fails, in one sentence.
    pub fn remedy(&self) -> String {
        let rate = self.budget.terms.bit_rate_bit_s;
        match (self.lowest_bit_rate_bit_s, self.shortest_period) {
            (Some(bit_rate), Some(period)) => format!(
                "make `bus.bitrate_bit_s` {bit_rate}, or keep {rate} bit/s and make `period_s` {} or longer",
                period.as_secs_f64()
            ),
            (Some(bit_rate), None) => {
                format!("make `bus.bitrate_bit_s` {bit_rate}: at {rate} bit/s no `period_s` is long enough")
            }
            (None, Some(period)) => {
                let least = period.as_secs_f64();
                format!("no bit rate up to 1000000 bit/s would do; at {rate} bit/s make `period_s` {least} or longer")
            }
            (None, None) => "let the drives send less by their own clocks".to_owned(),
        }
    }

    /// The whole as one JSON object.
    pub fn json(&self) -> String {
        let Self { budget, failures, lowest_bit_rate_bit_s, shortest_period } = self;
        let json = Json {
            bit_rate_bit_s: budget.terms.bit_rate_bit_s,
            period_us: micros(budget.terms.period),
            lateness_us: micros(budget.terms.lateness),
            answer_us: micros(budget.terms.answer),
            load_percent: 100.0 * budget.load,
            messages: budget.rows.iter().map(json_row).collect(),
            exchange_us: budget.exchange.map(micros),
            in_time: budget.holds(),
            failures,
            lowest_bit_rate_bit_s: *lowest_bit_rate_bit_s,
            shortest_period_us: shortest_period.map(micros),
        };
        serde_json::to_string_pretty(&json).expect("strings and numbers can be written as JSON")
    }
}

impl fmt::Display for Report {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { budget, .. } = self;
        let terms = &budget.terms;
        writeln!(out, "{} bit/s, T {}; times in ms, at worst", terms.bit_rate_bit_s, millis(terms.period))?;
        write_table(out, &budget.rows)?;
        writeln!(out, "load        {:.1} % when every frame is as long as it can be", 100.0 * budget.load)?;
        let exchange = budget.exchange.map_or("for ever".to_owned(), millis);
        writeln!(out, "exchange    {exchange} of {}: {}", millis(terms.period), steps(&budget.rows))?;
        let slowest = self.lowest_bit_rate_bit_s.map_or("none".to_owned(), |rate| format!("{rate} bit/s"));
        writeln!(out, "bit rate    the lowest that would do for this T: {slowest}")?;
        let shortest = self.shortest_period.map_or("none".to_owned(), millis);
        writeln!(out, "T           the shortest that this bit rate can do: {shortest}")?;
        for (index, failure) in self.failures.iter().enumerate() {
            writeln!(out, "{}{failure}", if index == 0 { "too late    " } else { "            " })?;
        }
        match self.failures.is_empty() {
            true => write!(out, "verdict     in time"),
            false => write!(out, "verdict     the bus cannot carry this in time: {}", self.remedy()),
        }
    }
}

fn failures(budget: &Budget) -> Vec<String> {
    let period = budget.terms.period;
    let sentence = |what: &str, found: Option<Duration>, expected: Duration| {
        let found = found.map_or("may wait for ever".to_owned(), |found| format!("takes up to {}", millis(found)));
        format!("{what} {found}, expected at most {}", millis(expected))
    };
    let late = budget.rows.iter().filter(|row| !row.holds());
    let of_rows = late.map(|row| sentence(&title(row), row.response, row.period));
    let of_exchange = (!budget.exchange_holds()).then(|| sentence("the exchange of a period", budget.exchange, period));
    of_exchange.into_iter().chain(of_rows).collect()
}

/// Who speaks in the exchange, one after the other.
fn steps(rows: &[Row]) -> String {
    let steps =
        [(Cause::Beginning, "from the stack"), (Cause::Asked, "from the drives"), (Cause::Answered, "from the stack")];
    let count = |cause: Cause| rows.iter().filter(|row| row.cause == cause).count();
    let said = steps.into_iter().map(|(cause, whose)| (count(cause), whose)).filter(|&(count, _)| count > 0);
    let words = said.map(|(count, whose)| format!("{count} frame{} {whose}", if count == 1 { "" } else { "s" }));
    words.collect::<Vec<_>>().join(", then ")
}

fn write_table(out: &mut fmt::Formatter<'_>, rows: &[Row]) -> fmt::Result {
    let cells: Vec<[String; 9]> = std::iter::once(HEADER.map(str::to_owned)).chain(rows.iter().map(cells)).collect();
    let width = |column: usize| cells.iter().map(|row| row[column].chars().count()).max().unwrap_or_default();
    let widths: [usize; 9] = std::array::from_fn(width);
    for row in &cells {
        let line: Vec<String> = row
            .iter()
            .zip(widths)
            .enumerate()
            .map(
                |(column, (cell, width))| {
                    if column < 3 { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
                },
            )
            .collect();
        writeln!(out, "{}", line.join("  "))?;
    }
    Ok(())
}

fn cells(row: &Row) -> [String; 9] {
    let number = |duration: Duration| format!("{:.3}", micros(duration) / 1_000.0);
    let or_never = |duration: Option<Duration>, never: &str| duration.map_or(never.to_owned(), number);
    [
        format!("0x{}", row.id),
        title(row),
        row.sender.clone(),
        row.bytes.to_string(),
        number(row.period),
        number(row.transmission),
        or_never(row.response, "for ever"),
        number(row.period),
        or_never(slack(row), "none"),
    ]
}

fn json_row(row: &Row) -> JsonRow<'_> {
    JsonRow {
        id: row.id.raw(),
        is_extended: row.id.is_extended(),
        is_remote: row.kind == FrameKind::Remote,
        message: &row.name,
        sender: &row.sender,
        bytes: row.bytes,
        period_us: micros(row.period),
        transmission_us: micros(row.transmission),
        response_us: row.response.map(micros),
        deadline_us: micros(row.period),
        slack_us: slack(row).map(micros),
    }
}

/// What is left of the time until the next one is due; negative when it is not
/// enough.
fn slack(row: &Row) -> Option<Duration> {
    row.response.map(|response| row.period - response)
}

fn title(row: &Row) -> String {
    if row.kind == FrameKind::Remote { format!("{} (request)", row.name) } else { row.name.clone() }
}

fn micros(duration: Duration) -> f64 {
    duration.as_nanos() as f64 / 1_000.0
}

fn millis(duration: Duration) -> String {
    format!("{:.3} ms", micros(duration) / 1_000.0)
}
