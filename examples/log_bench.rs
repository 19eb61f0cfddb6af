//! How fast frames get into MCAP, for `scripts/bench` to compare.
//!
//! ```text
//! log_bench ours FILE COUNT [DBC]     through canloop's log, decoded as well with a DBC
//! log_bench bare FILE COUNT           the same messages through the `mcap` crate's own writer
//! log_bench candump FILE COUNT        the same frames as candump would write them
//! ```
//!
//! The first two print frames a second.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;

use canloop::frame::{CanId, Frame};
use canloop::log::{FrameLog, LoggedBus, LoggedFrame};
use canloop::run::Clock;
use canloop::schema::Dbc;
use canloop::time::Instant;
use mcap::records::MessageHeader;

/// Eight ids, as on a robot.
const IDS: [u16; 8] = [0x080, 0x181, 0x182, 0x201, 0x202, 0x701, 0x702, 0x7FF];

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match args.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["ours", file, count] => ours(file, count.parse()?, None),
        ["ours", file, count, dbc] => ours(file, count.parse()?, Some(dbc)),
        ["bare", file, count] => bare(file, count.parse()?),
        ["candump", file, count] => candump(file, count.parse()?),
        _ => Err("usage: log_bench ours FILE COUNT [DBC] | bare FILE COUNT | candump FILE COUNT".into()),
    }
}

/// A frame every 100 us, with content that changes a little and some that does not.
fn frame(nth: u32) -> (Instant, Frame) {
    let noise = nth.wrapping_mul(2_654_435_761) >> 20;
    let [a, b, c, d] = nth.to_be_bytes();
    let [.., e, f] = noise.to_be_bytes();
    let id = CanId::Standard(IDS[nth as usize % IDS.len()]);
    let at = Instant::from_nanos(1_700_000_000_000_000_000 + i64::from(nth) * 100_000);
    (at, Frame::classic(id, &[a, b, c, d, 0, 0, e, f]))
}

fn told(count: u32, began: Instant) {
    println!("{}", f64::from(count) / (Clock::new().now() - began).as_secs_f64());
}

fn ours(file: &str, count: u32, dbc: Option<&str>) -> Result<(), Box<dyn Error>> {
    let read = |path| Dbc::read_source(Path::new(path)).map(|source| Dbc::parse_leniently(&source).0);
    let dbc = dbc.map(read).transpose().map_err(|problem| problem.to_string())?;
    let began = Clock::new().now();
    let mut log = FrameLog::create(Path::new(file), &BTreeMap::new())?;
    let bus = log.add_bus(&LoggedBus { name: "can0", dbcs: dbc.iter().collect() })?;
    for nth in 0..count {
        let (at, frame) = frame(nth);
        let logged = LoggedFrame { frame: &frame, sent_by_stack: false, error_passive: false, dlc_above_8: None };
        log.put(bus, at, &logged)?;
    }
    log.finish(0)?;
    told(count, began);
    Ok(())
}

fn bare(file: &str, count: u32) -> Result<(), Box<dyn Error>> {
    // The bytes that our messages have: what is measured is the writer alone.
    let sample = std::env::temp_dir().join(format!("log-bench-{}.mcap", std::process::id()));
    let mut log = FrameLog::create(&sample, &BTreeMap::new())?;
    let bus = log.add_bus(&LoggedBus { name: "can0", dbcs: Vec::new() })?;
    let (at, first) = frame(0);
    let logged = LoggedFrame { frame: &first, sent_by_stack: false, error_passive: false, dlc_above_8: None };
    log.put(bus, at, &logged)?;
    log.finish(0)?;
    let bytes = std::fs::read(&sample)?;
    std::fs::remove_file(&sample)?;
    let message = mcap::MessageStream::new(&bytes)?.next().ok_or("the sample has no message")??;
    let (mut data, payload_at) = (message.data.to_vec(), message.data.len() - first.len());

    let began = Clock::new().now();
    let options = mcap::WriteOptions::new().compression_threads(0).chunk_size(Some(512 * 1024));
    let mut writer = options.create(BufWriter::new(File::create(file)?))?;
    let schema = message.channel.schema.as_ref().ok_or("the sample has no schema")?;
    let schema = writer.add_schema(&schema.name, &schema.encoding, &schema.data)?;
    let channel_id = writer.add_channel(schema, &message.channel.topic, "cdr", &BTreeMap::new())?;
    for nth in 0..count {
        let (at, frame) = frame(nth);
        data[payload_at..].copy_from_slice(frame.payload());
        let log_time = at.as_nanos().cast_unsigned();
        let header = MessageHeader { channel_id, sequence: nth, log_time, publish_time: log_time };
        writer.write_to_known_channel(&header, &data)?;
    }
    writer.finish()?;
    told(count, began);
    Ok(())
}

fn candump(file: &str, count: u32) -> Result<(), Box<dyn Error>> {
    let mut out = BufWriter::new(File::create(file)?);
    for nth in 0..count {
        let (at, frame) = frame(nth);
        let (seconds, micros) = (at.as_nanos() / 1_000_000_000, at.as_nanos() / 1000 % 1_000_000);
        write!(out, "({seconds}.{micros:06}) can0 {:03X}#", frame.id.raw())?;
        frame.payload().iter().try_for_each(|byte| write!(out, "{byte:02X}"))?;
        writeln!(out)?;
    }
    Ok(out.flush()?)
}
