//! Captures of libpcap, `.pcap`, and of Wireshark, `.pcapng`, with SocketCAN
//! frames in them (`LINKTYPE_CAN_SOCKETCAN`), also behind the heads of Linux
//! cooked captures.
//!
//! The `pcap-parser` crate knows the layouts of blocks. Which bytes they get
//! is decided here, so that offsets are known and no length is believed.

mod blocks;
mod packet;
mod reader;
mod writer;

pub(super) use reader::PcapReader;
pub(super) use writer::{PcapWriter, PcapngWriter};

/// `LINKTYPE_CAN_SOCKETCAN`
const LINK_SOCKETCAN: u32 = 227;
/// `LINKTYPE_LINUX_SLL`
const LINK_COOKED: u32 = 113;
/// `LINKTYPE_LINUX_SLL2`
const LINK_COOKED_2: u32 = 276;
