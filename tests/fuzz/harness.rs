//! Runs a target on inputs that nobody thought of: seeds, changed at random.
//!
//! It is for a stable toolchain, which has no coverage to be guided by. Instead
//! a target tells kinds of outcomes apart, and an input with an outcome not
//! seen before becomes a seed. Another package's tests can include this file.

use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// How long each target runs, s; another number is in CANLOOP_FUZZ_SECONDS.
const SECONDS: f64 = 10.0;
/// So many inputs are kept to be changed further.
const POOL: usize = 2000;
/// Inputs are no longer than this, bytes.
const LONGEST: usize = 64 << 10;

/// What is to be tried.
pub struct Target<'t> {
    /// Names the file in which an input is left that made it panic.
    pub name: &'t str,
    /// Inputs to begin with.
    pub seeds: Vec<Vec<u8>>,
    /// Words that mean something to it.
    pub words: &'t [&'t str],
    /// How much of the time it takes: less where it is one of many of its sort.
    pub share: f64,
}

impl Target<'_> {
    /// Runs `run` on inputs until the time is over. It must not panic; what it
    /// returns tells kinds of outcomes apart.
    pub fn fuzz(self, run: impl Fn(&[u8]) -> u64) {
        let seconds = self.share * environment("CANLOOP_FUZZ_SECONDS").unwrap_or(SECONDS);
        let seed = environment("CANLOOP_FUZZ_SEED").unwrap_or_else(seed_of_the_moment);
        let mut chance = Chance(seed);
        let mut seen = BTreeSet::new();
        let mut pool = Vec::new();
        let (mut tried, begun) = (0_u64, now());
        let first_seeds = self.seeds.len();
        let mut waiting = self.seeds.clone();
        while !waiting.is_empty() || begun.elapsed() < Duration::from_secs_f64(seconds) {
            let is_seed = !waiting.is_empty();
            let input = waiting.pop().unwrap_or_else(|| self.changed(&pool, &mut chance));
            let outcome = catch_unwind(AssertUnwindSafe(|| run(&input))).unwrap_or_else(|panic| {
                let path = self.keep(&input);
                eprintln!("{}: input {tried} panicked and is kept in {}", self.name, path.display());
                eprintln!("again: CANLOOP_FUZZ_SEED={seed}; put the file among the seeds, in tests/fuzz/seeds");
                resume_unwind(panic)
            });
            let is_new = seen.insert(outcome);
            if is_seed || is_new && pool.len() < POOL {
                pool.push(input);
            } else if is_new {
                let place = first_seeds + chance.below(POOL - first_seeds);
                pool[place] = input;
            }
            tried += 1;
        }
        println!("{}: {tried} inputs, {} outcomes from {first_seeds} seeds, seed {seed}", self.name, seen.len());
    }

    /// One of the pool, changed in a few places.
    fn changed(&self, pool: &[Vec<u8>], chance: &mut Chance) -> Vec<u8> {
        let mut input = chance.one_of(pool).cloned().unwrap_or_default();
        for _ in 0..=chance.below(6) {
            self.change(&mut input, pool, chance);
        }
        input.truncate(LONGEST);
        input
    }

    fn change(&self, input: &mut Vec<u8>, pool: &[Vec<u8>], chance: &mut Chance) {
        let at = chance.below(input.len() + 1);
        let some = at..(at + chance.length()).min(input.len());
        match chance.below(9) {
            0 if !some.is_empty() => input[at] ^= 1 << chance.below(8),
            1 if !some.is_empty() => input[at] = chance.below(256) as u8,
            2 => drop(input.drain(some)),
            3 => {
                let copy = input[some].to_vec();
                let to = chance.below(input.len() + 1);
                drop(input.splice(to..to, copy));
            }
            4 => {
                let bytes: Vec<u8> = (0..chance.below(8)).map(|_| chance.below(256) as u8).collect();
                drop(input.splice(at..at, bytes));
            }
            5 => drop(input.splice(some, chance.one_of(self.words).unwrap_or(&"").bytes())),
            6 => drop(input.splice(number_at(input, at), chance.number().into_bytes())),
            7 => swap_lines(input, at, chance),
            _ => {
                let other = chance.one_of(pool).cloned().unwrap_or_default();
                let from = chance.below(other.len() + 1);
                let until = (from + chance.length()).min(other.len());
                drop(input.splice(at..at, other[from..until].iter().copied()));
            }
        }
    }

    fn keep(&self, input: &[u8]) -> PathBuf {
        let path = std::env::temp_dir().join(format!("canloop-fuzz-{}-{:016x}", self.name, digest(input)));
        std::fs::write(&path, input).expect("the input is kept");
        path
    }
}

