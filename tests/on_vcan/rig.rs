//! Interfaces of a test's own, and what it does with a bus on them.

use std::process::Command;

use canloop::bus::{Arrival, Bus, OpenOptions, SocketCan};
use canloop::frame::{CanId, Frame};
use canloop::run::Clock;
use canloop::time::{Duration, Instant};

/// The environment variable that names the Python interpreter.
pub const PYTHON: &str = "CANLOOP_TEST_PYTHON";

/// Long enough for anything to arrive on a busy machine.
const PATIENCE: Duration = Duration::from_millis(5_000);

/// A virtual interface that carries CAN FD, up.
pub struct Vcan(pub &'static str);

impl Vcan {
    pub fn new(name: &'static str) -> Self {
        ip(&format!("link add dev {name} mtu 72 up type vcan"));
        Self(name)
    }

    /// Makes an interface of that name, down.
    pub fn add(name: &str) {
        ip(&format!("link add dev {name} mtu 72 type vcan"));
    }

    pub fn open(&self) -> SocketCan {
        open(self.0)
    }
}

/// Runs `ip` with these arguments, which has to succeed.
pub fn ip(arguments: &str) {
    let ran = Command::new("ip").args(arguments.split(' ')).output().expect("ip cannot be run");
    assert!(ran.status.success(), "ip {arguments}: {}", String::from_utf8_lossy(&ran.stderr));
}

pub fn open(interface: &str) -> SocketCan {
    open_with(interface, &OpenOptions::default())
}

pub fn open_with(interface: &str, options: &OpenOptions) -> SocketCan {
    SocketCan::open(interface, options, Clock::new()).unwrap_or_else(|problem| panic!("{problem}"))
}

/// The next arrival, waited for.
pub fn next(bus: &mut SocketCan) -> (Instant, Arrival) {
    bus.receive(Clock::new().now() + PATIENCE).unwrap().expect("nothing arrived")
}

/// All that arrives until it has been quiet for a while: the kernel hands
/// frames over a little after they were sent.
pub fn drain(bus: &mut SocketCan) -> Vec<Arrival> {
    const QUIET: Duration = Duration::from_millis(50);
    std::iter::from_fn(|| bus.receive(Clock::new().now() + QUIET).unwrap()).map(|(_, arrival)| arrival).collect()
}

/// A classic frame with a standard id that carries `number`.
pub fn numbered(id: u16, number: u32) -> Frame {
    Frame::classic(CanId::Standard(id), &number.to_le_bytes())
}
