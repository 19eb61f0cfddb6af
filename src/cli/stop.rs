//! Ctrl-C and SIGTERM ask a run to end; it says goodbye to the drives first.

use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// From now on Ctrl-C and SIGTERM set the flag that comes back.
pub fn listen() -> &'static AtomicBool {
    // Without a handler Ctrl-C ends the program at once; the drives' watchdogs
    // are there for that.
    let _ = ctrlc::set_handler(|| ASKED.store(true, Ordering::Relaxed));
    &ASKED
}
