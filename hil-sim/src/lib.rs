//! The other end of the bus: simulated motor drives with the robot's full
//! dynamics behind them, and the bench that runs the control stack against
//! them.
//!
//! [`plant`] moves as the torques tell it, [`drive`] and [`encoder`] stand
//! between it and the bus ([`virtual_robot`]), [`wire`] is the bus; all that is
//! the [`far_side`], which [`mod@bench`] joins with the stack in lock-step. Of what happens, [`summary`]
//! keeps the figures, [`expect`] what became of what was expected, and [`trace`] and [`report`] what
//! pictures are drawn from.

pub mod bench;
pub mod campaign;
pub mod cli;
pub mod commands;
pub mod drive;
pub mod encoder;
pub mod expect;
pub mod far_side;
pub mod findings;
pub mod frames_hash;
mod ideal;
pub mod paper;
pub mod parallel;
pub mod plant;
pub mod recording;
pub mod report;
pub mod reproduce;
pub mod route;
pub mod scenario;
pub mod serve;
pub mod summary;
pub mod sweep;
pub mod timeline;
pub mod torque_csv;
pub mod trace;
pub mod virtual_robot;
pub mod wall;
pub mod wire;
