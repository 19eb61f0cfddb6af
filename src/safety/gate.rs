//! The last gate before a torque leaves.

#[cfg(all(feature = "weakened-stack", not(debug_assertions)))]
compile_error!("a gate that does not shut is for a test of the bench, never for a release");

use crate::wheels::Wheels;

/// Lets limited and rate-limited torque through while it is open.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gate {
    limit_nm: f64,
    /// The most by which torque may change from one period to the next, N m.
    step_nm: f64,
    last_nm: Wheels<f64>,
}

impl Gate {
    pub fn new(limit_nm: f64, step_nm: f64) -> Self {
        Self { limit_nm, step_nm, last_nm: Wheels::default() }
    }

    /// The torque that may leave, N m, where `wanted_nm`, which is finite, was
    /// asked for: zero unless the gate `is_open`.
    pub fn pass(&mut self, wanted_nm: Wheels<f64>, is_open: bool) -> Wheels<f64> {
        if cfg!(feature = "weakened-stack") && !is_open {
            return self.last_nm;
        }
        self.last_nm = if is_open {
            wanted_nm.zip_with(self.last_nm, |wanted, last| self.limited(wanted, last))
        } else {
            Wheels::default()
        };
        self.last_nm
    }

    fn limited(&self, wanted_nm: f64, last_nm: f64) -> f64 {
        let (step_nm, limit_nm) = (self.step_nm, self.limit_nm);
        wanted_nm.clamp(last_nm - step_nm, last_nm + step_nm).clamp(-limit_nm, limit_nm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn torque_is_limited_in_rate_and_in_size() {
        let mut gate = Gate::new(90.0, 5.0);
        assert_eq!(gate.pass(Wheels { right: 3.0, left: -50.0 }, true), Wheels { right: 3.0, left: -5.0 });
        assert_eq!(gate.pass(Wheels { right: -9.0, left: -50.0 }, true), Wheels { right: -2.0, left: -10.0 });
        for (wanted_nm, most_nm) in [(1e9, 90.0), (-1e9, -90.0)] {
            for _ in 0..40 {
                gate.pass(Wheels::both(wanted_nm), true);
            }
            assert_eq!(gate.pass(Wheels::both(wanted_nm), true), Wheels::both(most_nm));
        }
    }

    #[test]
    fn a_gate_that_is_shut_lets_nothing_through_and_begins_anew_at_zero() {
        let mut gate = Gate::new(90.0, 5.0);
        gate.pass(Wheels::both(5.0), true);
        gate.pass(Wheels::both(10.0), true);
        assert_eq!(gate.pass(Wheels::both(10.0), false), Wheels::default());
        assert_eq!(gate.pass(Wheels::both(10.0), true), Wheels::both(5.0));
    }
}
