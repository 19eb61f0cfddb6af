//! What a real-time loop asks of the machine: a priority that only the kernel
//! beats, and memory that is never swapped out. Where it is refused the loop
//! runs all the same, and says so.

use rustix::mm::{MlockAllFlags, mlockall};

/// What was asked for and what came of it: a refusal with the command that
/// would allow it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Priority {
    /// Why the loop has no real-time priority, if it has none.
    pub scheduling: Result<(), String>,
    /// Why its memory may be swapped out, if it may.
    pub memory: Result<(), String>,
}

/// Above everything ordinary, below the kernel's threads for interrupts, which
/// are at 50: at the top, a loop that goes wrong starves what would stop it.
pub(super) const FIFO_PRIORITY: i32 = 40;

/// Asks for the calling thread: SCHED_FIFO and locked memory.
pub fn raise() -> Priority {
    Priority {
        scheduling: fifo().map_err(|error| {
            format!("no SCHED_FIFO: {error} (allow it with: ulimit -r {FIFO_PRIORITY}, or CAP_SYS_NICE)")
        }),
        memory: mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE)
            .map_err(|error| format!("memory is not locked: {error} (allow it with: ulimit -l unlimited)")),
    }
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
