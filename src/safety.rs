//! The last gate before a torque leaves: nothing passes unless the stack is
//! running, and then only finite, limited and rate-limited torque.

use crate::config::{Bound, Section};
use crate::wheels::Wheels;

/// What the stack is doing, and whether torque may flow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum State {
    /// Waiting for a first word from both drives.
    #[default]
    Boot,
    /// Both drives answer and are disabled; waiting for the operator.
    Stopped,
    /// Asked the drives to enable; waiting for both.
    Enabling,
    /// Torque flows.
    Running,
    /// Something went wrong. Torque stays zero until the operator resets, and
    /// a reset leads to `Stopped`, never to motion.
    Tripped(Reason),
}

/// Why the stack tripped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// A drive sent no feedback for longer than allowed.
    StaleFeedback,
    /// The law asked for a torque that is no number.
    NotFinite,
    /// A drive reported a fault.
    DriveFault,
    /// A drive left its enabled state unasked.
    DriveDisabled,
    /// A wheel was too far from where it should be.
    FollowingError,
    /// The loop woke up more than a period late.
    LoopOverrun,
    /// The bus went away, or its controller off it.
    BusLost,
    /// A drive's feedback counted further than it can have: it, or somebody
    /// who sends in its name, answers what was not asked.
    CounterJump,
}

/// Limits that the gate keeps; see `[safety]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Torque at a wheel, N m.
    pub torque_limit_nm: f64,
    /// Change of torque at a wheel, N m/s.
    pub torque_rate_nm_per_s: f64,
    /// Periods without feedback after which the stack trips.
    pub feedback_timeout_periods: u32,
    /// Wheel angle error after which the stack trips, rad.
    pub following_error_rad: f64,
    /// Periods by which the loop may wake up late before the stack trips.
    pub overrun_periods: u32,
}

/// Holds the state and lets torque through, or not.
#[derive(Clone, Copy, Debug)]
pub struct Gate {
    limits: Limits,
    torque_step_nm: f64,
    state: State,
    last_nm: Wheels<f64>,
}

impl State {
    /// A number for logs: 0 boot, 1 stopped, 2 enabling, 3 running, 4 and up
    /// tripped, one number a reason.
    pub const fn code(self) -> u8 {
        match self {
            Self::Boot => 0,
            Self::Stopped => 1,
            Self::Enabling => 2,
            Self::Running => 3,
            Self::Tripped(Reason::StaleFeedback) => 4,
            Self::Tripped(Reason::NotFinite) => 5,
            Self::Tripped(Reason::DriveFault) => 6,
            Self::Tripped(Reason::DriveDisabled) => 7,
            Self::Tripped(Reason::FollowingError) => 8,
            Self::Tripped(Reason::LoopOverrun) => 9,
            Self::Tripped(Reason::BusLost) => 10,
            Self::Tripped(Reason::CounterJump) => 11,
        }
    }

    /// A word for logs.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Boot => "boot",
            Self::Stopped => "stopped",
            Self::Enabling => "enabling",
            Self::Running => "running",
            Self::Tripped(_) => "tripped",
        }
    }

    /// A sentence for people.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Boot => "waiting for both drives to answer",
            Self::Stopped => "stopped: both drives answer, no torque",
            Self::Enabling => "waiting for both drives to enable",
            Self::Running => "running",
            Self::Tripped(Reason::StaleFeedback) => "tripped: a drive sent no feedback for too long",
            Self::Tripped(Reason::NotFinite) => "tripped: the control law asked for a torque that is no number",
            Self::Tripped(Reason::DriveFault) => "tripped: a drive reported a fault",
            Self::Tripped(Reason::DriveDisabled) => "tripped: a drive left its enabled state unasked",
            Self::Tripped(Reason::FollowingError) => "tripped: a wheel was too far from where it should be",
            Self::Tripped(Reason::LoopOverrun) => "tripped: the loop woke up more than a period late",
            Self::Tripped(Reason::BusLost) => "tripped: the bus went away, or its controller off it",
            Self::Tripped(Reason::CounterJump) => "tripped: a drive's feedback counted further than it was asked to",
        }
    }
}

