//! A survey for people, in lines that fit a terminal.

use std::fmt::Write;

use super::message::Message;
use super::{Bus, Survey};
use crate::time::Instant;
use crate::traffic::Buses;
use crate::traffic::date::Date;

/// Stamps from here on, ns, are dates: 1990.
const FIRST_DATE_NS: i64 = 631_152_000_000_000_000;
const MILLI: f64 = 1e3;

impl Survey {
    /// All of it.
    pub fn text(&self, buses: &Buses) -> String {
        let mut out = String::new();
        self.put_whole(&mut out);
        self.put_buses(&mut out, buses);
        self.put_messages(&mut out, buses);
        out
    }

    fn put_whole(&self, out: &mut String) {
        let (frames, errors, lost) = (self.sum(|bus| bus.frames), self.sum(|bus| bus.errors), self.sum(|bus| bus.lost));
        let fd = self.sum(|bus| bus.fd);
        let of_fd = if fd > 0 { format!(", {fd} of them CAN FD") } else { String::new() };
        let _ = writeln!(out, "  frames         {frames}{of_fd}; {errors} error frames, {lost} lost by the logger");
        let (Some(first), Some(last)) = (self.first, self.last) else { return };
        let _ = writeln!(out, "  span           {:.6} s, from {} to {}", self.span_s(), moment(first), moment(last));
        let resolution =
            self.stamps.resolution_ns().map_or_else(|| "all 0".to_owned(), |ns| format!("in steps of {}", unit(ns)));
        let backwards = match self.stamps.backwards {
            0 => "none goes back".to_owned(),
            count => format!("{count} go back, by up to {:.6} s", self.stamps.furthest_back.as_secs_f64()),
        };
        let _ =
            writeln!(out, "  stamps         {resolution}; {backwards}; {} are as the one before", self.stamps.repeated);
        if let Some((gap, at)) = self.stamps.longest_gap {
            let since = (at - first).as_secs_f64();
            let _ = writeln!(out, "  longest gap    {:.6} s, {since:.6} s after the beginning", gap.as_secs_f64());
        }
    }

    fn put_buses(&self, out: &mut String, buses: &Buses) {
        if self.buses.is_empty() {
            return;
        }
        let head = ("bus", "frames", "sent", "errors", "lost", "frames/s");
        let _ =
            write!(out, "\n{:<12} {:>10} {:>10} {:>8} {:>8} {:>10}", head.0, head.1, head.2, head.3, head.4, head.5);
        out.push_str(if self.rates.is_some() { "   load %  busiest s %\n" } else { "   load: give --bitrate\n" });
        for (index, bus) in (0..).zip(&self.buses) {
            let Bus { frames, sent, errors, lost, .. } = bus;
            let span_s = self.span_s();
            let rate = if span_s > 0.0 { *frames as f64 / span_s } else { 0.0 };
            let _ = write!(
                out,
                "{:<12} {frames:>10} {sent:>10} {errors:>8} {lost:>8} {rate:>10.1}",
                short(buses.name(index), 12)
            );
            if self.rates.is_some() {
                let load = if span_s > 0.0 { 100.0 * bus.busy_s / span_s } else { 0.0 };
                let _ = write!(out, " {load:>8.2} {:>12.2}", 100.0 * bus.busiest());
            }
            out.push('\n');
        }
    }

    fn put_messages(&self, out: &mut String, buses: &Buses) {
        if self.messages.is_empty() {
            return;
        }
        let _ = writeln!(
            out,
            "\n{:<12} {:<8} {:<6} {:>5} {:>10} {:>12} {:>12} {:>12} {:>12}",
            "bus", "id", "kind", "bytes", "count", "period ms", "jitter ms", "longest ms", "after s"
        );
        for ((bus, _), message) in &self.messages {
            let name = short(buses.name(*bus), 12);
            let Message { id, count, lengths, .. } = message;
            let bytes =
                if lengths.0 == lengths.1 { lengths.0.to_string() } else { format!("{}-{}", lengths.0, lengths.1) };
            let id = id.to_string();
            let _ = write!(out, "{name:<12} {id:<8} {:<6} {bytes:>5} {count:>10}", message.kind());
            let periods = message.periods();
            let figure = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.3}"));
            let (median, jitter) = (periods.map(|p| p.median_s * MILLI), periods.map(|p| p.jitter_s * MILLI));
            let longest = message.longest_gap.map(|(gap, _)| gap.as_secs_f64() * MILLI);
            let after = message.longest_gap.and_then(|(_, at)| Some((at - self.first?).as_secs_f64()));
            let (median, jitter, longest, after) = (figure(median), figure(jitter), figure(longest), figure(after));
            let _ = writeln!(out, " {median:>12} {jitter:>12} {longest:>12} {after:>12}");
        }
        out.push_str(
            "\nperiod: the median. jitter: within which 98 of 100 periods lie. longest: the longest period,\n\
             and how long after the beginning of the log it began.\n",
        );
    }
}

/// A date, or seconds where the log does not know the date.
fn moment(at: Instant) -> String {
    let nanos = at.as_nanos();
    if nanos < FIRST_DATE_NS {
        return format!("{:.6} s", at.as_secs_f64());
    }
    let Date { year, month, day, hour, minute, second, nanos } = Date::from_nanos(nanos);
    format!("{year}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}.{:06}", nanos / 1_000)
}

/// A power of ten of nanoseconds, in a unit that suits.
fn unit(nanos: u64) -> String {
    match nanos {
        1_000_000_000.. => "1 s".to_owned(),
        1_000_000.. => format!("{} ms", nanos / 1_000_000),
        1_000.. => format!("{} us", nanos / 1_000),
        _ => format!("{nanos} ns"),
    }
}

/// The beginning of a name.
fn short(name: &str, width: usize) -> String {
    name.chars().take(width).collect()
}
