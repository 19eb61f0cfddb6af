//! The control laws and what leads them along a path.
//!
//! Once a period, [`Guidance`] says how the wheels should turn, and a [`Law`]
//! says with what torque. Both are joined in a [`Controller`], which the stack
//! and the paper's own ideal simulation share.

mod controller;
mod dac;
mod guidance;
mod law;
mod pi;

pub use controller::{Controller, ControllerConfig, Decision};
pub use guidance::{Guidance, Kanayama, PoseLoop, Sampling};
pub use law::{Law, LawConfig, Measured, Target};
