//! What the kernel knows of a CAN interface: `ip -details link show`, asked
//! over a route netlink socket (rtnetlink(7), `linux/can/netlink.h`).

use std::io;
use std::os::fd::OwnedFd;

use rustix::net::{AddressFamily, RecvFlags, SendFlags, SocketFlags, SocketType, netlink};

use super::ControllerState;

/// A CAN interface at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CanLink {
    /// The kernel's number for it. An interface that was removed and made
    /// again has another one.
    pub index: u32,
    /// Whether it is switched on.
    pub is_up: bool,
    /// Whether a controller with bit timing is behind it; `vcan` has none.
    pub is_controller: bool,
    /// Whether it carries CAN FD frames.
    pub carries_fd: bool,
    /// Frames that its transmit queue holds.
    pub queue_frames: u32,
    /// Nominal bit rate; `None` for a virtual interface or when never set.
    pub bit_rate_bit_s: Option<u32>,
    /// Bit rate of the CAN FD data phase.
    pub data_bit_rate_bit_s: Option<u32>,
    /// The controller's error state; `None` for a virtual interface and while
    /// the interface is down.
    pub state: Option<ControllerState>,
    /// How long after bus-off the controller starts again by itself, in
    /// milliseconds; 0 is never.
    pub restart_ms: Option<u32>,
}

/// Why there is nothing to say about an interface.
#[derive(Debug)]
pub enum LinkError {
    /// There is none of that name.
    Unknown,
    /// It exists, but is no CAN interface.
    NotCan,
    /// The system would not tell.
    System(io::Error),
}

impl CanLink {
    /// Asks for the interface called `name`. Allocates nothing.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn read(name: &str) -> Result<Self, LinkError> {
        let socket = open_route_socket()?;
        ask(&socket, &Request::by_name(name).ok_or(LinkError::Unknown)?)?;
        let mut buffer = [0; BUFFER_BYTES];
        let received = receive(&socket, &mut buffer)?;
        match messages(received).next() {
            Some(Message::Link(link)) => Self::parse(link).map(|(_, link)| link).ok_or(LinkError::NotCan),
            Some(Message::Error(errno)) if errno == rustix::io::Errno::NODEV.raw_os_error() => Err(LinkError::Unknown),
            Some(Message::Error(errno)) => Err(LinkError::System(io::Error::from_raw_os_error(errno))),
            Some(Message::Done) | None => Err(LinkError::System(io::ErrorKind::InvalidData.into())),
        }
    }

    /// All CAN interfaces with their names, in the kernel's order.
    ///
    /// # Errors
    /// [`LinkError::System`].
    pub fn all() -> Result<Vec<(String, Self)>, LinkError> {
        let socket = open_route_socket()?;
        ask(&socket, &Request::everything())?;
        let mut links = Vec::new();
        loop {
            let mut buffer = [0; BUFFER_BYTES];
            for message in messages(receive(&socket, &mut buffer)?) {
                match message {
                    Message::Link(link) => links.extend(Self::parse(link).map(|(name, link)| (name.to_owned(), link))),
                    Message::Error(errno) => return Err(LinkError::System(io::Error::from_raw_os_error(errno))),
                    Message::Done => return Ok(links),
                }
            }
        }
    }

    /// Name and particulars from a `struct ifinfomsg` with its attributes;
    /// `None` when it is no CAN interface.
    fn parse(link: &[u8]) -> Option<(&str, Self)> {
        if u16_at(link, 2)? != ARPHRD_CAN {
            return None;
        }
        let mut name = "";
        let mut parsed = Self {
            index: u32_at(link, 4)?,
            is_up: u32_at(link, 8)? & IFF_UP != 0,
            is_controller: false,
            carries_fd: false,
            queue_frames: 0,
            bit_rate_bit_s: None,
            data_bit_rate_bit_s: None,
            state: None,
            restart_ms: None,
        };
        for (kind, value) in attributes(link.get(IFINFO_BYTES..)?) {
            match kind {
                IFLA_IFNAME => name = std::str::from_utf8(value).ok()?.trim_end_matches('\0'),
                IFLA_MTU => parsed.carries_fd = u32_at(value, 0)? >= CANFD_MTU,
                IFLA_TXQLEN => parsed.queue_frames = u32_at(value, 0)?,
                IFLA_LINKINFO => parsed.read_particulars(value)?,
                _ => {}
            }
        }
        Some((name, parsed))
    }

    /// `IFLA_LINKINFO`: what drivers of real controllers add.
    fn read_particulars(&mut self, info: &[u8]) -> Option<()> {
        self.is_controller = attributes(info).any(|(kind, value)| kind == IFLA_INFO_KIND && value == b"can\0");
        if !self.is_controller {
            return Some(());
        }
        let data = attributes(info).find(|(kind, _)| *kind == IFLA_INFO_DATA).map_or(&[][..], |(_, data)| data);
        for (kind, value) in attributes(data) {
            match kind {
                // `struct can_bittiming` begins with the bit rate, 0 when unset.
                IFLA_CAN_BITTIMING => self.bit_rate_bit_s = u32_at(value, 0).filter(|rate| *rate > 0),
                IFLA_CAN_DATA_BITTIMING => self.data_bit_rate_bit_s = u32_at(value, 0).filter(|rate| *rate > 0),
                IFLA_CAN_STATE => self.state = controller_state(u32_at(value, 0)?),
                IFLA_CAN_RESTART_MS => self.restart_ms = u32_at(value, 0),
                _ => {}
            }
        }
        Some(())
    }
}

