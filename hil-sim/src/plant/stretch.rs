//! A stretch of smooth motion: while no wheel comes to rest or breaks loose,
//! the equations of motion are smooth and a Runge-Kutta step serves.

use canloop::wheels::{Wheel, Wheels};

use super::dynamics::{Dynamics, Mobility};
use super::grip::Grip;
use super::torque::Torque;

/// The motion from a given moment on, as long as the grips stay what they are.
///
/// A torque's decaying excess is integrated exactly, so that it hardly limits
/// the step: the speeds are `u + (what the excess alone adds)`, and the
/// Runge-Kutta scheme works on `u`.
pub struct Stretch<'p> {
    /// The equations of motion.
    pub dynamics: &'p Dynamics,
    /// Which wheels stick, and which way the others turn.
    pub grip: Wheels<Grip>,
    /// What follows from that.
    pub mobility: Mobility,
    /// Speeds at the start, rad/s.
    pub speed: Wheels<f64>,
    /// Acceleration at the start without the excess, rad/s^2.
    pub steady_acceleration: Wheels<f64>,
    /// Acceleration at the start by the excess alone, rad/s^2.
    pub excess_acceleration: Wheels<f64>,
    /// Without an excess that does not matter.
    pub torque: Wheels<Torque>,
    final_nm: Wheels<f64>,
}

/// Where a step through a stretch leads.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// How long it takes, s.
    pub span_s: f64,
    /// Speeds at the end, rad/s.
    pub speed: Wheels<f64>,
    /// Turned since the start, rad.
    pub turned: Wheels<f64>,
    /// Speeds half-way in time, rad/s.
    pub mid_speed: Wheels<f64>,
    /// Turned from the start to half-way, rad.
    pub mid_turned: Wheels<f64>,
    /// Acceleration at the end, to the order of the scheme, rad/s^2.
    pub acceleration: Wheels<f64>,
}

/// What the excess torque adds to the motion in a given time.
#[derive(Clone, Copy, Default)]
struct Gain {
    acceleration: Wheels<f64>,
    speed: Wheels<f64>,
    turned: Wheels<f64>,
    /// Half-way only: the added speed with which Simpson's rule finds the
    /// added turn of the whole step. Friction in proportion to the speed then
    /// feels the right mean, however long the step.
    felt: Wheels<f64>,
}

impl<'p> Stretch<'p> {
    /// The motion from these speeds on.
    pub fn new(dynamics: &'p Dynamics, grip: Wheels<Grip>, speed: Wheels<f64>, torque: Wheels<Torque>) -> Self {
        let torque = torque.map(|torque| if torque.is_constant() { Torque::constant(torque.final_nm) } else { torque });
        let final_nm = torque.map(|torque| torque.final_nm);
        let mobility = dynamics.mobility(grip);
        Self {
            dynamics,
            grip,
            mobility,
            speed,
            steady_acceleration: mobility.times(dynamics.net_nm(grip, speed, final_nm)),
            excess_acceleration: mobility.times(torque.map(|torque| torque.excess_nm)),
            torque,
            final_nm,
        }
    }

    /// One step of the classical fourth-order Runge-Kutta scheme, with the
    /// half-way values from its continuous extension of third order. The span
    /// must be more than zero.
    pub fn step(&self, span_s: f64) -> Step {
        let half_s = 0.5 * span_s;
        let (mid, end) = self.gains(span_s);
        let k1 = self.steady_acceleration;
        let k2 = self.steady_acceleration_at(self.speed + k1 * half_s + mid.felt);
        let k3 = self.steady_acceleration_at(self.speed + k2 * half_s + mid.felt);
        let k4 = self.steady_acceleration_at(self.speed + k3 * span_s + end.speed);
        let k23 = k2 + k3;
        Step {
            span_s,
            speed: self.speed + (k1 + k23 * 2.0 + k4) * (span_s / 6.0) + end.speed,
            turned: self.speed * span_s + (k1 + k23) * (span_s * span_s / 6.0) + end.turned,
            mid_speed: self.speed + (k1 * 5.0 + k23 * 4.0 - k4) * (span_s / 24.0) + mid.speed,
            mid_turned: self.speed * half_s + (k1 * 7.0 + k23 * 3.0 - k4) * (span_s * span_s / 96.0) + mid.turned,
            acceleration: k4 + end.acceleration,
        }
    }

    /// How far the motion is from its end after `step`, negative beyond it:
    /// the speed of a slipping wheel that is about to come to rest (rad/s), or
    /// the holding torque that a stuck wheel has in reserve (N m), whichever
    /// is less. Only the sign and the place of zero mean anything.
    pub fn margin(&self, step: &Step) -> f64 {
        self.margin_at(step.span_s, step.speed)
    }

    /// The same at the start.
    pub fn start_margin(&self) -> f64 {
        self.margin_at(0.0, self.speed)
    }

    fn margin_at(&self, t_s: f64, speed: Wheels<f64>) -> f64 {
        let reserve = |wheel: Wheel| {
            let net_nm = self.dynamics.net_nm(self.grip, speed, self.torque.map(|torque| torque.at(t_s)));
            let held_nm = self.dynamics.held_nm(wheel, net_nm, self.mobility.times(net_nm));
            self.dynamics.friction()[wheel].static_nm - held_nm.abs()
        };
        let margin = |wheel: Wheel| match self.grip[wheel] {
            Grip::Sticks => reserve(wheel),
            Grip::Slips(direction) => direction * speed[wheel],
        };
        margin(Wheel::Right).min(margin(Wheel::Left))
    }

    fn steady_acceleration_at(&self, speed: Wheels<f64>) -> Wheels<f64> {
        self.mobility.times(self.dynamics.net_nm(self.grip, speed, self.final_nm))
    }

    /// Whether any torque is still changing.
    pub fn lags(&self) -> bool {
        self.torque.any(|torque| torque.excess_nm != 0.0)
    }

    /// What the excess adds until half-way and until the end.
    fn gains(&self, span_s: f64) -> (Gain, Gain) {
        if !self.lags() {
            return (Gain::default(), Gain::default());
        }
        let half_s = 0.5 * span_s;
        let half_decay = self.decay(half_s);
        let mid = self.gain(half_s, half_decay);
        let end = self.gain(span_s, half_decay.map(|half| half * half));
        let felt = end.turned * (1.5 / span_s) - end.speed * 0.25;
        (Gain { felt, ..mid }, end)
    }

    /// What each excess is multiplied by in `t_s`; one exponential does where
    /// both wheels have the same time constant.
    fn decay(&self, t_s: f64) -> Wheels<f64> {
        let Wheels { right, left } = &self.torque;
        let right_decay = right.decay(t_s);
        let alike = right.time_constant_s == left.time_constant_s;
        Wheels { right: right_decay, left: if alike { right_decay } else { left.decay(t_s) } }
    }

    /// The excess acceleration and its first and second integral over `t_s`,
    /// in which each excess falls by the factor `decay`.
    fn gain(&self, t_s: f64, decay: Wheels<f64>) -> Gain {
        let left_nm = self.torque.zip_with(decay, |torque, decay| torque.excess_nm * decay);
        let impulse =
            self.torque.zip_with(left_nm, |torque, left_nm| torque.time_constant_s * (torque.excess_nm - left_nm));
        let second = self
            .torque
            .zip_with(impulse, |torque, impulse| torque.time_constant_s * (torque.excess_nm * t_s - impulse));
        Gain {
            acceleration: self.mobility.times(left_nm),
            speed: self.mobility.times(impulse),
            turned: self.mobility.times(second),
            felt: Wheels::default(),
        }
    }
}
