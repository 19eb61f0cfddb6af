//! Whether a stack sends the same frames as the recorded one.

use std::fmt;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant as WallInstant;

use super::origin::Origin;
use super::{broken, say, say_cut};
use crate::config::Problems;
use crate::event::{Event, Sink};
use crate::frame::Frame;
use crate::replay::{Difference, Recorded, RecordedItem, Replay};
use crate::schema::Dbc;
use crate::time::Instant;

/// Replays a log up to the first frame that is not as recorded.
pub fn run(origin: &Origin, log: &[u8], name: &Path) -> Result<ExitCode, Problems> {
    let began = now();
    let mut replay = Replay::new(&origin.config, origin.paths.clone());
    let mut recorded = Recorded::only_exchange(log).map_err(|what| broken(name, &what))?;
    let mut has_begun = false;
    let mut difference = None;
    while let (None, Some(item)) = (difference, recorded.next()) {
        if let RecordedItem::Exchange(exchange) = item.map_err(|what| broken(name, &what))? {
            has_begun = true;
            difference = replay.take(&exchange, &mut Nobody).map_err(|what| broken(name, &what.to_string()))?;
        }
    }
    if !has_begun {
        let what =
            "it does not say what went into a stack (/canloop/exchange), as logs of canloop drive and hil-sim run do";
        return Err(broken(name, what).into());
    }
    let (ticks, frames) = (replay.ticks(), replay.frames());
    let wall_s = now().duration_since(began).as_secs_f64();
    let speed = ticks as f64 * origin.config.period.as_secs_f64() / wall_s.max(1e-9);
    match difference {
        None => say(format_args!("{}: the same, bit for bit", name.display())),
        Some(difference) => {
            say(format_args!("{}: not the same", name.display()));
            say(Told { difference, dbc: &origin.config.profile.dbc });
        }
    }
    say(format_args!("  periods          {ticks} in {wall_s:.2} s, {speed:.0} times real time"));
    say(format_args!("  frames           {frames} sent as recorded"));
    say_cut(recorded.is_cut());
    Ok(ExitCode::from(u8::from(difference.is_some())))
}

#[allow(clippy::disallowed_methods, reason = "how fast it was is for people; nothing depends on it")]
fn now() -> WallInstant {
    WallInstant::now()
}

/// A reader of events that has no use for any.
struct Nobody;

impl Sink for Nobody {
    fn event(&mut self, _at: Instant, _event: &Event) {}
}

/// A difference in words.
struct Told<'d> {
    difference: Difference,
    dbc: &'d Dbc,
}

impl fmt::Display for Told<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Difference { tick, at, recorded, replayed } = self.difference;
        writeln!(out, "  first difference tick {tick}, {:.6} s", at.as_secs_f64())?;
        write!(out, "  recorded         {}\n  replayed         ", self.named(Some(recorded)))?;
        write!(out, "{}", self.named(replayed))?;
        let Some(replayed) = replayed else { return Ok(()) };
        let message = self.dbc.messages.iter().find(|message| message.id == recorded.id);
        let Some(message) = message.filter(|_| recorded.id == replayed.id) else { return Ok(()) };
        let pairs = message.decode(&recorded).zip(message.decode(&replayed));
        for ((signal, was), (_, is)) in pairs.filter(|((_, was), (_, is))| was != is) {
            write!(out, "\n  {:<16} {was} recorded, {is} replayed {}", signal.name, signal.unit)?;
        }
        Ok(())
    }
}

impl Told<'_> {
    fn named(&self, frame: Option<Frame>) -> String {
        let Some(frame) = frame else { return "nothing more".to_owned() };
        let message = self.dbc.messages.iter().find(|message| message.id == frame.id);
        let name = message.map_or_else(|| format!("{:#x}", frame.id.raw()), |message| message.name.clone());
        let bytes: Vec<String> = frame.payload().iter().map(|byte| format!("{byte:02X}")).collect();
        format!("{name} [{}]", bytes.join(" "))
    }
}
