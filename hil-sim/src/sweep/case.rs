//! One run of a sweep.

/// What is laid over the scenario.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Case {
    /// Its number, from 0.
    pub number: u64,
    /// The value of each axis, as TOML has it.
    pub values: Vec<String>,
    /// The seed.
    pub seed: u64,
    /// All of it as `KEY=VALUE`.
    pub overrides: Vec<String>,
}
