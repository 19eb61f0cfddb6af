//! Ctrl-C asks a run to end; the run ends at its next period and closes its
//! files.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// From now on Ctrl-C and SIGTERM ask for an end.
pub fn listen() {
    // Without a handler Ctrl-C ends the program at once, as it would anyway.
    let _ = ctrlc::set_handler(|| ASKED.store(true, Ordering::Relaxed));
}

/// Breaks off if an end was asked for.
pub fn check() -> ControlFlow<()> {
    if ASKED.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}
