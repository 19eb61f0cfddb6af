//! Waiting for sockets, to the nanosecond.

use std::io;

use rustix::event::{PollFd, poll};
use rustix::io::Errno;
use rustix::time::Timespec;

use crate::run::Clock;
use crate::time::Instant;

/// Waits until one of `sockets` is ready, until `deadline` at the latest. A
/// deadline that has passed only looks.
///
/// `ppoll` and not a socket's receive timeout, which the kernel rounds up to
/// its ticks of up to 10 ms.
pub(super) fn wait(sockets: &mut [PollFd<'_>], clock: &Clock, deadline: Instant) -> io::Result<()> {
    loop {
        let nanos = (deadline - clock.now()).as_nanos().max(0);
        let timeout = Timespec { tv_sec: nanos / 1_000_000_000, tv_nsec: nanos % 1_000_000_000 };
        match poll(sockets, Some(&timeout)) {
            Ok(_) => return Ok(()),
            // A signal; its handler has had its turn.
            Err(Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
    }
}
