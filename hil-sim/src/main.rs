//! The `hil-sim` program.
fn main() {}
