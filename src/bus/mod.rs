//! The outside: buses.
/// stub
pub fn frame_bits(frame: &crate::frame::Frame) -> u32 { 55 + 10 * frame.len() as u32 }