impl Limits {
    /// Reads a `[safety]` section. The torque limit is the drive's unless a
    /// lower one is given; the torque rate and the following error are not
    /// limited unless given.
    pub fn read(section: &Section<'_>, drive_torque_limit_nm: f64) -> Self {
        Self {
            torque_limit_nm: section
                .number_or("torque_limit_nm", drive_torque_limit_nm, Bound::Positive)
                .min(drive_torque_limit_nm),
            torque_rate_nm_per_s: section.number_or("torque_rate_nm_per_s", f64::INFINITY, Bound::Positive),
            feedback_timeout_periods: section.integer_or("feedback_timeout_periods", 2, 1, 1000) as u32,
            overrun_periods: section.integer_or("overrun_periods", 1, 1, 1000) as u32,
            following_error_rad: section.number_or("following_error_rad", f64::INFINITY, Bound::Positive),
        }
    }
}

impl Gate {
    /// A gate that is shut.
    pub fn new(limits: Limits, period_s: f64) -> Self {
        let torque_step_nm = limits.torque_rate_nm_per_s * period_s;
        Self { limits, torque_step_nm, state: State::Boot, last_nm: Wheels::default() }
    }

    /// What the stack is doing.
    pub const fn state(&self) -> State {
        self.state
    }

    /// The limits it keeps.
    pub const fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Goes to another state. A trip is latched: only [`Self::reset`] leaves it.
    pub fn enter(&mut self, state: State) {
        if !matches!(self.state, State::Tripped(_)) {
            self.state = state;
        }
    }

    /// Leaves a trip for `Stopped`; does nothing in any other state.
    pub fn reset(&mut self) {
        if matches!(self.state, State::Tripped(_)) {
            self.state = State::Stopped;
        }
    }

    /// The torque that may leave, N m, where `wanted_nm` was asked for: zero
    /// unless running. A torque that is no number trips.
    pub fn pass(&mut self, wanted_nm: Wheels<f64>) -> Wheels<f64> {
        if !wanted_nm.all(|torque| torque.is_finite()) {
            self.enter(State::Tripped(Reason::NotFinite));
        }
        self.last_nm = match self.state {
            State::Running => wanted_nm.zip_with(self.last_nm, |wanted, last| self.limited(wanted, last)),
            _ => Wheels::default(),
        };
        self.last_nm
    }

    fn limited(&self, wanted_nm: f64, last_nm: f64) -> f64 {
        let step_nm = self.torque_step_nm;
        let limit_nm = self.limits.torque_limit_nm;
        wanted_nm.clamp(last_nm - step_nm, last_nm + step_nm).clamp(-limit_nm, limit_nm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn running() -> Gate {
        let limits = Limits {
            torque_limit_nm: 90.0,
            torque_rate_nm_per_s: 1000.0,
            feedback_timeout_periods: 2,
            following_error_rad: f64::INFINITY,
            overrun_periods: 1,
        };
        let mut gate = Gate::new(limits, 0.005);
        gate.enter(State::Running);
        gate
    }

    #[test]
    fn torque_is_limited_in_rate_and_in_size() {
        let mut gate = running();
        assert_eq!(gate.pass(Wheels { right: 3.0, left: -50.0 }), Wheels { right: 3.0, left: -5.0 });
        for _ in 0..40 {
            gate.pass(Wheels::both(1e9));
        }
        assert_eq!(gate.pass(Wheels::both(1e9)), Wheels::both(90.0));
    }

    #[test]
    fn a_torque_that_is_no_number_trips_and_the_trip_is_latched() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut gate = running();
            assert_eq!(gate.pass(Wheels { right: 1.0, left: bad }), Wheels::default());
            gate.enter(State::Running);
            assert_eq!(gate.state(), State::Tripped(Reason::NotFinite));
            assert_eq!(gate.pass(Wheels::both(1.0)), Wheels::default());
        }
    }

    #[test]
    fn a_reset_leads_to_stopped_and_never_to_motion() {
        let mut gate = running();
        gate.enter(State::Tripped(Reason::DriveFault));
        gate.reset();
        assert_eq!(gate.state(), State::Stopped);
        assert_eq!(gate.pass(Wheels::both(1.0)), Wheels::default());
    }

    #[test]
    fn nothing_passes_unless_running() {
        for state in [State::Boot, State::Stopped, State::Enabling] {
            let mut gate = running();
            gate.enter(state);
            assert_eq!(gate.pass(Wheels::both(1.0)), Wheels::default());
        }
    }
}
