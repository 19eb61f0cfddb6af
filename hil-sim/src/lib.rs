//! The other end of the bus: simulated drives with the robot's dynamics behind them.

pub mod plant;
pub mod torque_csv;
