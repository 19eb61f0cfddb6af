//! A CAN interface of the kernel, and how it is set up.

use socketcan::{CanFdSocket, Socket as _};

use super::{Check, Machine};
use crate::bus::{CanLink, ControllerState, LinkError, USUAL_BIT_RATE_BIT_S};

const INTERFACE: &str = "interface";
const BIT_RATE: &str = "bit rate";
const CONTROLLER: &str = "controller";
const RESTART: &str = "restart-ms";
const QUEUE: &str = "txqueuelen";
const TIME_STAMPS: &str = "time stamps";
const ERROR_COUNTS: &str = "error counts";

/// The kernel's default of 10 holds two periods of a robot with two drives.
const SHORTEST_QUEUE_FRAMES: u32 = 32;
const GOOD_QUEUE_FRAMES: u32 = 128;
/// Frames that went wrong (`Documentation/networking/statistics.rst`).
const COUNTERS: [&str; 5] = ["rx_errors", "tx_errors", "rx_dropped", "tx_dropped", "rx_over_errors"];

/// Asks for the interface called `name` and looks at it.
pub(super) fn checks(machine: &Machine, name: &str) -> Vec<Check> {
    let link = match CanLink::read(name) {
        Ok(link) => link,
        Err(error) => return vec![without(name, &error, &CanLink::all().unwrap_or_default())],
    };
    let stamped_by_card = CanFdSocket::open_iface(link.index).is_ok_and(|socket| socket.has_hw_timestamps());
    let counter = |counter| machine.text(&format!("sys/class/net/{name}/statistics/{counter}"))?.parse().ok();
    let counts: Option<Vec<u64>> = COUNTERS.into_iter().map(counter).collect();
    let mut checks = settings(name, &link);
    checks.push(time_stamps(&link, stamped_by_card));
    checks.push(match counts {
        Some(counts) => error_counts(name, &counts),
        None => Check::untold(ERROR_COUNTS, &format!("sys/class/net/{name}/statistics")),
    });
    checks
}

/// There is no such CAN interface; `others` are there.
fn without(name: &str, error: &LinkError, others: &[(String, CanLink)]) -> Check {
    let names: Vec<_> = others.iter().map(|(name, _)| name.as_str()).collect();
    let there_are = match names.is_empty() {
        true => "no CAN interface at all".to_owned(),
        false => names.join(", "),
    };
    let found = match error {
        LinkError::Unknown => format!("there is no {name}; there is {there_are}"),
        LinkError::NotCan => format!("{name} is no CAN interface; there is {there_are}"),
        LinkError::System(error) => format!("cannot ask for {name}: {error}"),
    };
    let mend = match error {
        LinkError::Unknown if name.starts_with("vcan") => {
            format!("ip link add dev {name} type vcan && ip link set {name} up")
        }
        _ => "dmesg | grep -i can # tells whether the card's driver was loaded; then: ip -details link show".into(),
    };
    Check::missing(INTERFACE, found, mend)
}

/// What is set up with `ip link`. Of that a virtual interface has nothing.
fn settings(name: &str, link: &CanLink) -> Vec<Check> {
    let mut checks = vec![interface(name, link)];
    if link.is_controller {
        checks.push(bit_rate(name, link));
        // One that is switched off is in no state.
        checks.extend(link.is_up.then(|| controller(name, link)));
        checks.extend([restart(name, link), queue(name, link)]);
    }
    checks
}

fn interface(name: &str, link: &CanLink) -> Check {
    let frames = if link.carries_fd { "classic and CAN FD frames" } else { "classic frames only" };
    let kind = if link.is_controller { "" } else { ", virtual: no bit rate, no controller" };
    match link.is_up {
        true => Check::ok(INTERFACE, format!("{name} is up, {frames}{kind}")),
        false => Check::missing(INTERFACE, format!("{name} is down"), switch_on(name, link)),
    }
}

/// The command that brings the interface up.
fn switch_on(name: &str, link: &CanLink) -> String {
    match link.is_controller {
        true => {
            let bit_rate = link.bit_rate_bit_s.unwrap_or(USUAL_BIT_RATE_BIT_S);
            format!("ip link set {name} up type can bitrate {bit_rate}")
        }
        false => format!("ip link set {name} up"),
    }
}

