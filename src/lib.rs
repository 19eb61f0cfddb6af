//! canloop closes a robot's control loop over a CAN bus.

pub mod bus;
pub mod config;
pub mod control;
pub mod event;
pub mod frame;
pub mod log;
pub mod odometry;
pub mod path;
pub mod report;
pub mod robot;
pub mod safety;
pub mod schema;
pub mod stack;
pub mod time;
pub mod wheels;
