//! The outside: buses.

mod frame_bits;

pub use frame_bits::{data_phase_bits, frame_bits};
