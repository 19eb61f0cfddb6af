//! `HOST:PORT/NAME`: which bus of which server.

use std::fmt;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};

use crate::config::Problem;

/// The port that socketcand listens on when nothing is said.
pub const DEFAULT_PORT: u16 = 29536;
/// The longest name of a bus that the protocol allows.
const LONGEST_NAME: usize = 16;

/// A bus of a server of the protocol.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Endpoint {
    /// A name or an address, an IPv6 one without brackets.
    pub host: String,
    /// The TCP port.
    pub port: u16,
    /// What the server calls the bus.
    pub bus_name: String,
}

impl Endpoint {
    /// Reads `HOST:PORT/NAME` or `HOST/NAME`, with [`DEFAULT_PORT`] then.
    ///
    /// # Errors
    /// Says which part is missing or wrong.
    pub fn parse(text: &str) -> Result<Self, Problem> {
        let wrong = |why: String| {
            Problem::bare(format!("`{text}` is no bus of a socketcand server: {why}"))
                .help("write HOST:PORT/NAME, such as 127.0.0.1:29536/can0")
        };
        let (server, bus_name) = text.split_once('/').ok_or_else(|| wrong("there is no `/NAME` in it".into()))?;
        check_bus_name(bus_name).map_err(|problem| wrong(problem.title))?;
        let (host, port) = match server.rsplit_once(':') {
            Some((host, port)) if !port.ends_with(']') => {
                let number = port.parse().ok().filter(|_| port.bytes().all(|byte| byte.is_ascii_digit()));
                (host, number.ok_or_else(|| wrong(format!("the port is `{port}`, not a number from 0 to 65535")))?)
            }
            _ => (server, DEFAULT_PORT),
        };
        let bare = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
        let host = bare.unwrap_or(host);
        if host.is_empty() || (bare.is_none() && host.contains([':', '[', ']'])) || host.contains(char::is_whitespace) {
            return Err(wrong(format!("the host is `{host}`")));
        }
        Ok(Self { host: host.to_owned(), port, bus_name: bus_name.to_owned() })
    }

    /// The address to listen at; asks no name server.
    ///
    /// # Errors
    /// When the host is neither an address nor `localhost`.
    pub fn to_listen_address(&self) -> Result<SocketAddr, Problem> {
        let ip = if self.host == "localhost" { Some(IpAddr::V4(Ipv4Addr::LOCALHOST)) } else { self.host.parse().ok() };
        ip.map(|ip| SocketAddr::new(ip, self.port)).ok_or_else(|| {
            Problem::bare(format!("cannot listen at `{}`: it is not an address", self.host))
                .help("listen at 127.0.0.1 or at an address of this machine")
        })
    }
}

impl fmt::Display for Endpoint {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { host, port, bus_name } = self;
        if host.contains(':') {
            write!(out, "tcp://[{host}]:{port}/{bus_name}")
        } else {
            write!(out, "tcp://{host}:{port}/{bus_name}")
        }
    }
}

/// Whether the protocol can carry `name` as the name of a bus.
pub(super) fn check_bus_name(name: &str) -> Result<(), Problem> {
    let fits = (1..=LONGEST_NAME).contains(&name.len());
    if fits && name.bytes().all(|byte| byte.is_ascii_graphic() && !b"<>/".contains(&byte)) {
        return Ok(());
    }
    Err(Problem::bare(format!("the bus is called `{name}`, not 1 to {LONGEST_NAME} letters and digits such as can0")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_endpoint_is_read_and_written() {
        let endpoint = Endpoint::parse("127.0.0.1:29536/can0").unwrap();
        assert_eq!((endpoint.host.as_str(), endpoint.port, endpoint.bus_name.as_str()), ("127.0.0.1", 29536, "can0"));
        assert_eq!(endpoint.to_string(), "tcp://127.0.0.1:29536/can0");
        assert_eq!(Endpoint::parse("gateway.local/vcan0").unwrap().port, DEFAULT_PORT);
        assert_eq!(Endpoint::parse("[::1]:7/can0").unwrap().to_string(), "tcp://[::1]:7/can0");
        assert_eq!(Endpoint::parse("[::1]/can0").unwrap().host, "::1");
    }

    #[test]
    fn a_wrong_endpoint_says_which_part_is_wrong() {
        for (text, why) in [
            ("127.0.0.1:29536", "no `/NAME`"),
            ("127.0.0.1:29536/", "called ``"),
            ("127.0.0.1:29536/can 0", "called `can 0`"),
            ("127.0.0.1:29536/a_name_that_is_too_long", "1 to 16"),
            ("127.0.0.1:x/can0", "port is `x`"),
            ("127.0.0.1:+1/can0", "port is `+1`"),
            ("127.0.0.1:65536/can0", "port is `65536`"),
            (":29536/can0", "host is ``"),
            ("::1:29536/can0", "host is `::1`"),
        ] {
            let problem = Endpoint::parse(text).unwrap_err();
            assert!(problem.title.contains(why), "{text}: {}", problem.title);
        }
    }

    #[test]
    fn only_an_address_can_be_listened_at() {
        let at = |text| Endpoint::parse(text).unwrap().to_listen_address();
        assert!(at("localhost:5/can0").unwrap().ip().is_loopback());
        assert_eq!(at("[::]:5/can0").unwrap().to_string(), "[::]:5");
        assert!(at("example.org:5/can0").unwrap_err().title.contains("example.org"));
    }
}