fn bit_rate(name: &str, link: &CanLink) -> Check {
    match (link.bit_rate_bit_s, link.data_bit_rate_bit_s) {
        (Some(nominal), Some(data)) => Check::ok(BIT_RATE, format!("{nominal} bit/s, data {data} bit/s")),
        (Some(nominal), None) => Check::ok(BIT_RATE, format!("{nominal} bit/s")),
        (None, _) => {
            // Works too when the command above it has just been run.
            let up = switch_on(name, link);
            let mend = format!("ip link set {name} down && {up} # the bit rate of the other nodes");
            Check::missing(BIT_RATE, "never set", mend)
        }
    }
}

fn controller(name: &str, link: &CanLink) -> Check {
    let look = format!(
        "ip -details -statistics link show {name} # do others answer? look at bit rate, plug, and 120 ohm at both ends"
    );
    match link.state {
        None => Check::degraded(CONTROLLER, "stopped or asleep", switch_on(name, link)),
        Some(ControllerState::ErrorActive) => Check::ok(CONTROLLER, "error-active"),
        Some(ControllerState::ErrorWarning) => Check::degraded(CONTROLLER, "error-warning: errors on the bus", look),
        Some(ControllerState::ErrorPassive) => {
            Check::degraded(CONTROLLER, "error-passive: most likely nobody acknowledges", look)
        }
        Some(ControllerState::BusOff) => {
            let mend = format!("ip link set {name} down && ip link set {name} up");
            Check::missing(CONTROLLER, "bus-off: cut off after too many errors", mend)
        }
    }
}

fn restart(name: &str, link: &CanLink) -> Check {
    match link.restart_ms {
        None | Some(0) => {
            let mend = format!(
                "ip link set {name} down && ip link set {name} type can restart-ms 100 && ip link set {name} up"
            );
            Check::degraded(RESTART, "0: after bus-off it stays off", mend)
        }
        Some(restart_ms) => Check::ok(RESTART, format!("{restart_ms} ms after bus-off it starts again")),
    }
}

fn queue(name: &str, link: &CanLink) -> Check {
    let found = format!("{} frames", link.queue_frames);
    match link.queue_frames >= SHORTEST_QUEUE_FRAMES {
        true => Check::ok(QUEUE, found),
        false => {
            let mend = format!("ip link set {name} txqueuelen {GOOD_QUEUE_FRAMES}");
            Check::degraded(QUEUE, format!("{found}: soon full when the bus is busy"), mend)
        }
    }
}

/// Sockets get the kernel's stamps from every interface.
fn time_stamps(link: &CanLink, by_card: bool) -> Check {
    let found = match (by_card, link.is_controller) {
        (true, _) => "by the card and by the kernel",
        (false, true) => "by the kernel; the card has none",
        (false, false) => "by the kernel",
    };
    Check::ok(TIME_STAMPS, found)
}

