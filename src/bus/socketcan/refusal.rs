//! Why an interface is not taken, and what to do about it.

use std::io;

use socketcan::{CanFdSocket, Socket as _};

use crate::bus::{CanLink, LinkError, USUAL_BIT_RATE_BIT_S};
use crate::config::Problem;

/// What an interface must be like.
#[derive(Clone, Copy, Debug)]
pub(super) struct Requirements {
    /// Nominal bit rate; held against controllers only.
    pub bit_rate_bit_s: Option<u32>,
    /// Whether it must carry CAN FD frames.
    pub needs_fd: bool,
}

/// What is wrong with an interface that exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// It is switched off.
    Down,
    /// Found and wanted, in bit/s.
    BitRate(u32, u32),
    /// It carries classic frames only.
    ClassicOnly,
}

/// Fails where the kernel itself has no raw CAN sockets. Without that, asking
/// for an interface says no more than that there is none.
pub(super) fn check_kernel() -> Result<(), Problem> {
    const ANY_INTERFACE: u32 = 0;
    match CanFdSocket::open_iface(ANY_INTERFACE) {
        Ok(_) => Ok(()),
        Err(error) => Err(without_socket(&error)),
    }
}

/// Asks for the interface and holds it against what it must be like.
pub(super) fn find(name: &str, requirements: Requirements) -> Result<CanLink, Problem> {
    let link = CanLink::read(name).map_err(|error| without_link(name, &error))?;
    match requirements.refusal(&link) {
        Some(refusal) => Err(refusal.problem(name, &link, requirements)),
        None => Ok(link),
    }
}

/// The system refused a socket.
pub(super) fn without_socket(error: &io::Error) -> Problem {
    use rustix::io::Errno;
    match Errno::from_io_error(error) {
        Some(Errno::AFNOSUPPORT | Errno::PROTONOSUPPORT) => Problem::bare("this kernel has no CAN sockets").help(
            "load the module can-raw (modprobe can-raw) or use a kernel that has it; \
             scripts/with-vcan COMMAND runs a command where there is one",
        ),
        Some(Errno::ACCESS | Errno::PERM) => Problem::bare(format!("no permission to open a CAN socket: {error}"))
            .help("no privilege is needed as a rule: look for a sandbox or container that forbids AF_CAN sockets"),
        _ => Problem::bare(format!("cannot open a CAN socket: {error}")),
    }
}

impl Requirements {
    /// What keeps the interface from being used. Allocates nothing, so that
    /// the loop may ask too.
    pub fn refusal(&self, link: &CanLink) -> Option<Refusal> {
        if !link.is_up {
            return Some(Refusal::Down);
        }
        match (link.bit_rate_bit_s, self.bit_rate_bit_s) {
            (Some(found), Some(wanted)) if found != wanted => return Some(Refusal::BitRate(found, wanted)),
            _ => {}
        }
        (self.needs_fd && !link.carries_fd).then_some(Refusal::ClassicOnly)
    }
}

impl Refusal {
    fn problem(self, name: &str, link: &CanLink, requirements: Requirements) -> Problem {
        match self {
            Self::Down => {
                Problem::bare(format!("{name} is down")).help(format!("bring it up: {}", switch_on(name, link, requirements)))
            }
            Self::BitRate(found, wanted) => {
                Problem::bare(format!("{name} runs at {found} bit/s, but the configuration says {wanted} bit/s")).help(
                    format!("change one of them; the interface with: ip link set {name} down && ip link set {name} up type can bitrate {wanted}"),
                )
            }
            Self::ClassicOnly => {
                let change = match link.is_controller {
                    true => "up type can dbitrate 2000000 fd on",
                    false => "mtu 72 up",
                };
                Problem::bare(format!("{name} carries classic frames only, but CAN FD is needed"))
                    .help(format!("if it can: ip link set {name} down && ip link set {name} {change}"))
            }
        }
    }
}

/// The command that brings the interface up.
fn switch_on(name: &str, link: &CanLink, requirements: Requirements) -> String {
    let bit_rate = requirements.bit_rate_bit_s.or(link.bit_rate_bit_s).unwrap_or(USUAL_BIT_RATE_BIT_S);
    match link.is_controller {
        true => format!("ip link set {name} up type can bitrate {bit_rate}"),
        false => format!("ip link set {name} up"),
    }
}

fn without_link(name: &str, error: &LinkError) -> Problem {
    match error {
        LinkError::Unknown => Problem::bare(format!("there is no interface {name}")).help(what_there_is()),
        LinkError::NotCan => Problem::bare(format!("{name} is no CAN interface")).help(what_there_is()),
        LinkError::System(error) => Problem::bare(format!("cannot ask for the interface {name}: {error}")),
    }
}

fn what_there_is() -> String {
    let links = CanLink::all().unwrap_or_default();
    let names: Vec<_> =
        links.iter().map(|(name, link)| format!("{name}{}", if link.is_up { "" } else { " (down)" })).collect();
    match names.is_empty() {
        true => {
            "there is no CAN interface at all; a virtual one: ip link add dev vcan0 type vcan && ip link set vcan0 up"
                .into()
        }
        false => format!("there are: {}", names.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CARD: CanLink = CanLink {
        index: 3,
        is_up: true,
        is_controller: true,
        carries_fd: false,
        queue_frames: 10,
        bit_rate_bit_s: Some(250_000),
        data_bit_rate_bit_s: None,
        state: None,
        restart_ms: Some(0),
    };

    fn message(link: CanLink, bit_rate_bit_s: Option<u32>, needs_fd: bool) -> Option<String> {
        let requirements = Requirements { bit_rate_bit_s, needs_fd };
        requirements.refusal(&link).map(|refusal| refusal.problem("can0", &link, requirements).to_string())
    }

    #[test]
    fn another_bit_rate_is_refused_with_both_values() {
        assert_eq!(message(CARD, Some(250_000), false), None);
        assert_eq!(message(CARD, None, false), None);
        let message = message(CARD, Some(500_000), false).unwrap();
        assert!(message.contains("250000 bit/s") && message.contains("500000 bit/s"), "{message}");
    }

    #[test]
    fn a_card_that_is_down_is_refused_with_the_command_that_brings_it_up() {
        let down = CanLink { is_up: false, bit_rate_bit_s: None, ..CARD };
        let told = message(down, Some(1_000_000), false).unwrap();
        assert!(told.contains("ip link set can0 up type can bitrate 1000000"), "{told}");
        let told = message(down, None, false).unwrap();
        assert!(told.contains("ip link set can0 up type can bitrate 500000"), "{told}");
    }

    #[test]
    fn a_classic_card_is_refused_where_can_fd_is_needed() {
        assert!(message(CARD, None, true).unwrap().contains("fd on"));
        assert_eq!(message(CanLink { carries_fd: true, ..CARD }, None, true), None);
    }

    #[test]
    fn a_kernel_without_can_is_told_from_a_missing_interface() {
        let told = without_socket(&rustix::io::Errno::AFNOSUPPORT.into()).to_string();
        assert!(told.contains("no CAN sockets") && told.contains("scripts/with-vcan"), "{told}");
    }
}
