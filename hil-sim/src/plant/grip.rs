//! Does a wheel at rest stick, and if not, which way does it start?

use canloop::wheels::{Wheel, Wheels};

use super::dynamics::Dynamics;

/// How friction acts in a wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Grip {
    /// At rest, and friction holds it there.
    Sticks,
    /// Turning, or about to, in this direction: +1 or -1, or 0 where there is
    /// no dry friction and the direction does not matter.
    Slips(f64),
}

/// What a wheel at rest with dry friction may do. Sticking comes first: it
/// wins a tie.
const AT_REST: [Grip; 3] = [Grip::Sticks, Grip::Slips(1.0), Grip::Slips(-1.0)];

/// A wheel that cannot stick may slip though it seems to be pulled back by
/// this torque, N m: at the instant of breaking loose, rounding decides.
const ROUNDING_NM: f64 = 1e-10;

impl Dynamics {
    /// What each wheel does at this speed under this torque.
    ///
    /// A wheel in motion slips. Wheels at rest are decided together, since
    /// each feels the other's acceleration: of all combinations the one is
    /// taken in which stuck wheels are held by no more than static friction
    /// and slipping ones move the way they are said to. As the mass matrix is
    /// positive definite there is just one, ties aside.
    pub fn grip(&self, speed_rad_s: Wheels<f64>, torque_nm: Wheels<f64>) -> Wheels<Grip> {
        let moving = Wheels::from_fn(|wheel| self.moving(wheel, speed_rad_s[wheel]));
        let rest = Wheels::from_fn(|wheel| speed_rad_s[wheel] == 0.0 && moving[wheel] != Grip::Slips(0.0));
        if !rest.right && !rest.left {
            return moving;
        }
        let choices = rest
            .zip_with(moving.as_ref(), |rest, moving| if rest { &AT_REST[..] } else { std::slice::from_ref(moving) });
        self.most_consistent(choices, speed_rad_s, torque_nm)
    }

    fn moving(&self, wheel: Wheel, speed_rad_s: f64) -> Grip {
        Grip::Slips(if self.friction()[wheel].is_dry() { 1.0_f64.copysign(speed_rad_s) } else { 0.0 })
    }

    /// The first combination without contradiction. Rounding can leave a tie
    /// with none: then the one that is off by least.
    fn most_consistent(
        &self,
        choices: Wheels<&[Grip]>,
        speed_rad_s: Wheels<f64>,
        torque_nm: Wheels<f64>,
    ) -> Wheels<Grip> {
        let mut best = Wheels { right: choices.right[0], left: choices.left[0] };
        let mut least_nm = f64::INFINITY;
        for &right in choices.right {
            for &left in choices.left {
                let grip = Wheels { right, left };
                let off_nm = self.contradiction_nm(grip, speed_rad_s, torque_nm);
                if off_nm == 0.0 {
                    return grip;
                }
                if off_nm < least_nm {
                    (best, least_nm) = (grip, off_nm);
                }
            }
        }
        best
    }

    /// By how much torque these grips contradict what would follow from them
    /// for the wheels at rest, N m; 0 where they do not.
    fn contradiction_nm(&self, grip: Wheels<Grip>, speed_rad_s: Wheels<f64>, torque_nm: Wheels<f64>) -> f64 {
        let net_nm = self.net_nm(grip, speed_rad_s, torque_nm);
        let acceleration = self.mobility(grip).times(net_nm);
        let worst = Wheels::from_fn(|wheel| match grip[wheel] {
            Grip::Sticks => self.held_nm(wheel, net_nm, acceleration).abs() - self.friction()[wheel].static_nm,
            Grip::Slips(_) if speed_rad_s[wheel] != 0.0 => 0.0,
            Grip::Slips(direction) => -direction * acceleration[wheel] * self.inertia_kg_m2(wheel) - ROUNDING_NM,
        });
        worst.right.max(worst.left).max(0.0)
    }
}
