//! Runtimes: what holds the stack's hands. Small, and the only places that
//! read a clock or wait.

mod clock;
#[cfg(target_os = "linux")]
pub mod doctor;
mod lockstep;

pub use clock::Clock;
pub use lockstep::{End, LockStep};
