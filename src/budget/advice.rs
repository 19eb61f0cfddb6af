//! What would do where a bus does not.

use super::{Budget, Terms};
use crate::schema::Profile;
use crate::time::Duration;

/// The bit rates that CAN devices commonly know (CiA 301, table 1), bit/s.
pub const STANDARD_BIT_RATES_BIT_S: [u32; 9] =
    [10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];

/// Periods are looked for in steps of this.
const STEP: Duration = Duration::from_micros(10);
/// The longest period that a configuration can have, in those steps.
const LONGEST_STEPS: i64 = 1_000_000;

/// The lowest standard bit rate at which everything is in time, if any.
pub fn lowest_bit_rate(profile: &Profile, terms: &Terms) -> Option<u32> {
    let holds = |&bit_rate_bit_s: &u32| Budget::of(profile, &Terms { bit_rate_bit_s, ..*terms }).holds();
    STANDARD_BIT_RATES_BIT_S.into_iter().find(holds)
}

/// The shortest period, in steps of 10 us, from which on everything is in time
/// at this bit rate, if any.
pub fn shortest_period(profile: &Profile, terms: &Terms) -> Option<Duration> {
    let holds = |steps: i64| Budget::of(profile, &Terms { period: STEP * steps, ..*terms }).holds();
    if !holds(LONGEST_STEPS) {
        return None;
    }
    // Fails at the one, holds at the other.
    let (mut short, mut long) = (0, LONGEST_STEPS);
    while long - short > 1 {
        let middle = short + (long - short) / 2;
        if holds(middle) { long = middle } else { short = middle }
    }
    Some(STEP * long)
}
