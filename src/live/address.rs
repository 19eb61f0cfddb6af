//! Where a view may be served: on this machine, for this machine.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};

/// Where the page is served when nothing is said.
pub const PAGE_ADDRESS: &str = "127.0.0.1:8766";
/// Where the Foxglove app looks when nothing is said.
pub const FOXGLOVE_ADDRESS: &str = "127.0.0.1:8765";

/// Reads `ADDR:PORT`, `localhost:PORT` or `PORT`.
///
/// # Errors
/// Any other text, and addresses that other machines reach: what a robot does
/// is nobody else's business until a person says so, and `ssh -L` is the way
/// to say it.
pub fn parse_address(text: &str) -> Result<SocketAddr, String> {
    let port = text.strip_prefix("localhost:").unwrap_or(text);
    let on_loopback = || Some(SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port.parse().ok()?));
    let Some(address) = on_loopback().or_else(|| text.parse().ok()) else {
        return Err(format!(
            "expected ADDR:PORT, such as 127.0.0.1:8080, or a port (a scenario's name goes before this option), found \
             {text:?}"
        ));
    };
    if address.ip().is_loopback() {
        return Ok(address);
    }
    let port = address.port();
    Err(format!(
        "other machines could reach {address}; it is served on loopback only, such as 127.0.0.1:{port}. To look on from \
         another machine, let it come in by ssh: ssh -L {port}:127.0.0.1:{port} THIS-MACHINE"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_on_loopback_is_taken() {
        for (text, address) in [
            ("127.0.0.1:8080", "127.0.0.1:8080"),
            ("127.1.2.3:0", "127.1.2.3:0"),
            ("[::1]:8080", "[::1]:8080"),
            ("localhost:8080", "127.0.0.1:8080"),
            ("8080", "127.0.0.1:8080"),
            (PAGE_ADDRESS, PAGE_ADDRESS),
            (FOXGLOVE_ADDRESS, FOXGLOVE_ADDRESS),
        ] {
            assert_eq!(parse_address(text).map(|found| found.to_string()), Ok(address.to_owned()), "{text}");
        }
    }

    #[test]
    fn an_address_that_others_reach_is_refused_with_another_way_there() {
        for text in ["0.0.0.0:8080", "192.168.1.7:8080", "[::]:8080", "[::ffff:10.0.0.1]:8080"] {
            let refusal = parse_address(text).expect_err(text);
            assert!(refusal.contains("loopback only") && refusal.contains("ssh -L 8080:127.0.0.1:8080"), "{refusal}");
        }
    }

    #[test]
    fn what_is_no_address_is_refused_with_what_was_expected() {
        for text in ["", "dac-friction", "127.0.0.1", "127.0.0.1:65536", "localhost:", "example.org:80", "-1"] {
            let refusal = parse_address(text).expect_err(text);
            assert!(refusal.contains("expected ADDR:PORT") && refusal.contains(&format!("{text:?}")), "{refusal}");
        }
    }
}
