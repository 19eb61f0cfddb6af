//! How long a step may be. The physics says it: nothing here looks at an
//! error of the last step, so the same motion always takes the same steps.

use canloop::wheels::{Wheel, Wheels};

use super::course::Course;
use super::friction::STRIBECK_END;
use super::stretch::Stretch;

/// Part of the time constant of viscous friction and velocity terms that a
/// step may span: a relative error of 1e-9 in each time constant.
const SMOOTH_STEP: f64 = 0.02;
/// The same for the Stribeck term, where motion spends few time constants.
const STRIBECK_STEP: f64 = 0.05;
/// Part of the Stribeck speed `1/a` that a step from rest may travel.
const STRIBECK_TRAVEL: f64 = 0.2;
/// Heading change in a step, rad: 1e-10 of the way travelled.
const TURN_RAD: f64 = 0.02;
/// Speed error, rad/s, allowed to a step for a torque that is lagging.
const LAG_ERROR_RAD_S: f64 = 5e-10;
/// A step is never shorter on account of the heading, s: who spins faster
/// than 2000 rad/s does not ask where to.
const SHORTEST_TURN_S: f64 = 1e-5;
/// A step is never shorter, s, so that the work is bounded under any torque.
const SHORTEST_S: f64 = 1e-9;

impl Stretch<'_> {
    /// The longest step, s, up to `left_s`, that is accurate. `refinement`
    /// divides every limit.
    pub fn step_limit(&self, left_s: f64, refinement: f64, course: &Course) -> f64 {
        let smooth_hz = self.dynamics.smooth_rate_hz(&self.mobility, self.speed);
        let stribeck_hz = self.dynamics.stribeck_rate_hz(&self.mobility, self.speed);
        let mut span_s = left_s;
        shorten(&mut span_s, smooth_hz, SMOOTH_STEP / refinement);
        shorten(&mut span_s, stribeck_hz, STRIBECK_STEP / refinement);
        for wheel in Wheel::BOTH {
            self.limit_travel(&mut span_s, wheel, refinement);
        }
        self.limit_turn(&mut span_s, course, TURN_RAD / refinement);
        self.limit_lag(&mut span_s, smooth_hz + stribeck_hz, refinement);
        span_s.max(SHORTEST_S).min(left_s)
    }

    /// Near rest a step travels a part of the Stribeck speed, more of it as
    /// the term fades away (its error goes with the term and with the fifth
    /// power of the travel); from far it does not jump into that zone.
    fn limit_travel(&self, span_s: &mut f64, wheel: Wheel, refinement: f64) {
        const LANDING: f64 = STRIBECK_END - 5.0;
        let friction = &self.dynamics.friction()[wheel];
        if friction.drop_nm() == 0.0 {
            return;
        }
        let distance = friction.stribeck_s_per_rad * self.speed[wheel].abs();
        let travel = if distance > STRIBECK_END {
            distance - LANDING
        } else {
            STRIBECK_TRAVEL * (1.0 + distance / 5.0) / refinement
        };
        let acceleration = self.steady_acceleration[wheel].abs() + self.excess_acceleration[wheel].abs();
        shorten(span_s, friction.stribeck_s_per_rad * acceleration, travel);
    }

    fn limit_turn(&self, span_s: &mut f64, course: &Course, turn_rad: f64) {
        let yaw = |wheels: Wheels<f64>| course.yaw(wheels).abs();
        let acceleration = yaw(self.steady_acceleration) + yaw(self.excess_acceleration);
        let rate_hz = yaw(self.speed) + acceleration * *span_s;
        let before_s = *span_s;
        shorten(span_s, rate_hz, turn_rad);
        *span_s = span_s.max(SHORTEST_TURN_S).min(before_s);
    }

    /// The scheme gets the first integral of what the excess adds to the
    /// speeds right; of the second it misses, for a step of `x` time
    /// constants, the part `x^3 / 720`, and never more than 1/30. What that
    /// does to the speeds goes with the square of the friction's rate.
    fn limit_lag(&self, span_s: &mut f64, rate_hz: f64, refinement: f64) {
        for wheel in Wheel::BOTH {
            let time_constant_s = self.torque[wheel].time_constant_s;
            let felt = rate_hz * *span_s;
            let error = self.excess_acceleration[wheel].abs() * time_constant_s * (felt * felt);
            let x = *span_s * refinement;
            let missed = (x * x * x).min(24.0 * time_constant_s * time_constant_s * time_constant_s);
            let allowed = 720.0 * LAG_ERROR_RAD_S * time_constant_s * time_constant_s * time_constant_s;
            if error * missed > allowed {
                *span_s = span_s.min(libm::cbrt(allowed / error) / refinement);
            }
        }
    }
}

/// Makes `span_s` no longer than `allowed / rate_hz`, dividing only if it must.
fn shorten(span_s: &mut f64, rate_hz: f64, allowed: f64) {
    if *span_s * rate_hz > allowed {
        *span_s = allowed / rate_hz;
    }
}
