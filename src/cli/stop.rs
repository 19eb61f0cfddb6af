//! Ctrl-C and SIGTERM ask a run to end; it says goodbye to the drives first.

use crate::run::StopSwitch;

static SWITCH: StopSwitch = StopSwitch::new();

/// From now on Ctrl-C and SIGTERM press the switch that comes back.
pub fn listen() -> &'static StopSwitch {
    // Without a handler Ctrl-C ends the program at once; the drives' watchdogs
    // are there for that.
    let _ = ctrlc::set_handler(|| SWITCH.press());
    &SWITCH
}
