//! A raw CAN socket, set up and read.

use std::io::{self, IoSliceMut, Write as _};
use std::os::fd::AsRawFd as _;

use nix::errno::Errno;
use nix::libc;
use nix::sys::socket::{ControlMessageOwned, MsgFlags, TimestampingFlag, recvmsg, setsockopt, sockopt};
use nix::sys::time::TimeSpec;
use rustix::event::{PollFd, PollFlags};
use rustix::net::sockopt::{set_socket_recv_buffer_size, set_socket_recv_buffer_size_force};
use rustix::net::{RecvAncillaryBuffer, RecvFlags};
use rustix::time::Timespec;
use socketcan::{CanFdSocket, CanFilter, Socket as _, SocketOptions as _};

use super::hardware_clock::HardwareClock;
use super::wire::{self, FD_BYTES, Outgoing, Received};
use crate::time::Duration;

/// The room asked for, in bytes; the kernel gives what `net.core.rmem_max`
/// allows. A frame takes about 1 KB of it.
const RECEIVE_BUFFER_BYTES: usize = 1 << 20;
/// Who logs a bus may be held up longer.
const LISTENER_BUFFER_BYTES: usize = 16 << 20;
/// `SK_MEMINFO_DROPS` (`linux/sock_diag.h`), in 32-bit words.
const DROPS_AT: usize = 8;

/// A socket bound to one interface, which never blocks.
pub(super) struct Socket {
    inner: CanFdSocket,
    /// There where the interface stamps by a clock of its own.
    hardware_clock: Option<HardwareClock>,
    /// Whether somebody wants to know which frames programs on this machine sent.
    tells_origin: bool,
    /// The kernel's count of frames that it had no room for, as last told.
    dropped: u32,
}

/// One thing received.
pub(super) struct Arrived {
    /// `None` when it is of a kind that nobody asked for.
    pub content: Option<Received>,
    /// When, by `CLOCK_REALTIME`.
    pub realtime_nanos: Option<i64>,
    /// Whether a program on this machine sent it.
    pub is_from_here: bool,
    /// Frames lost before it.
    pub lost: u32,
}

impl Socket {
    /// A socket on the interface of this number, which gives the frames that
    /// `filters` let through, or all when there is none, and error messages.
    pub fn open(interface: u32, filters: &[CanFilter], tells_origin: bool) -> io::Result<Self> {
        // The socket takes CAN FD even where the interface does not. Frames
        // sent here reach other programs, but do not come back: the kernel's
        // default.
        let inner = CanFdSocket::open_iface(interface)?;
        inner.set_nonblocking(true)?;
        if !filters.is_empty() {
            inner.set_filters(filters)?;
        }
        inner.set_error_filter_accept_all()?;
        setsockopt(&inner, sockopt::ReceiveTimestampns, &true)?;
        setsockopt(&inner, sockopt::RxqOvfl, &1)?;
        // Less room is no reason to refuse: what does not fit is counted.
        if tells_origin {
            // Beyond what the system allows everybody, where we may.
            let _ = set_socket_recv_buffer_size_force(&inner, LISTENER_BUFFER_BYTES)
                .or_else(|_| set_socket_recv_buffer_size(&inner, LISTENER_BUFFER_BYTES));
        } else {
            let _ = inner.as_raw_socket().set_recv_buffer_size(RECEIVE_BUFFER_BYTES);
        }
        let mut hardware_clock = None;
        if inner.has_hw_timestamps() {
            let flags =
                TimestampingFlag::SOF_TIMESTAMPING_RX_HARDWARE | TimestampingFlag::SOF_TIMESTAMPING_RAW_HARDWARE;
            setsockopt(&inner, sockopt::Timestamping, &flags)?;
            hardware_clock = Some(HardwareClock::default());
        }
        Ok(Self { inner, hardware_clock, tells_origin, dropped: 0 })
    }