/// The contents of all files in `folder`.
pub fn seeds_in(folder: &Path) -> Vec<Vec<u8>> {
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder).expect("seeds").map(|entry| entry.expect("a seed").path()).collect();
    paths.retain(|path| path.is_file() && path.file_name().is_none_or(|name| name != ".gitattributes"));
    paths.sort();
    paths.iter().map(|path| std::fs::read(path).expect("a seed")).collect()
}

/// A number that tells byte strings apart (FNV-1a).
pub fn digest(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xCBF2_9CE4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01B3))
}

/// Knuth's linear congruential generator.
pub struct Chance(pub u64);

impl Chance {
    /// A number from 0 to `limit`, which it does not reach unless it is 0.
    pub fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((u128::from(self.0 >> 16) * limit as u128) >> 48) as usize
    }

    fn one_of<'i, T>(&mut self, items: &'i [T]) -> Option<&'i T> {
        items.get(self.below(items.len()))
    }

    /// Mostly a few bytes, now and then a lot.
    fn length(&mut self) -> usize {
        let most = [2, 8, 40, 400][self.below(4)];
        1 + self.below(most)
    }

    /// One that people forget to think of.
    fn number(&mut self) -> String {
        let numbers = [
            "0",
            "-1",
            "1",
            "7",
            "8",
            "63",
            "64",
            "65",
            "255",
            "256",
            "511",
            "512",
            "2047",
            "2048",
            "65535",
            "65536",
            "2147483647",
            "2147483648",
            "3221225472",
            "4294967295",
            "4294967296",
            "9223372036854775808",
            "18446744073709551615",
            "-9223372036854775809",
            "340282366920938463463374607431768211456",
            "1e400",
            "-1E-400",
            "0.1",
            "-.5",
            "1.",
            "0x7F",
            "nan",
            "inf",
        ];
        numbers[self.below(numbers.len())].to_owned()
    }
}

/// The digits at `at`, if there are any.
fn number_at(input: &[u8], at: usize) -> std::ops::Range<usize> {
    let is_digit = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-');
    let start = input[..at].iter().rposition(|byte| !is_digit(byte)).map_or(0, |before| before + 1);
    start..at + input[at..].iter().take_while(|byte| is_digit(byte)).count()
}

fn swap_lines(input: &mut Vec<u8>, at: usize, chance: &mut Chance) {
    let start = input[..at].iter().rposition(|byte| *byte == b'\n').map_or(0, |before| before + 1);
    let end = at + input[at..].iter().position(|byte| *byte == b'\n').map_or(input.len() - at, |len| len + 1);
    let line: Vec<u8> = input.drain(start..end).collect();
    let to = chance.below(input.len() + 1);
    let to = input[..to].iter().rposition(|byte| *byte == b'\n').map_or(0, |before| before + 1);
    input.splice(to..to, line);
}

fn environment<T: std::str::FromStr>(name: &str) -> Option<T> {
    let text = std::env::var(name).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{name} wants a number, found {text:?}")))
}

/// Another one each time, so that every run of the tests looks elsewhere.
#[allow(clippy::disallowed_methods, reason = "a fuzzer is a runtime")]
fn seed_of_the_moment() -> u64 {
    SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |since| since.as_nanos() as u64)
}

#[allow(clippy::disallowed_methods, reason = "a fuzzer is a runtime")]
fn now() -> Instant {
    Instant::now()
}
