//! The end of a stretch: the instant at which a wheel comes to rest or breaks
//! loose, found by root finding on the length of the step.

use canloop::wheels::{Wheel, Wheels};

use super::grip::Grip;
use super::stretch::{Step, Stretch};

/// The instant is known when its bracket is this narrow, s.
const RESOLUTION_S: f64 = 1e-15;
/// Or when the margin is this close to zero, rad/s or N m.
const RESOLUTION: f64 = 1e-13;
/// When a stretch ends, a wheel slower than this, rad/s, has come to rest.
const REST_RAD_S: f64 = 1e-12;
/// A wheel that leaves rest and would be back within this time, s, never left.
const SHORTEST_SLIP_S: f64 = 1e-6;

impl Stretch<'_> {
    /// `step` itself if the stretch lasts through it, else the part of it up
    /// to the end of the stretch.
    pub fn lasting(&self, step: Step) -> Step {
        let early = self.dip(&step).or_else(|| self.brief_breakaway(&step));
        let step = early.unwrap_or(step);
        if self.margin(&step) < 0.0 { self.up_to_end(step) } else { step }
    }

    /// A part of `step` at whose end a wheel has passed zero, though it is
    /// back at the end of the whole: it turned round on the way.
    fn dip(&self, step: &Step) -> Option<Step> {
        Wheel::BOTH.into_iter().find_map(|wheel| {
            let Grip::Slips(direction) = self.grip[wheel] else { return None };
            let before = direction * (self.steady_acceleration[wheel] + self.excess_acceleration[wheel]);
            let after = direction * step.acceleration[wheel];
            let in_reach = direction * self.speed[wheel] < -before * step.span_s;
            if before < 0.0 && after > 0.0 && in_reach { self.lowest_point(wheel, direction, step) } else { None }
        })
    }

    /// Bisection for the instant at which `wheel` turns round, given up as
    /// soon as it is seen beyond zero.
    fn lowest_point(&self, wheel: Wheel, direction: f64, step: &Step) -> Option<Step> {
        const TRIES: usize = 20;
        let (mut low_s, mut high_s) = (0.0, step.span_s);
        for _ in 0..TRIES {
            let part = self.step(0.5 * (low_s + high_s));
            if self.margin(&part) < 0.0 {
                return Some(part);
            }
            if direction * part.acceleration[wheel] < 0.0 { low_s = part.span_s } else { high_s = part.span_s }
        }
        None
    }

    /// The part of `step` up to where a stuck wheel is pulled hardest, if that
    /// breaks it loose though it would hold at the end: two torques that lag
    /// differently may pull most in between.
    fn brief_breakaway(&self, step: &Step) -> Option<Step> {
        if !self.lags() {
            return None;
        }
        let stuck = Wheel::BOTH.into_iter().filter(|&wheel| self.grip[wheel] == Grip::Sticks);
        stuck.filter_map(|wheel| self.hardest_pull(wheel, step)).find(|part| self.margin(part) < 0.0)
    }

    /// Bisection for the instant at which the pull on a stuck `wheel` ceases
    /// to grow in one direction, if it does so within `step`.
    fn hardest_pull(&self, wheel: Wheel, step: &Step) -> Option<Step> {
        const TRIES: usize = 30;
        let growth = |t_s: f64| {
            let slope = self.torque.map(|torque| torque.slope(t_s));
            self.dynamics.held_nm(wheel, slope, self.mobility.times(slope))
        };
        let at_first = growth(0.0);
        if at_first * growth(step.span_s) >= 0.0 {
            return None;
        }
        let (mut low_s, mut high_s) = (0.0, step.span_s);
        for _ in 0..TRIES {
            let middle_s = 0.5 * (low_s + high_s);
            if growth(middle_s) * at_first > 0.0 { low_s = middle_s } else { high_s = middle_s }
        }
        Some(self.step(high_s))
    }

    /// `beyond` goes past the end of the stretch: the step that goes just to it.
    #[cold]
    fn up_to_end(&self, beyond: Step) -> Step {
        let mut beyond = beyond;
        while self.returned(&beyond).any(|&returned| returned) {
            if beyond.span_s < SHORTEST_SLIP_S {
                return self.holding(self.returned(&beyond)).step(beyond.span_s);
            }
            beyond = self.step(0.5 * beyond.span_s);
        }
        let start_margin = self.start_margin();
        if start_margin < 0.0 || self.margin(&beyond) >= 0.0 {
            return beyond;
        }
        self.at_rest(self.locate(start_margin, beyond))
    }

    /// Which wheels left rest and came back, so that a root search would only
    /// find the start.
    fn returned(&self, step: &Step) -> Wheels<bool> {
        Wheels::from_fn(|wheel| {
            let Grip::Slips(direction) = self.grip[wheel] else { return false };
            self.speed[wheel] == 0.0 && direction * step.speed[wheel] < 0.0
        })
    }

    /// The same motion with more wheels held.
    fn holding(&self, held: Wheels<bool>) -> Self {
        let grip = held.zip_with(self.grip, |held, grip| if held { Grip::Sticks } else { grip });
        Self::new(self.dynamics, grip, self.speed, self.torque)
    }

    /// Regula falsi (Illinois) on the length of the step; the result lies just
    /// beyond the root, so that what ends the stretch has really happened.
    fn locate(&self, start_margin: f64, beyond: Step) -> Step {
        /// More than bisection needs for a second.
        const TRIES: usize = 64;
        let (mut low_s, mut low_margin) = (0.0, start_margin);
        let (mut high, mut high_margin) = (beyond, self.margin(&beyond));
        let mut last_was_beyond = None;
        for _ in 0..TRIES {
            if high.span_s - low_s <= RESOLUTION_S {
                break;
            }
            let guess_s = low_s + (high.span_s - low_s) * low_margin / (low_margin - high_margin);
            let inside = guess_s > low_s && guess_s < high.span_s;
            let step = self.step(if inside { guess_s } else { 0.5 * (low_s + high.span_s) });
            let margin = self.margin(&step);
            let is_beyond = margin < 0.0;
            let same_side = last_was_beyond.replace(is_beyond) == Some(is_beyond);
            if is_beyond {
                (high, high_margin) = (step, margin);
                low_margin *= if same_side { 0.5 } else { 1.0 };
                if margin > -RESOLUTION {
                    break;
                }
            } else {
                (low_s, low_margin) = (step.span_s, margin);
                high_margin *= if same_side { 0.5 } else { 1.0 };
            }
        }
        high
    }

    /// `step` with the wheels that have just come to rest at rest.
    fn at_rest(&self, step: Step) -> Step {
        let speed = Wheels::from_fn(|wheel| match self.grip[wheel] {
            Grip::Slips(direction) if self.speed[wheel] != 0.0 && direction != 0.0 => {
                if direction * step.speed[wheel] < REST_RAD_S { 0.0 } else { step.speed[wheel] }
            }
            _ => step.speed[wheel],
        });
        Step { speed, ..step }
    }
}