    /// Hands one frame to the interface's queue.
    pub fn send(&mut self, frame: &Outgoing) -> io::Result<()> {
        loop {
            match self.inner.write(frame.as_bytes()) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                sent => return sent.map(drop),
            }
        }
    }

    /// What there is; `None` when there is nothing.
    pub fn receive(&mut self) -> io::Result<Option<Arrived>> {
        let is_from_here = self.tells_origin && self.is_next_from_here();
        let mut bytes = [0; FD_BYTES];
        let mut control = ControlBuffer([0; CONTROL_BYTES]);
        let mut parts = [IoSliceMut::new(&mut bytes)];
        let fd = self.inner.as_raw_fd();
        let message = loop {
            match recvmsg::<()>(fd, &mut parts, Some(&mut control.0), MsgFlags::empty()) {
                Ok(message) => break message,
                Err(Errno::EINTR) => {}
                Err(Errno::EAGAIN) => return Ok(None),
                Err(errno) => return Err(errno.into()),
            }
        };
        let (mut kernel_nanos, mut card_nanos, mut dropped) = (None, None, None);
        for control in message.cmsgs()? {
            match control {
                ControlMessageOwned::ScmTimestampns(stamp) => kernel_nanos = Some(nanos(stamp)),
                ControlMessageOwned::ScmTimestampsns(stamps) => card_nanos = Some(nanos(stamps.hw_raw)),
                ControlMessageOwned::RxqOvfl(count) => dropped = Some(count),
                _ => {}
            }
        }
        let len = message.bytes;
        let realtime_nanos = match (kernel_nanos, card_nanos, &mut self.hardware_clock) {
            // A frame of a program on this machine has no stamp of the card.
            (Some(kernel), Some(card), Some(clock)) if card != 0 => Some(clock.system_nanos(card, kernel)),
            _ => kernel_nanos,
        };
        let lost = dropped.map_or(0, |count| self.newly_lost(count));
        let content = wire::read(&bytes[..len.min(FD_BYTES)]);
        Ok(Some(Arrived { content, realtime_nanos, is_from_here, lost }))
    }

    /// Frames lost since the last one that arrived. Those would otherwise be
    /// told of with the next frame only, which may never come.
    pub fn lost_since(&mut self) -> u32 {
        let mut words = [0; (DROPS_AT + 1) * size_of::<u32>()];
        match self.inner.get_socket_option_bytes(libc::SOL_SOCKET, libc::SO_MEMINFO, &mut words) {
            Ok(_) => {
                let count = words.last_chunk().map_or(0, |count| u32::from_ne_bytes(*count));
                self.newly_lost(count)
            }
            Err(_) => 0,
        }
    }

    /// Waits for something to receive, at most `span`; may come back early.
    pub fn wait(&self, span: Duration) -> io::Result<()> {
        let nanos = span.as_nanos().max(0);
        let timeout = Timespec { tv_sec: nanos / 1_000_000_000, tv_nsec: nanos % 1_000_000_000 };
        match rustix::event::poll(&mut [PollFd::new(&self.inner, PollFlags::IN)], Some(&timeout)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(errno) => Err(errno.into()),
        }
    }

    /// Whether a program on this machine sent what comes next. The kernel marks it
    /// (`MSG_DONTROUTE`) where the reader of stamps does not look.
    fn is_next_from_here(&self) -> bool {
        const FROM_HERE: u32 = libc::MSG_DONTROUTE.cast_unsigned();
        let mut byte = [0; 1];
        let mut parts = [rustix::io::IoSliceMut::new(&mut byte)];
        let mut nothing = RecvAncillaryBuffer::default();
        let flags = RecvFlags::PEEK | RecvFlags::DONTWAIT;
        let next = rustix::net::recvmsg(&self.inner, &mut parts, &mut nothing, flags);
        next.is_ok_and(|next| next.flags.bits() & FROM_HERE != 0)
    }

    /// How far the kernel's count has come. A frame that was in the queue
    /// when the count was last read may bring an older one.
    fn newly_lost(&mut self, count: u32) -> u32 {
        let lost = count.wrapping_sub(self.dropped).cast_signed().max(0).cast_unsigned();
        self.dropped = self.dropped.wrapping_add(lost);
        lost
    }
}

/// Room for one stamp, three stamps and a counter, each with its header.
const CONTROL_BYTES: usize = 256;

/// Control messages begin with a `cmsghdr`, which must be aligned.
#[repr(align(8))]
struct ControlBuffer([u8; CONTROL_BYTES]);

fn nanos(stamp: TimeSpec) -> i64 {
    stamp.tv_sec() * 1_000_000_000 + stamp.tv_nsec()
}
