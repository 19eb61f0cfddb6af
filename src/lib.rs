//! canloop closes a robot's control loop over a CAN bus.

pub mod bus;
pub mod config;
pub mod event;
pub mod frame;
pub mod log;
pub mod robot;
pub mod schema;
pub mod time;
pub mod wheels;
