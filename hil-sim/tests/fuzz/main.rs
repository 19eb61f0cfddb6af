//! Whatever frames come, whenever they come, and whatever the operator wants
//! meanwhile: the stack lets no torque out that it should not, the simulated
//! drives apply none, and neither panics or grows without end.
//!
//! An input is a text that says what happens, a line each ([`script`]), so that
//! what was found can be read. CONTRIBUTING.md has more on fuzzing.

#[path = "../rig/drives.rs"]
#[allow(dead_code, reason = "only the names are wanted")]
mod drives;
mod drives_that_ship;
mod frames;
mod frames_into_the_drives;
mod frames_into_the_stack;
#[path = "../../../tests/fuzz/harness.rs"]
mod harness;
mod script;
mod watched_drives;
mod watched_stack;
