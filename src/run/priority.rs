//! What a real-time loop asks of the machine: a priority that only the kernel
//! beats, and memory that is never swapped out. Where it is refused the loop
//! runs all the same, and says so.

use rustix::mm::{MlockAllFlags, mlockall};

use crate::event::Notice;

/// Something that the machine does not allow a loop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Degraded {
    /// What that means for the loop, of the kind [`DEGRADED`].
    pub notice: Notice,
    /// What was refused, and the command that would allow it.
    pub refusal: String,
}

/// The kind of notice that the machine does not allow the loop something.
pub const DEGRADED: &str = "degraded";

/// Above everything ordinary, below the kernel's threads for interrupts, which
/// are at 50: at the top, a loop that goes wrong starves what would stop it.
pub(super) const FIFO_PRIORITY: i32 = 40;

/// Asks for the calling thread: SCHED_FIFO and locked memory. Tells what was
/// refused.
pub fn raise() -> Vec<Degraded> {
    let scheduling = fifo().err().map(|error| Degraded {
        notice: degraded("the loop has no real-time priority: ordinary programs delay it"),
        refusal: format!("no SCHED_FIFO: {error} (allow it with: ulimit -r {FIFO_PRIORITY}, or CAP_SYS_NICE)"),
    });
    let memory = mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE).err().map(|error| Degraded {
        notice: degraded("the loop's memory is not locked: it may be swapped out"),
        refusal: format!("memory is not locked: {error} (allow it with: ulimit -l unlimited)"),
    });
    scheduling.into_iter().chain(memory).collect()
}

const fn degraded(text: &'static str) -> Notice {
    Notice { kind: DEGRADED, text }
}

#[allow(unsafe_code, reason = "no safe crate in the tree sets a scheduling class")]
fn fifo() -> std::io::Result<()> {
    // SAFETY: `parameters` is a valid sched_param for the length of the call,
    // which only reads it; 0 is the calling thread.
    let refused = unsafe {
        let parameters = libc::sched_param { sched_priority: FIFO_PRIORITY };
        libc::sched_setscheduler(0, libc::SCHED_FIFO, &parameters)
    };
    if refused == 0 { Ok(()) } else { Err(std::io::Error::last_os_error()) }
}