#[cfg(test)]
mod tests {
    use canloop::robot::{Load, Model, Robot};

    use super::*;
    use crate::plant::dynamics::Dynamics;
    use crate::plant::{Friction, Torque};

    const ROBOT: Robot = Robot {
        model: Model::Paper,
        mass_kg: 46.5,
        inertia_kg_m2: 1.3133,
        half_track_m: 0.27,
        wheel_radius_m: 0.122,
        wheel_inertia_kg_m2: 0.0144,
        motor_inertia_kg_m2: 0.0125,
        gear_ratio: 3.0,
        load: Load { mass_kg: 80.0, cog_distance_m: 0.2, cog_angle_rad: 2.0 },
    };
    const FRICTION: Friction =
        Friction { viscous_nm_s_per_rad: 0.2, static_nm: 60.0, coulomb_nm: 6.0, stribeck_s_per_rad: 500.0 };

    #[test]
    fn a_wheel_wrongly_said_to_leave_rest_is_held_for_a_moment() {
        let dynamics = Dynamics::new(&ROBOT, Wheels::both(FRICTION));
        let grip = Wheels { right: Grip::Slips(1.0), left: Grip::Sticks };
        let torque = Wheels { right: Torque::constant(60.0 - 1e-11), left: Torque::constant(0.0) };
        let stretch = Stretch::new(&dynamics, grip, Wheels::default(), torque);
        let step = stretch.lasting(stretch.step(1e-3));
        assert_eq!(step.speed, Wheels::default());
        assert!(step.span_s > 0.1 * SHORTEST_SLIP_S, "time must go on, but by {} s", step.span_s);
    }

    #[test]
    fn a_braked_wheel_ends_the_stretch_exactly_at_rest() {
        let dynamics = Dynamics::new(&ROBOT, Wheels::both(FRICTION));
        let grip = Wheels { right: Grip::Slips(-1.0), left: Grip::Sticks };
        let torque = Wheels::both(Torque::constant(10.0));
        let stretch = Stretch::new(&dynamics, grip, Wheels { right: -1e-4, left: 0.0 }, torque);
        let step = stretch.lasting(stretch.step(1e-3));
        assert_eq!(step.speed, Wheels::default());
        assert!(step.span_s > 0.0 && step.span_s < 1e-5 && step.turned.right < 0.0);
    }
}
