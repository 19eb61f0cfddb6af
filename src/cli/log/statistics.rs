//! How a log goes on, in a line.

use std::io::{IsTerminal as _, Write as _};

use crate::capture::{BusStatistics, Hearing, Recorder};

/// Says once a second what has come.
pub struct Line {
    /// Of each bus, bit/s, where it is known.
    bit_rates: Vec<Option<u32>>,
    before: Vec<BusStatistics>,
    seconds: u64,
    is_on_a_terminal: bool,
}

impl Line {
    /// For these buses; `bit_rate_bit_s` is that of those that do not say.
    pub fn new(hearings: &[Hearing], bit_rate_bit_s: Option<u32>) -> Self {
        let bit_rate = |hearing: &Hearing| bit_rate_of(&hearing.name).or(bit_rate_bit_s);
        Self {
            bit_rates: hearings.iter().map(bit_rate).collect(),
            before: vec![BusStatistics::default(); hearings.len()],
            seconds: 0,
            is_on_a_terminal: std::io::stderr().is_terminal(),
        }
    }

    /// What came in the last second; on a terminal over what it said before.
    pub fn show(&mut self, recorder: &Recorder<'_>) {
        self.seconds += 1;
        let now: Vec<(String, BusStatistics)> =
            recorder.statistics().map(|(name, statistics)| (name.to_owned(), *statistics)).collect();
        if self.is_on_a_terminal {
            let parts: Vec<String> = now
                .iter()
                .zip(&self.before)
                .zip(&self.bit_rates)
                .map(|(((name, now), before), bit_rate)| {
                    let load = load(now.since(before).bits, *bit_rate, 1);
                    format!("{name} {} frames/s{load}, {} lost", now.since(before).frames, now.lost())
                })
                .collect();
            let megabytes = recorder.bytes() as f64 / 1e6;
            let _ = write!(std::io::stderr(), "\r\x1b[K{} s  {}  {megabytes:.1} MB", self.seconds, parts.join("  "));
        }
        self.before = now.into_iter().map(|(_, statistics)| statistics).collect();
    }

    /// What came in all.
    pub fn end(&self, recorder: &Recorder<'_>) {
        if self.is_on_a_terminal && self.seconds > 0 {
            let _ = writeln!(std::io::stderr());
        }
        for ((name, statistics), bit_rate) in recorder.statistics().zip(&self.bit_rates) {
            let BusStatistics { frames, errors, bits, lost_on_the_way, lost_here } = statistics;
            let load = load(*bits, *bit_rate, self.seconds.max(1));
            super::say(format_args!(
                "{name}: {frames} frames{load}, {errors} error frames, {lost_on_the_way} lost on the way, \
                 {lost_here} lost here"
            ));
        }
    }
}

fn load(bits: u64, bit_rate_bit_s: Option<u32>, seconds: u64) -> String {
    bit_rate_bit_s.map_or_else(String::new, |rate| {
        format!(", load {:.1} %", 100.0 * bits as f64 / f64::from(rate) / seconds as f64)
    })
}

#[cfg(target_os = "linux")]
fn bit_rate_of(interface: &str) -> Option<u32> {
    crate::bus::CanLink::read(interface).ok()?.bit_rate_bit_s
}

#[cfg(not(target_os = "linux"))]
fn bit_rate_of(_: &str) -> Option<u32> {
    None
}
