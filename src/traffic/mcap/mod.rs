//! MCAP as canloop logs it (see [`crate::log`]), and frames of ROS 2 in
//! anybody's: `can_msgs/msg/Frame`, `ros2_socketcan_msgs/msg/FdFrame`.

mod channels;
mod messages;
mod reader;
mod writer;

pub(super) use reader::McapReader;
pub(super) use writer::McapWriter;