impl From<rustix::io::Errno> for LinkError {
    fn from(errno: rustix::io::Errno) -> Self {
        Self::System(errno.into())
    }
}

/// `enum can_state`; stopped and sleeping are no states of error.
fn controller_state(state: u32) -> Option<ControllerState> {
    Some(match state {
        0 => ControllerState::ErrorActive,
        1 => ControllerState::ErrorWarning,
        2 => ControllerState::ErrorPassive,
        3 => ControllerState::BusOff,
        _ => return None,
    })
}

/// An `RTM_GETLINK` request.
struct Request {
    bytes: [u8; HEADER_BYTES + IFINFO_BYTES + ATTRIBUTE_HEADER_BYTES + NAME_BYTES],
    len: usize,
}

/// One message of an answer.
enum Message<'a> {
    Link(&'a [u8]),
    Error(i32),
    Done,
}

impl Request {
    fn everything() -> Self {
        Self::new(NLM_F_REQUEST | NLM_F_DUMP, HEADER_BYTES + IFINFO_BYTES)
    }

    /// `None` when no interface can have that name.
    fn by_name(name: &str) -> Option<Self> {
        if name.is_empty() || name.len() >= NAME_BYTES || name.contains('\0') {
            return None;
        }
        let start = HEADER_BYTES + IFINFO_BYTES;
        let mut request = Self::new(NLM_F_REQUEST, start + ATTRIBUTE_HEADER_BYTES + NAME_BYTES);
        // The whole field of a name: what is left of it are the closing zeros.
        request.put(start, &((ATTRIBUTE_HEADER_BYTES + NAME_BYTES) as u16).to_ne_bytes());
        request.put(start + 2, &IFLA_IFNAME.to_ne_bytes());
        request.put(start + ATTRIBUTE_HEADER_BYTES, name.as_bytes());
        Some(request)
    }

    fn new(flags: u16, len: usize) -> Self {
        let bytes = [0; HEADER_BYTES + IFINFO_BYTES + ATTRIBUTE_HEADER_BYTES + NAME_BYTES];
        let mut request = Self { bytes, len };
        request.put(0, &(len as u32).to_ne_bytes());
        request.put(4, &RTM_GETLINK.to_ne_bytes());
        request.put(6, &flags.to_ne_bytes());
        request
    }

    fn put(&mut self, at: usize, value: &[u8]) {
        self.bytes[at..at + value.len()].copy_from_slice(value);
    }
}

fn open_route_socket() -> rustix::io::Result<OwnedFd> {
    // NETLINK_ROUTE is 0, as no protocol is.
    rustix::net::socket_with(AddressFamily::NETLINK, SocketType::RAW, SocketFlags::CLOEXEC, None)
}

fn ask(socket: &OwnedFd, request: &Request) -> rustix::io::Result<()> {
    let kernel = netlink::SocketAddrNetlink::new(0, 0);
    rustix::net::sendto(socket, &request.bytes[..request.len], SendFlags::empty(), &kernel).map(drop)
}

fn receive<'a>(socket: &OwnedFd, buffer: &'a mut [u8]) -> rustix::io::Result<&'a [u8]> {
    let (received, _) = rustix::io::retry_on_intr(|| rustix::net::recv(socket, &mut *buffer, RecvFlags::empty()))?;
    Ok(&buffer[..received])
}

