//! canloop closes a robot's control loop over a CAN bus.
//!
//! The centre is [`stack::Stack`], which takes frames and moments and gives
//! frames, events and its next wake-up. It holds no socket, file or clock; a
//! runtime does:
//!
//! ```text
//! loop {
//!     while let Some(frame) = stack.poll_transmit() { bus.send(frame) }
//!     while let Some(event) = stack.poll_event()    { sink.event(now, &event) }
//!     match bus.receive_until(stack.next_wakeup()) {
//!         Frame { at, frame } => stack.handle_frame(at, &frame),
//!         Deadline { at }     => stack.handle_wakeup(at),
//!     }
//! }
//! ```
//!
//! **Time** is integer nanoseconds ([`time`]); the stack never reads a clock.
//! **Units** are SI and stand last in every name. **Errors** in input are
//! [`config::Problems`], each with its place; nothing that a frame or a file
//! holds makes the stack panic.

pub mod budget;
pub mod bus;
pub mod capture;
pub mod check;
pub mod cli;
pub mod config;
pub mod control;
pub mod estimator;
pub mod event;
pub mod exchange;
pub mod fifo;
pub mod frame;
pub mod live;
pub mod log;
pub mod odometry;
pub mod path;
pub mod replay;
pub mod report;
pub mod robot;
pub mod run;
pub mod safety;
pub mod schema;
pub mod stack;
pub mod time;
pub mod traffic;
pub mod wheels;
