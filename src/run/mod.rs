//! Runtimes: what holds the stack's hands. Small, and the only places that
//! read a clock or wait.

mod clock;

pub use clock::Clock;