/// The messages in one datagram; ends at the first that is cut short.
fn messages(mut rest: &[u8]) -> impl Iterator<Item = Message<'_>> {
    std::iter::from_fn(move || {
        loop {
            let len = u32_at(rest, 0)? as usize;
            let body = rest.get(HEADER_BYTES..len)?;
            let kind = u16_at(rest, 4)?;
            rest = rest.get(len.next_multiple_of(4)..).unwrap_or_default();
            match kind {
                RTM_NEWLINK => return Some(Message::Link(body)),
                NLMSG_ERROR => return Some(Message::Error((u32_at(body, 0)? as i32).wrapping_neg())),
                NLMSG_DONE => return Some(Message::Done),
                _ => {}
            }
        }
    })
}

/// Type and value of each attribute (`struct rtattr`).
fn attributes(mut rest: &[u8]) -> impl Iterator<Item = (u16, &[u8])> {
    std::iter::from_fn(move || {
        let len = usize::from(u16_at(rest, 0)?);
        let kind = u16_at(rest, 2)? & NLA_TYPE_MASK;
        let value = rest.get(ATTRIBUTE_HEADER_BYTES..len)?;
        rest = rest.get(len.next_multiple_of(4)..).unwrap_or_default();
        Some((kind, value))
    })
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|chunk| u16::from_ne_bytes(*chunk))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|chunk| u32::from_ne_bytes(*chunk))
}

// `linux/netlink.h`, `linux/rtnetlink.h`
const HEADER_BYTES: usize = 16;
const IFINFO_BYTES: usize = 16;
const ATTRIBUTE_HEADER_BYTES: usize = 4;
const NLM_F_REQUEST: u16 = 0x001;
const NLM_F_DUMP: u16 = 0x300;
const NLMSG_ERROR: u16 = 2;
const NLMSG_DONE: u16 = 3;
const NLA_TYPE_MASK: u16 = 0x3FFF;
const RTM_NEWLINK: u16 = 16;
const RTM_GETLINK: u16 = 18;
// `linux/if.h`, `linux/if_arp.h`, `linux/if_link.h`
const NAME_BYTES: usize = 16;
const ARPHRD_CAN: u16 = 280;
const IFF_UP: u32 = 1;
const IFLA_IFNAME: u16 = 3;
const IFLA_MTU: u16 = 4;
const IFLA_TXQLEN: u16 = 13;
const IFLA_LINKINFO: u16 = 18;
const IFLA_INFO_KIND: u16 = 1;
const IFLA_INFO_DATA: u16 = 2;
// `linux/can.h`, `linux/can/netlink.h`
const CANFD_MTU: u32 = 72;
const IFLA_CAN_BITTIMING: u16 = 1;
const IFLA_CAN_STATE: u16 = 4;
const IFLA_CAN_RESTART_MS: u16 = 6;
const IFLA_CAN_DATA_BITTIMING: u16 = 9;
/// The kernel fills at most a page or 32 KiB at a time, and no more than the
/// reader has room for.
const BUFFER_BYTES: usize = 32 * 1024;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loopback_interface_is_known_to_be_no_can_interface() {
        assert!(matches!(CanLink::read("lo"), Err(LinkError::NotCan)));
    }

    #[test]
    fn an_interface_that_is_not_there_is_unknown() {
        assert!(matches!(CanLink::read("nocan7"), Err(LinkError::Unknown)));
        assert!(matches!(CanLink::read("a-name-that-is-too-long"), Err(LinkError::Unknown)));
        assert!(matches!(CanLink::read(""), Err(LinkError::Unknown)));
    }

    #[test]
    fn listing_all_lists_can_interfaces_only() {
        assert!(CanLink::all().unwrap().iter().all(|(name, _)| name != "lo"));
    }

    #[test]
    fn an_answer_cut_anywhere_is_no_panic() {
        let mut link = vec![0; IFINFO_BYTES];
        link[2..4].copy_from_slice(&ARPHRD_CAN.to_ne_bytes());
        link.extend([8, 0, IFLA_MTU as u8, 0, 72, 0, 0, 0]);
        link.extend([12, 0, IFLA_LINKINFO as u8, 0, 8, 0, IFLA_INFO_KIND as u8, 0]);
        link.extend(b"can\0");
        assert!(CanLink::parse(&link).unwrap().1.carries_fd);
        for len in 0..link.len() {
            CanLink::parse(&link[..len]);
        }
    }
}
