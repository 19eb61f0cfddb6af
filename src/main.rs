//! The `canloop` program.
fn main() {}
