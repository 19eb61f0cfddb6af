//! A hub on loopback, run by a thread that records what its owner receives.

// Each test file uses a part of it.
#![allow(dead_code)]

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::JoinHandle;

use canloop::bus::socketcand::{Hub, HubCounts, Socketcand};
use canloop::bus::{Arrival, Bus};
use canloop::frame::{CanId, Frame, FrameKind};
use canloop::run::Clock;
use canloop::time::Duration;

/// Longer than anything here takes, unless it never comes.
pub const PATIENCE: Duration = Duration::from_millis(20_000);
/// Long enough for what must not come to come.
pub const QUIET: Duration = Duration::from_millis(300);

pub struct RunningHub {
    pub address: SocketAddr,
    name: &'static str,
    passed_on: Arc<AtomicUsize>,
    stop: Arc<AtomicBool>,
    thread: JoinHandle<(HubCounts, Vec<Frame>)>,
}

impl RunningHub {
    pub fn start() -> Self {
        Self::named("can0")
    }

    pub fn named(name: &'static str) -> Self {
        let mut hub = hub_named(name);
        let (address, stop) = (hub.address(), Arc::new(AtomicBool::new(false)));
        let stopped = Arc::clone(&stop);
        let passed_on = Arc::new(AtomicUsize::new(0));
        let count = Arc::clone(&passed_on);
        let thread = std::thread::spawn(move || {
            let (clock, mut heard) = (Clock::new(), Vec::new());
            loop {
                // Looked at before the hub is: clients may hear a frame before its owner does,
                // and what came before the end counts.
                let is_last = stopped.load(Ordering::Acquire);
                match hub.receive(clock.now() + Duration::from_millis(10)).expect("the hub serves") {
                    Some((_, Arrival::Frame(frame))) => {
                        heard.push(frame);
                        count.fetch_add(1, Ordering::Release);
                    }
                    Some((_, other)) => panic!("the hub brought {other:?}"),
                    None if is_last => break,
                    None => {}
                }
            }
            (hub.counts(), heard)
        });
        Self { address, name, passed_on, stop, thread }
    }

    /// Frames that it has passed on.
    pub fn passed_on(&self) -> usize {
        self.passed_on.load(Ordering::Acquire)
    }

    pub fn join(&self) -> Socketcand {
        join_named(self.address, self.name)
    }

    /// Ends the hub; its counts and what its owner heard.
    pub fn stop(self) -> (HubCounts, Vec<Frame>) {
        self.stop.store(true, Ordering::Release);
        self.thread.join().expect("the hub did not panic")
    }
}

pub fn hub() -> Hub {
    hub_named("can0")
}

fn hub_named(name: &str) -> Hub {
    let address = "127.0.0.1:0".parse().expect("an address");
    Hub::listen(address, name, Clock::new(), false).expect("any free port can be listened at")
}

pub fn join(address: SocketAddr) -> Socketcand {
    join_named(address, "can0")
}

fn join_named(address: SocketAddr, name: &str) -> Socketcand {
    let host = address.ip().to_string();
    Socketcand::connect(&host, address.port(), name, Clock::new()).unwrap_or_else(|problem| panic!("{problem}"))
}

/// The next frame, which must come.
pub fn next_frame(bus: &mut impl Bus) -> Frame {
    match bus.receive(Clock::new().now() + PATIENCE).expect("the bus works") {
        Some((_, Arrival::Frame(frame))) => frame,
        other => panic!("{other:?} instead of a frame"),
    }
}

/// Whether the bus stays silent for a while.
pub fn is_quiet(bus: &mut impl Bus) -> bool {
    bus.receive(Clock::new().now() + QUIET).expect("the bus works").is_none()
}

/// A classic frame that carries `number`.
pub fn numbered(id: u16, number: u32) -> Frame {
    Frame::classic(CanId::Standard(id), &number.to_be_bytes())
}

pub fn frame(id: CanId, kind: FrameKind, payload: &[u8]) -> Frame {
    let mut frame = Frame::zeroed(id, payload.len());
    frame.kind = kind;
    frame.payload_mut().copy_from_slice(payload);
    frame
}

/// Every length of data frame with ids from both ends of both ranges.
pub fn classic_frames() -> Vec<Frame> {
    let ids = [CanId::Standard(0), CanId::Standard(0x7FF), CanId::Extended(1), CanId::Extended(0x1FFF_FFFF)];
    let payload = [0x00, 0x01, 0x0F, 0x10, 0x7F, 0x80, 0xF1, 0xFF];
    ids.iter().flat_map(|&id| (0..=8).map(move |len| Frame::classic(id, &payload[..len]))).collect()
}
