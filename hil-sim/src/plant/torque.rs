//! The torque at a wheel over a stretch of time.

/// A torque that goes from one value to another as a first-order lag does:
/// `final_nm + excess_nm * exp(-t / time_constant_s)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Torque {
    /// Where it goes, N m.
    pub final_nm: f64,
    /// How far it is above that now, N m.
    pub excess_nm: f64,
    /// In what time the excess falls to 1/e, s. Zero: it is gone at once.
    pub time_constant_s: f64,
}

impl Torque {
    /// A torque that does not change.
    pub const fn constant(nm: f64) -> Self {
        Self { final_nm: nm, excess_nm: 0.0, time_constant_s: 0.0 }
    }

    /// The same with a constant torque added, N m.
    pub fn raised_by(self, nm: f64) -> Self {
        Self { final_nm: self.final_nm + nm, ..self }
    }

    /// The torque after `t_s` seconds, N m.
    pub fn at(&self, t_s: f64) -> f64 {
        self.final_nm + self.excess_nm * self.decay(t_s)
    }

    /// The mean torque over the next `span_s` seconds, N m.
    pub fn mean(&self, span_s: f64) -> f64 {
        if self.is_constant() || span_s <= 0.0 {
            return self.at(span_s);
        }
        let x = span_s / self.time_constant_s;
        self.final_nm - self.excess_nm * libm::expm1(-x) / x
    }

    /// What is left of it after `span_s` seconds.
    pub fn after(&self, span_s: f64) -> Self {
        Self { excess_nm: self.excess_nm * self.decay(span_s), ..*self }
    }

    /// The mean torque over the next `span_s` seconds, N m, and what is left
    /// after them: [`Self::mean`] and [`Self::after`] for one exponential.
    pub fn elapse(&self, span_s: f64) -> (f64, Self) {
        if self.is_constant() || span_s <= 0.0 {
            return (self.mean(span_s), self.after(span_s));
        }
        let x = span_s / self.time_constant_s;
        let lost = -libm::expm1(-x);
        (self.final_nm + self.excess_nm * lost / x, Self { excess_nm: self.excess_nm * (1.0 - lost), ..*self })
    }

    /// The torque at this moment, N m: `at(0.0)`, without the exponential.
    pub fn now_nm(&self) -> f64 {
        if self.is_constant() { self.final_nm } else { self.final_nm + self.excess_nm }
    }

    /// Whether there is no excess to speak of.
    pub(super) fn is_constant(&self) -> bool {
        const NEGLIGIBLE_NM: f64 = 1e-12;
        self.time_constant_s <= 0.0 || self.excess_nm.abs() < NEGLIGIBLE_NM
    }

    /// How fast the torque changes after `t_s` seconds, N m/s.
    pub(super) fn slope(&self, t_s: f64) -> f64 {
        if self.is_constant() { 0.0 } else { -self.excess_nm * self.decay(t_s) / self.time_constant_s }
    }

    /// What the excess is multiplied by in `t_s` seconds.
    pub(super) fn decay(&self, t_s: f64) -> f64 {
        if self.is_constant() { 0.0 } else { libm::exp(-t_s / self.time_constant_s) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAG: Torque = Torque { final_nm: 2.0, excess_nm: 6.0, time_constant_s: 1e-3 };

    #[test]
    fn the_excess_decays() {
        assert_eq!(LAG.at(0.0), 8.0);
        assert!((LAG.at(1e-3) - (2.0 + 6.0 / std::f64::consts::E)).abs() < 1e-14);
        assert!((LAG.after(4e-4).at(6e-4) - LAG.at(1e-3)).abs() < 1e-14);
    }

    #[test]
    fn the_mean_is_that_of_many_samples() {
        let samples = 10_000;
        let sum: f64 = (0..samples).map(|k| LAG.at((f64::from(k) + 0.5) * 3e-3 / f64::from(samples))).sum();
        assert!((LAG.mean(3e-3) - sum / f64::from(samples)).abs() < 1e-7);
        assert_eq!(LAG.mean(0.0), 8.0);
        let (mean_nm, left) = LAG.elapse(3e-3);
        assert!((mean_nm - LAG.mean(3e-3)).abs() < 1e-14);
        assert!((left.excess_nm - LAG.after(3e-3).excess_nm).abs() < 1e-14);
    }

    #[test]
    fn without_a_time_constant_the_final_torque_holds_at_once() {
        let torque = Torque { time_constant_s: 0.0, ..LAG };
        assert_eq!((torque.at(0.0), torque.mean(1.0), torque.after(1.0).at(0.0)), (2.0, 2.0, 2.0));
        assert_eq!(Torque::constant(3.0).at(7.0), 3.0);
    }
}
