//! A CAN card's clock, followed by what arrives.

/// How fast the card's clock may run against the system's: 100 ppm, twice a
/// poor crystal.
const DRIFT_PER: i64 = 10_000;
/// The longest way from the bus to the kernel that is believed. Beyond it the
/// card's clock must have started anew.
const LONGEST_DELAY_NANOS: i64 = 20_000_000;

/// Turns a card's stamps into the system's time.
///
/// A card stamps a frame when it is on the wire, but by a clock that began
/// anywhere and drifts; the kernel stamps it by the right clock, but a while
/// later. What the kernel's stamp is ahead of the card's is the clocks' offset
/// plus that delay; its lowest value, allowed to rise as fast as clocks drift,
/// is the offset plus the shortest delay. So the result keeps the card's even
/// spacing, is never later than the kernel's stamp, and is late by no more
/// than the shortest delay.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HardwareClock {
    /// Offset, and the kernel's stamp that it is of.
    offset_nanos: Option<(i64, i64)>,
}

impl HardwareClock {
    /// When the frame was on the bus by the clock of `arrival_nanos`, the
    /// kernel's stamp of the same frame.
    pub(super) fn system_nanos(&mut self, card_nanos: i64, arrival_nanos: i64) -> i64 {
        let seen = arrival_nanos.saturating_sub(card_nanos);
        let followed = self.offset_nanos.map(|(offset, at)| {
            let since = arrival_nanos.saturating_sub(at).max(0);
            offset.saturating_add(since / DRIFT_PER)
        });
        let offset = match followed {
            Some(followed) if seen.saturating_sub(followed) < LONGEST_DELAY_NANOS => followed.min(seen),
            _ => seen,
        };
        self.offset_nanos = Some((offset, arrival_nanos));
        card_nanos.saturating_add(offset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: i64 = 1_700_000_000_000_000_000;
    const MILLI: i64 = 1_000_000;

    /// A frame every millisecond, 50 us to 1 ms late, on a card that runs
    /// `drift_ppm` fast: how late each comes out.
    fn lateness(drift_ppm: i64) -> Vec<i64> {
        let mut clock = HardwareClock::default();
        let frame = |index: i64| {
            let sent = START + index * MILLI;
            let card = index * MILLI + index * drift_ppm;
            let delay = 50_000 + (index * 7919 % 20) * 50_000;
            clock.system_nanos(card, sent + delay) - sent
        };
        (0..100_000).map(frame).collect()
    }

    #[test]
    fn jitter_on_the_way_to_the_kernel_is_gone_whatever_the_drift() {
        for drift_ppm in [-80, 0, 80] {
            let late = &lateness(drift_ppm)[100..];
            assert!(
                late.iter().all(|late| (45_000..60_000).contains(late)),
                "{drift_ppm} ppm: {:?}",
                late.iter().max()
            );
        }
    }

    #[test]
    fn a_card_that_starts_anew_is_followed_at_once() {
        let mut clock = HardwareClock::default();
        clock.system_nanos(500 * MILLI, START);
        assert_eq!(clock.system_nanos(7, START + MILLI), START + MILLI);
        assert_eq!(clock.system_nanos(i64::MAX, START + 2 * MILLI), START + 2 * MILLI);
    }
}
