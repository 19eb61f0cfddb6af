//! canloop's codec and the Rust that dbc-codegen generates, as scripts/bench
//! measures them: `bench-peers WHO WORK SECONDS` prints millions of frames a
//! second.

mod generated;
mod ours;

use std::time::Instant;

/// Payloads to work on, too many for a predictor to learn by heart.
pub const FRAMES: usize = 1024;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, who, work, seconds] = arguments.as_slice() else { panic!("bench-peers WHO WORK SECONDS") };
    let seconds: f64 = seconds.parse().expect("SECONDS is a number");
    let rate = match (who.as_str(), work.as_str()) {
        ("canloop", work) => ours::rate(work, seconds),
        ("dbc-codegen", "decode-feedback") => rate(seconds, generated::decode_feedback()),
        ("dbc-codegen", "encode-feedback") => rate(seconds, generated::encode_feedback()),
        _ => panic!("unknown: {who} {work}"),
    };
    println!("{rate:.3}");
}

/// Millions of calls a second of `work`, which is called with 0 to `FRAMES`.
pub fn rate(seconds: f64, mut work: impl FnMut(usize) -> f64) -> f64 {
    let (mut done, mut sum, begun) = (0_u64, 0.0, Instant::now());
    loop {
        for index in 0..FRAMES {
            sum += work(index);
        }
        done += FRAMES as u64;
        let elapsed = begun.elapsed().as_secs_f64();
        if elapsed >= seconds {
            std::hint::black_box(sum);
            return 1e-6 * done as f64 / elapsed;
        }
    }
}
