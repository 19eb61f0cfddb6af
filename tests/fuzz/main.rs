//! Nothing that a file holds makes a reader panic, write where it should not,
//! or point at a place that is not there.
//!
//! Each target takes 10 s, or a third of that; CANLOOP_FUZZ_SECONDS sets another time, as in
//! `CANLOOP_FUZZ_SECONDS=3600 cargo test --release --test fuzz`.

mod dbc_text;
mod harness;
mod logs;
mod profile_toml;
