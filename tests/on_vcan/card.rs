//! A card with bit timing, error states and a short queue: the kernel's
//! driver for serial adapters, with a script for the adapter.

use std::io::{BufRead as _, BufReader, Write as _};
use std::process::{Child, ChildStdout, Command, Stdio};

use canloop::bus::{Arrival, Bus as _, BusError, CanLink, ControllerState, OpenOptions, SocketCan};
use canloop::run::Clock;
use canloop::time::Duration;
use rustix::process::{Pid, Signal, kill_process};

use crate::rig::{PYTHON, drain, ip, next, numbered, open, open_with};

struct Card {
    adapter: Child,
    said: BufReader<ChildStdout>,
    name: String,
}

impl Card {
    fn new() -> Self {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/on_vcan/serial_adapter.py");
        let mut adapter = Command::new(std::env::var(PYTHON).as_deref().unwrap_or("python3"))
            .arg(script)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("python3 cannot be run");
        let mut said = BufReader::new(adapter.stdout.take().unwrap());
        let mut name = String::new();
        said.read_line(&mut name).unwrap();
        Self { adapter, said, name: name.trim().to_owned() }
    }

    fn up(self, bit_rate: u32) -> Self {
        ip(&format!("link set {} up type can bitrate {bit_rate}", self.name));
        self
    }

    /// From now on it takes no word of the driver any more.
    fn stop_listening(&self) {
        kill_process(Pid::from_child(&self.adapter), Signal::STOP).unwrap();
    }

    /// The adapter's words, each with its closing carriage return.
    fn say(&mut self, words: &str) {
        self.adapter.stdin.as_mut().unwrap().write_all(words.as_bytes()).unwrap();
    }

    /// What the driver says, up to its next carriage return.
    fn hear(&mut self) -> String {
        let mut heard = Vec::new();
        self.said.read_until(b'\r', &mut heard).unwrap();
        String::from_utf8(heard).unwrap()
    }
}

impl Drop for Card {
    fn drop(&mut self) {
        self.adapter.kill().unwrap();
        self.adapter.wait().unwrap();
    }
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn frames_pass_through_a_card() {
    let mut card = Card::new().up(500_000);
    let mut bus = open(&card.name);
    assert_eq!([card.hear(), card.hear(), card.hear()], ["C\r", "S6\r", "O\r"]);
    bus.send(&numbered(0x181, 0x0403_0201)).unwrap();
    assert_eq!(card.hear(), "t181401020304\r");
    card.say("t182411223344\r");
    assert_eq!(next(&mut bus).1, Arrival::Frame(numbered(0x182, 0x4433_2211)));
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn another_bit_rate_is_refused_with_both_values() {
    let card = Card::new().up(250_000);
    let open = |bit_rate_bit_s| {
        let options = OpenOptions { bit_rate_bit_s, ..Default::default() };
        SocketCan::open(&card.name, &options, Clock::new()).err().map(|problem| problem.to_string())
    };
    assert_eq!(open(None), None);
    assert_eq!(open(Some(250_000)), None);
    let message = open(Some(500_000)).unwrap();
    assert!(message.contains("250000") && message.contains("500000") && message.contains("ip link set"), "{message}");
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn a_card_that_is_down_is_refused_with_the_command_that_brings_it_up() {
    let card = Card::new();
    let options = OpenOptions { bit_rate_bit_s: Some(125_000), ..Default::default() };
    let message = SocketCan::open(&card.name, &options, Clock::new()).err().unwrap().to_string();
    let command = format!("link set {} up type can bitrate 125000", card.name);
    assert!(message.contains(&command), "{message}");
    ip(&command);
    open_with(&card.name, &options);
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn a_card_that_comes_back_with_another_bit_rate_stays_down() {
    let card = Card::new().up(500_000);
    let mut bus = open_with(&card.name, &OpenOptions { bit_rate_bit_s: Some(500_000), ..Default::default() });
    ip(&format!("link set {} down", card.name));
    ip(&format!("link set {} up type can bitrate 250000", card.name));
    assert_eq!(next(&mut bus).1, Arrival::Down);
    assert_eq!(bus.receive(Clock::new().now() + Duration::from_millis(200)).unwrap(), None);
    ip(&format!("link set {} down", card.name));
    ip(&format!("link set {} up type can bitrate 500000", card.name));
    assert_eq!(next(&mut bus).1, Arrival::Up);
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn a_full_transmit_queue_is_told_and_loses_nothing() {
    let card = Card::new().up(500_000);
    card.stop_listening();
    let link = CanLink::read(&card.name).unwrap();
    assert_eq!((link.queue_frames, link.bit_rate_bit_s, link.is_controller), (10, Some(500_000), true));
    let mut bus = open(&card.name);
    let full = (0..1000).find_map(|number| bus.send(&numbered(1, number)).err().map(|error| (number, error)));
    let (taken, error) = full.expect("the queue has no end");
    assert!(matches!(error, BusError::Full), "{error}");
    assert!((10..20).contains(&taken), "{taken} frames taken");
    assert!(matches!(bus.send(&numbered(1, 0)), Err(BusError::Full)), "still full");
    assert_eq!((bus.counts().sent, bus.counts().full), (taken.into(), 2));
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn bus_off_is_told_and_lasts_until_the_card_is_started_again() {
    let mut card = Card::new().up(500_000);
    let mut bus = open(&card.name);
    card.say("sp000130\r");
    assert_eq!(next(&mut bus).1, Arrival::State(ControllerState::ErrorPassive));
    card.say("sb000255\r");
    assert_eq!(next(&mut bus).1, Arrival::State(ControllerState::BusOff));
    assert_eq!(next(&mut bus).1, Arrival::Down);
    assert!(matches!(bus.send(&numbered(1, 1)), Err(BusError::Down)));
    assert_eq!(CanLink::read(&card.name).unwrap().state, Some(ControllerState::BusOff));
    assert_eq!(bus.receive(Clock::new().now() + Duration::from_millis(200)).unwrap(), None, "it is off for good");

    // Whoever opens it now learns of it first.
    let mut second = open(&card.name);
    assert_eq!(drain(&mut second), [Arrival::State(ControllerState::BusOff), Arrival::Down]);

    ip(&format!("link set {} down", card.name));
    ip(&format!("link set {} up", card.name));
    assert_eq!(next(&mut bus).1, Arrival::State(ControllerState::ErrorActive));
    assert_eq!(next(&mut bus).1, Arrival::Up);
    bus.send(&numbered(1, 1)).unwrap();
}