/// `counts` are those of [`COUNTERS`].
fn error_counts(name: &str, counts: &[u64]) -> Check {
    let counted: Vec<_> =
        COUNTERS.iter().zip(counts).filter(|(_, n)| **n > 0).map(|(counter, n)| format!("{counter} {n}")).collect();
    match counted.is_empty() {
        true => Check::ok(ERROR_COUNTS, "none since the interface was made"),
        false => {
            let mend = format!("ip -details -statistics link show {name} # again and again: do they grow?");
            Check::degraded(ERROR_COUNTS, counted.join(", "), mend)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Outcome;
    use super::*;

    const CARD: CanLink = CanLink {
        index: 3,
        is_up: true,
        is_controller: true,
        carries_fd: true,
        queue_frames: 128,
        bit_rate_bit_s: Some(500_000),
        data_bit_rate_bit_s: Some(2_000_000),
        state: Some(ControllerState::ErrorActive),
        restart_ms: Some(100),
    };
    const VIRTUAL: CanLink = CanLink {
        is_controller: false,
        queue_frames: 0,
        bit_rate_bit_s: None,
        data_bit_rate_bit_s: None,
        state: None,
        restart_ms: None,
        ..CARD
    };

    /// The one thing that is not as it should be.
    fn fault(link: &CanLink) -> (&'static str, Outcome, String) {
        let mut faults: Vec<_> =
            settings("can0", link).into_iter().filter(|check| check.outcome != Outcome::Ok).collect();
        assert_eq!(faults.len(), 1, "{faults:?}");
        let fault = faults.remove(0);
        (fault.name, fault.outcome, fault.mend.expect("a command"))
    }

    #[test]
    fn a_card_and_a_virtual_interface_can_be_all_right() {
        for link in [CARD, VIRTUAL] {
            let checks = settings("can0", &link);
            assert!(checks.iter().all(|check| check.outcome == Outcome::Ok), "{checks:?}");
        }
        assert_eq!(settings("vcan0", &VIRTUAL).len(), 1);
        assert_eq!(bit_rate("can0", &CARD).found, "500000 bit/s, data 2000000 bit/s");
    }

    #[test]
    fn an_interface_that_is_down_is_missing() {
        let down = CanLink { is_up: false, state: None, ..CARD };
        let up = "ip link set can0 up type can bitrate 500000".to_owned();
        assert_eq!(fault(&down), (INTERFACE, Outcome::Missing, up));
        let down = CanLink { is_up: false, ..VIRTUAL };
        assert_eq!(fault(&down), (INTERFACE, Outcome::Missing, "ip link set can0 up".to_owned()));
    }

    #[test]
    fn a_bit_rate_that_was_never_set_is_missing() {
        let (name, outcome, mend) = fault(&CanLink { bit_rate_bit_s: None, ..CARD });
        assert_eq!((name, outcome), (BIT_RATE, Outcome::Missing));
        assert!(mend.starts_with("ip link set can0 down && ip link set can0 up type can bitrate 500000"), "{mend}");
    }

    #[test]
    fn a_controller_off_the_bus_is_missing_and_one_in_trouble_degraded() {
        let state = |state| fault(&CanLink { state: Some(state), ..CARD });
        let again = "ip link set can0 down && ip link set can0 up".to_owned();
        assert_eq!(state(ControllerState::BusOff), (CONTROLLER, Outcome::Missing, again));
        for trouble in [ControllerState::ErrorWarning, ControllerState::ErrorPassive] {
            assert_eq!(state(trouble).1, Outcome::Degraded);
        }
    }

    #[test]
    fn a_controller_that_stays_off_and_a_short_queue_are_degraded() {
        let (name, outcome, mend) = fault(&CanLink { restart_ms: Some(0), ..CARD });
        assert_eq!((name, outcome), (RESTART, Outcome::Degraded));
        assert!(mend.contains("can0 down") && mend.contains("restart-ms 100"), "{mend}");
        let longer = "ip link set can0 txqueuelen 128".to_owned();
        assert_eq!(fault(&CanLink { queue_frames: 10, ..CARD }), (QUEUE, Outcome::Degraded, longer));
    }

    #[test]
    fn an_interface_that_is_not_there_is_missing_with_those_that_are() {
        let others = [("can1".to_owned(), CARD), ("vcan0".to_owned(), VIRTUAL)];
        let check = without("can0", &LinkError::Unknown, &others);
        assert_eq!(check.outcome, Outcome::Missing);
        assert!(check.found.contains("no can0; there is can1, vcan0"), "{}", check.found);
        let check = without("vcan7", &LinkError::Unknown, &[]);
        assert_eq!(check.mend.as_deref(), Some("ip link add dev vcan7 type vcan && ip link set vcan7 up"));
        assert!(without("eth0", &LinkError::NotCan, &others).found.contains("eth0 is no CAN interface"));
    }

    #[test]
    fn what_was_lost_or_went_wrong_is_counted() {
        assert_eq!(error_counts("can0", &[0; 5]).outcome, Outcome::Ok);
        let check = error_counts("can0", &[3, 0, 0, 17, 0]);
        assert_eq!((check.outcome, check.found.as_str()), (Outcome::Degraded, "rx_errors 3, tx_dropped 17"));
    }

    #[test]
    fn stamps_of_the_card_are_told_from_the_kernel_s() {
        assert!(time_stamps(&CARD, true).found.contains("by the card"));
        assert!(!time_stamps(&CARD, false).found.contains("by the card"));
    }
}
