//! A bus by its address, as users write it.

use super::Bus;
use super::socketcand::{Endpoint, Hub, Socketcand};
use crate::config::{Problem, Section};
use crate::frame::CanId;
use crate::run::Clock;

/// What a program wants of the bus that it opens.
#[derive(Clone, Copy, Debug, Default)]
pub struct OpenOptions<'a> {
    /// The ids to be received; with none, all.
    pub receive: &'a [CanId],
    /// The nominal bit rate that the bus must have, where it has one.
    pub bit_rate_bit_s: Option<u32>,
    /// Whether the bus must carry CAN FD frames.
    pub needs_fd: bool,
    /// Whether to hear everything: error frames too, and who sent what, where
    /// the bus tells.
    pub listens: bool,
    /// Whether a bus that is hosted here may be reached from other machines.
    pub allow_others: bool,
}

/// Where a bus is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// `can0`: an interface of the Linux kernel.
    Interface(String),
    /// `tcp://HOST:PORT/NAME`: a bus of a socketcand server.
    Server(Endpoint),
    /// `tcp-listen://HOST:PORT/NAME`: a bus that this program serves.
    Listen(Endpoint),
}

impl Address {
    /// Reads an address as users write it; looks for nothing.
    ///
    /// # Errors
    /// Text of another form, with the forms there are.
    pub fn parse(text: &str) -> Result<Self, Problem> {
        match text.split_once("://") {
            Some(("tcp", endpoint)) => Ok(Self::Server(Endpoint::parse(endpoint)?)),
            Some(("tcp-listen", endpoint)) => Ok(Self::Listen(Endpoint::parse(endpoint)?)),
            None if is_interface_name(text) => Ok(Self::Interface(text.to_owned())),
            _ => Err(Problem::bare(format!("{text:?} is no bus")).help(
                "expected a CAN interface such as can0 or vcan0, tcp://HOST:PORT/NAME for a bus of a socketcand \
                 server, or tcp-listen://HOST:PORT/NAME to host one",
            )),
        }
    }
}

/// What the bus at `address` is called, wherever it is.
pub fn bus_name(address: &str) -> &str {
    address.rsplit('/').next().unwrap_or(address)
}

/// Opens the bus at `address`, which [`Address`] has the forms of.
///
/// # Errors
/// An address of another form, or a bus that cannot be had as `options` want
/// it: what was found, and what to do about it.
pub fn open(address: &str, options: &OpenOptions, clock: Clock) -> Result<Box<dyn Bus + Send>, Problem> {
    match Address::parse(address)? {
        Address::Server(Endpoint { host, port, bus_name }) => {
            Ok(Box::new(Socketcand::connect(&host, port, &bus_name, clock)?))
        }
        Address::Listen(endpoint) => {
            let listen_at = endpoint.to_listen_address()?;
            Ok(Box::new(Hub::listen(listen_at, &endpoint.bus_name, clock, options.allow_others)?))
        }
        Address::Interface(name) => open_interface(&name, options, clock),
    }
}

#[cfg(target_os = "linux")]
fn open_interface(name: &str, options: &OpenOptions, clock: Clock) -> Result<Box<dyn Bus + Send>, Problem> {
    Ok(Box::new(super::SocketCan::open(name, options, clock)?))
}

#[cfg(not(target_os = "linux"))]
fn open_interface(name: &str, _: &OpenOptions, _: Clock) -> Result<Box<dyn Bus + Send>, Problem> {
    Err(Problem::bare(format!("{name}: only Linux has CAN interfaces"))
        .help("use tcp://HOST:PORT/NAME with a socketcand server"))
}

/// The nominal bit rate where nothing says another, bit/s.
pub const USUAL_BIT_RATE_BIT_S: u32 = 500_000;

/// Reads `bitrate_bit_s` of a `[bus]` section, the nominal bit rate, or else the
/// usual one.
pub fn read_bit_rate(bus: &Section<'_>) -> u32 {
    bus.integer_or("bitrate_bit_s", i64::from(USUAL_BIT_RATE_BIT_S), 10_000, 1_000_000) as u32
}

/// What the kernel takes for the name of an interface (`dev_valid_name`).
fn is_interface_name(name: &str) -> bool {
    (1..16).contains(&name.len()) && !name.contains(|c: char| c == '/' || c == ':' || c.is_whitespace() || c == '\0')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(address: &str) -> String {
        let refused = open(address, &OpenOptions::default(), Clock::new());
        refused.err().expect("no bus should be there").to_string()
    }

    #[test]
    fn an_address_of_no_known_form_is_refused_with_the_forms_there_are() {
        for address in ["", "udp://239.0.0.1/can0", "can 0", "/dev/ttyUSB0", "a-very-long-interface-name"] {
            let message = refusal(address);
            assert!(
                message.contains("is no bus") && message.contains("can0") && message.contains("tcp://"),
                "{message}"
            );
        }
    }
}
