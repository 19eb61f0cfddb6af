//! How closely the paper's robot keeps to its path with friction on each kind
//! of drive that ships.

/// What README.md promises of a scenario, or about a half more than is measured
/// where that is less.
pub struct Promise {
    pub scenario: &'static str,
    /// Worst position error from 30 s on, m.
    pub max_after_30s_m: f64,
    /// Torque chatter, N m.
    pub chatter_nm: f64,
}

/// A row for every profile that ships.
pub const DRIVES: [Promise; 7] = [
    promise("dac-friction", 0.002, 0.25),
    promise("cia402", 0.002, 0.05),
    promise("odrive-0.6", 0.002, 0.15),
    promise("odrive-0.5", 0.002, 0.15),
    promise("vesc", 0.002, 0.05),
    promise("damiao-dm4310", 0.002, 0.4),
    promise("comma-body", 0.1, 0.2),
];

const fn promise(scenario: &'static str, max_after_30s_m: f64, chatter_nm: f64) -> Promise {
    Promise { scenario, max_after_30s_m, chatter_nm }
}
