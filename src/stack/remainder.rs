//! What a command's frame could not say of a torque is said with the next.
//!
//! A law that asks for less than half a step more than before is not heard by
//! a drive with coarse commands, and a wheel may stay aside for ever: within a
//! step q, at an error of q / (2 M K_P). With the remainder carried over, the
//! mean of what is said is what was asked for.

use crate::schema::Profile;
use crate::wheels::Wheels;

/// Remainders of both wheels, N m.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Remainder(Wheels<f64>);

impl Remainder {
    /// What to ask for now that `wanted_nm` is wanted.
    pub fn added_to(&self, wanted_nm: Wheels<f64>) -> Wheels<f64> {
        wanted_nm + self.0
    }

    /// Keeps of `asked_nm` what commands of `sent_nm` do not say: at most a
    /// step, so that what a limit has cut off is not made up for later.
    pub fn settle(&mut self, profile: &Profile, asked_nm: Wheels<f64>, sent_nm: Wheels<f64>) {
        self.0 = Wheels::from_fn(|wheel| {
            let step_nm = profile.command_torque(wheel).resolution_nm;
            let left_nm = asked_nm[wheel] - profile.torque_as_said(wheel, sent_nm[wheel]);
            if left_nm.is_finite() { left_nm.clamp(-step_nm, step_nm) } else { 0.0 }
        });
    }
}
