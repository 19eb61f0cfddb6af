//! What a bus can do by itself, for `scripts/bench` to compare with.
//!
//! ```text
//! bus_bench answer BUS                    two frames for each frame of id 128, for ever
//! bus_bench ask BUS PERIOD_US COUNT       sends id 128 once a period; prints the round trips' p50, p99 and max, us
//! bus_bench flood PORT COUNT              COUNT frames through a TCP bus; prints frames a second
//! ```

use std::error::Error;

use canloop::bus::socketcand::{Hub, Socketcand};
use canloop::bus::{Arrival, Bus, BusError, OpenOptions, open};
use canloop::frame::{CanId, Frame};
use canloop::run::{self, Clock};
use canloop::time::{Duration, Instant};

const ASKING: CanId = CanId::Standard(128);
const ANSWERS: [CanId; 2] = [CanId::Standard(385), CanId::Standard(386)];
/// A bus on which nothing comes for so long is out of order.
const PATIENCE: Duration = Duration::from_millis(2000);

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match args.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["answer", bus] => answer(bus),
        ["ask", bus, period_us, count] => ask(bus, Duration::from_micros(period_us.parse()?), count.parse()?),
        ["flood", port, count] => flood(port.parse()?, count.parse()?),
        _ => Err("usage: bus_bench answer BUS | ask BUS PERIOD_US COUNT | flood PORT COUNT".into()),
    }
}

fn answer(address: &str) -> Result<(), Box<dyn Error>> {
    let clock = Clock::new();
    let mut bus = open(address, &OpenOptions::default(), clock).map_err(|problem| problem.to_string())?;
    println!("answering on {address}");
    let _ = run::raise();
    loop {
        let Some((_, Arrival::Frame(frame))) = bus.receive(clock.now() + PATIENCE)? else { continue };
        if frame.id == ASKING {
            for id in ANSWERS {
                bus.send(&Frame::zeroed(id, 8))?;
            }
        }
    }
}

fn ask(address: &str, period: Duration, count: usize) -> Result<(), Box<dyn Error>> {
    let clock = Clock::new();
    let mut bus = open(address, &OpenOptions::default(), clock).map_err(|problem| problem.to_string())?;
    let _ = run::raise();
    let mut trips_us = Vec::with_capacity(count);
    let mut due = clock.now() + period;
    for _ in 0..count {
        // Waits as the control loop does: for a frame, or for the period to begin.
        while bus.receive(due)?.is_some() {}
        let sent = clock.now();
        bus.send(&Frame::zeroed(ASKING, 1))?;
        let last = last_answer(bus.as_mut(), sent + PATIENCE)?;
        trips_us.push((last - sent).as_nanos() as f64 / 1e3);
        due += period;
    }
    trips_us.sort_by(f64::total_cmp);
    let at = |share: f64| trips_us[((trips_us.len() - 1) as f64 * share) as usize];
    println!("{:.1} {:.1} {:.1}", at(0.5), at(0.99), at(1.0));
    Ok(())
}

fn last_answer(bus: &mut dyn Bus, deadline: Instant) -> Result<Instant, Box<dyn Error>> {
    let mut answers = 0;
    loop {
        match bus.receive(deadline)? {
            Some((at, Arrival::Frame(frame))) if ANSWERS.contains(&frame.id) => {
                answers += 1;
                if answers == ANSWERS.len() {
                    return Ok(at);
                }
            }
            Some(_) => {}
            None => return Err("no answer".into()),
        }
    }
}

fn flood(port: u16, count: u64) -> Result<(), Box<dyn Error>> {
    let clock = Clock::new();
    let text = |problem: canloop::config::Problem| problem.to_string();
    let mut hub = Hub::listen(([127, 0, 0, 1], port).into(), "can0", clock, false).map_err(text)?;
    let serving =
        std::thread::spawn(move || while hub.receive(clock.now() + PATIENCE).is_ok_and(|got| got.is_some()) {});
    let mut from = Socketcand::connect("127.0.0.1", port, "can0", clock).map_err(text)?;
    let mut to = Socketcand::connect("127.0.0.1", port, "can0", clock).map_err(text)?;
    let start = clock.now();
    let sending = std::thread::spawn(move || -> Result<(), BusError> {
        let mut sent = 0;
        while sent < count {
            match from.send(&Frame::zeroed(CanId::Standard((sent % 0x800) as u16), 8)) {
                Ok(()) => sent += 1,
                // Room comes with time alone.
                Err(BusError::Full) => drop(from.receive(clock.now() + Duration::from_micros(50))?),
                Err(error) => return Err(error),
            }
        }
        // Until all is out; the hub waits no longer than this, and may be gone first.
        while from.receive(clock.now() + PATIENCE).is_ok_and(|got| got.is_some()) {}
        Ok(())
    });
    let mut received = 0;
    while received < count {
        match to.receive(clock.now() + PATIENCE)? {
            Some((_, Arrival::Frame(_))) => received += 1,
            Some(_) => {}
            None => return Err(format!("{received} of {count} frames came").into()),
        }
    }
    let span_s = (clock.now() - start).as_secs_f64();
    println!("{:.0}", count as f64 / span_s);
    sending.join().expect("it does not panic")?;
    drop(to);
    serving.join().expect("it does not panic");
    Ok(())
}
