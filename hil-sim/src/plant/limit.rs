//! How long a step may be. The physics says it: nothing here looks at an
//! error of the last step, so the same motion always takes the same steps.

use canloop::wheels::{Wheel, Wheels};

use super::course::Course;
use super::friction::STRIBECK_END;
use super::grip::Grip;
use super::stretch::Stretch;
use super::torque::Torque;

/// Part of the time constant of viscous friction and velocity terms that a
/// step may span: a relative error of 1e-10 in each time constant.
const SMOOTH_STEP: f64 = 0.01;
/// The same for the Stribeck term, where motion spends few time constants:
/// 5e-8 in each.
const STRIBECK_STEP: f64 = 0.05;
/// Heading change in a step, rad: an error of 1e-11 of the way.
const TURN_RAD: f64 = 0.01;
/// Speed error, rad/s, allowed to a step for a torque that is lagging.
const LAG_ERROR_RAD_S: f64 = 5e-10;
/// Part of a torque's time constant that a step may span where a wheel is
/// within reach of rest: it could stop and start again unseen.
const LAG_NEAR_REST: f64 = 0.25;
/// Excess torque, N m, too small for that to matter.
const SMALL_EXCESS_NM: f64 = 1e-6;
/// A step is never shorter on account of the heading, s: who spins faster
/// than 2000 rad/s does not ask where to.
const SHORTEST_TURN_S: f64 = 1e-5;
/// A step is never shorter, s, so that the work is bounded under any torque.
const SHORTEST_S: f64 = 1e-9;

impl Stretch<'_> {
    /// The longest step, s, up to `left_s`, that is accurate. `refinement`
    /// divides every limit.
    pub fn step_limit(&self, left_s: f64, refinement: f64, course: &Course) -> f64 {
        let (smooth_hz, growth) = self.smooth_rate();
        let stribeck_hz = self.dynamics.stribeck_rate_hz(&self.mobility, self.speed);
        let mut span_s = left_s;
        shorten_growing(&mut span_s, smooth_hz, growth, SMOOTH_STEP / refinement);
        shorten(&mut span_s, stribeck_hz, STRIBECK_STEP / refinement);
        for wheel in Wheel::BOTH {
            self.limit_travel(&mut span_s, wheel, refinement);
        }
        self.limit_turn(&mut span_s, course, TURN_RAD / refinement);
        self.limit_lag(&mut span_s, smooth_hz + stribeck_hz, growth, refinement);
        self.limit_lag_near_rest(&mut span_s, refinement);
        span_s.max(SHORTEST_S).min(left_s)
    }

    /// Near rest a step travels a part of the Stribeck speed `1/a`, more of it
    /// as the term fades away; from far it does not jump into that zone.
    fn limit_travel(&self, span_s: &mut f64, wheel: Wheel, refinement: f64) {
        const LANDING: f64 = STRIBECK_END - 5.0;
        let friction = &self.dynamics.friction()[wheel];
        if friction.drop_nm() == 0.0 {
            return;
        }
        let distance = friction.stribeck_s_per_rad * self.speed[wheel].abs();
        let acceleration = self.steady_acceleration[wheel].abs() + self.excess_acceleration[wheel].abs();
        let rate_hz = friction.stribeck_s_per_rad * acceleration;
        if distance > STRIBECK_END {
            shorten(span_s, rate_hz, distance - LANDING);
        } else {
            let from_rest = self.dynamics.stribeck_travel(wheel);
            shorten(span_s, rate_hz, from_rest * (1.0 + 0.2 * distance) / refinement);
        }
    }

    fn limit_turn(&self, span_s: &mut f64, course: &Course, turn_rad: f64) {
        let rate_hz = course.yaw(self.speed).abs();
        let growth = course.yaw(self.steady_acceleration).abs() + course.yaw(self.excess_acceleration).abs();
        let before_s = *span_s;
        shorten_growing(span_s, rate_hz, growth, turn_rad);
        *span_s = span_s.max(SHORTEST_TURN_S).min(before_s);
    }

    /// How fast small differences of speed grow or shrink through viscous
    /// friction and the velocity terms, 1/s, and by how much that rate grows
    /// a second as the wheels get faster, 1/s^2; the latter four times over,
    /// since the velocity terms themselves go with the square of the speed.
    fn smooth_rate(&self) -> (f64, f64) {
        let viscous_hz = self.dynamics.viscous_rate_hz(&self.mobility);
        let velocity_hz = |speed| self.dynamics.velocity_rate_hz(&self.mobility, speed);
        let growth = velocity_hz(self.steady_acceleration) + velocity_hz(self.excess_acceleration);
        (viscous_hz + velocity_hz(self.speed), 4.0 * growth)
    }

    /// The scheme gets the first integral of what the excess adds to the
    /// speeds right; of the second it misses, for a step of `x` time
    /// constants, the part `x^3 / 720`, and never more than 1/30. What that
    /// does to the speeds goes with the square of the rate, and with how much
    /// the rate grows.
    fn limit_lag(&self, span_s: &mut f64, rate_hz: f64, growth: f64, refinement: f64) {
        for wheel in Wheel::BOTH {
            let time_constant_s = self.torque[wheel].time_constant_s;
            let felt = (rate_hz * rate_hz + growth) * *span_s * *span_s;
            let error = self.excess_acceleration[wheel].abs() * time_constant_s * felt;
            let cube = |t_s: f64| t_s * t_s * t_s;
            let missed = cube(*span_s * refinement).min(720.0 / 30.0 * cube(time_constant_s));
            let allowed = 720.0 * LAG_ERROR_RAD_S * cube(time_constant_s);
            if error * missed > allowed {
                *span_s = span_s.min(libm::cbrt(allowed / error) / refinement);
            }
        }
    }

    fn limit_lag_near_rest(&self, span_s: &mut f64, refinement: f64) {
        if !self.lags() {
            return;
        }
        let in_reach = Wheels::from_fn(|wheel| {
            let acceleration = self.steady_acceleration[wheel].abs() + self.excess_acceleration[wheel].abs();
            self.grip[wheel] != Grip::Sticks && self.speed[wheel].abs() <= acceleration * *span_s
        });
        if in_reach.right || in_reach.left {
            for wheel in Wheel::BOTH {
                let Torque { excess_nm, time_constant_s, .. } = self.torque[wheel];
                if excess_nm.abs() > SMALL_EXCESS_NM {
                    *span_s = span_s.min(LAG_NEAR_REST / refinement * time_constant_s);
                }
            }
        }
    }
}

/// Shortens `span_s` until `span_s * rate_hz` is no more than `allowed`.
fn shorten(span_s: &mut f64, rate_hz: f64, allowed: f64) {
    if *span_s * rate_hz > allowed {
        *span_s = allowed / rate_hz;
    }
}

/// The same for a rate that grows by `growth` a second, 1/s^2.
fn shorten_growing(span_s: &mut f64, rate_hz: f64, growth: f64, allowed: f64) {
    if *span_s * (rate_hz + growth * *span_s) > allowed {
        *span_s = 2.0 * allowed / (rate_hz + (rate_hz * rate_hz + 4.0 * growth * allowed).sqrt());
    }
}
