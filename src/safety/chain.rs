//! The state machine: what leads from one state to the next.

use super::gate::Gate;
use super::limits::Limits;
use super::state::{Operator, Reason, State};
use super::watch::{Finding, Watch};
use crate::schema::{DriveState, Request};
use crate::wheels::{Wheel, Wheels};

/// Holds the state, watches, and lets torque through or not.
#[derive(Clone, Debug)]
pub struct Chain {
    limits: Limits,
    state: State,
    /// Whose doing a trip is, if it is one wheel's.
    culprit: Option<Wheel>,
    /// Periods since the state was entered.
    periods_in_state: u32,
    enable_wanted: bool,
    clear_fault_wanted: bool,
    watch: Watch,
    gate: Gate,
}

impl Chain {
    /// A chain in `Boot`, for a stack with this period.
    pub fn new(limits: Limits, period_s: f64) -> Self {
        Self {
            limits,
            state: State::Boot,
            culprit: None,
            periods_in_state: 0,
            enable_wanted: false,
            clear_fault_wanted: false,
            watch: Watch::new(limits, period_s),
            gate: Gate::new(limits.torque_limit_nm, limits.torque_rate_nm_per_s * period_s),
        }
    }

    /// What the stack is doing.
    pub const fn state(&self) -> State {
        self.state
    }

    /// Whose doing the trip is, if the stack has tripped and it is one wheel's.
    pub const fn culprit(&self) -> Option<Wheel> {
        self.culprit
    }

    /// The limits it keeps.
    pub const fn limits(&self) -> &Limits {
        &self.limits
    }

    /// What the drives are to be asked for.
    pub const fn request(&self) -> Request {
        if self.state.is_armed() {
            Request::Enable
        } else if self.clear_fault_wanted {
            Request::ClearFault
        } else {
            Request::Disable
        }
    }

    /// The drives have been asked.
    pub const fn request_was_sent(&mut self) {
        self.clear_fault_wanted = false;
    }

    /// Takes an operator's wish.
    pub fn operate(&mut self, wish: Operator) {
        match wish {
            Operator::Enable => self.enable_wanted = true,
            Operator::Stop if self.state == State::Running => {
                self.enable_wanted = false;
                self.enter(State::Stopping);
            }
            // Already braking; the wish to move again, if there was one, is withdrawn.
            Operator::Stop if self.state == State::Stopping => self.enable_wanted = false,
            Operator::Stop => self.let_go(),
            Operator::EmergencyStop => self.latch(Reason::OperatorStop, None),
            Operator::Reset => {
                self.enable_wanted = false;
                self.clear_fault_wanted = true;
                if matches!(self.state, State::Tripped(_)) {
                    self.enter(State::Stopped);
                }
            }
        }
    }

    /// No torque from now on, and no trip either.
    pub fn let_go(&mut self) {
        self.enable_wanted = false;
        if self.state.is_armed() {
            self.enter(State::Stopped);
        }
    }

    /// Something is wrong: an armed stack trips. A trip is latched, and its
    /// reason is the first.
    pub fn trip(&mut self, reason: Reason, culprit: Option<Wheel>) {
        if self.state.is_armed() {
            self.latch(reason, culprit);
        }
    }

    /// Another period begins.
    pub fn begin_period(&mut self) {
        self.periods_in_state = self.periods_in_state.saturating_add(1);
        let overdue = match self.state {
            State::Enabling => Some((Reason::EnableTimeout, self.limits.enable_timeout_s)),
            State::Stopping => Some((Reason::StopTimeout, self.limits.stop_timeout_s)),
            _ => None,
        };
        let overdue = overdue.filter(|&(_, timeout_s)| self.watch.has_lasted(self.periods_in_state, timeout_s));
        let found = self.watch.begin_period();
        self.take(found.or(overdue.map(|(reason, _)| (reason, None))));
    }

    /// A drive gave a sign of life.
    pub fn take_heartbeat(&mut self, wheel: Wheel) {
        self.watch.heartbeat(wheel);
    }

    /// The period's feedback has come from both drives, or not in time; then
    /// `missing` is the wheel whose alone is missing.
    pub fn take_feedback(&mut self, has_come: bool, missing: Option<Wheel>) {
        let found = self.watch.feedback(has_come);
        self.take(found.map(|(reason, _)| (reason, missing)));
    }

    /// A drive's frame was damaged.
    pub fn take_damaged_frame(&mut self) {
        let found = self.watch.damaged_frame();
        self.take(found);
    }

    /// A drive's state means this.
    pub fn take_drive_state(&mut self, wheel: Wheel, means: DriveState) {
        match means {
            DriveState::Fault => self.trip(Reason::DriveFault, Some(wheel)),
            DriveState::Ready | DriveState::Boot if self.state.lets_torque_flow() => {
                self.trip(Reason::DriveDisabled, Some(wheel));
            }
            _ => {}
        }
    }

    /// The wheels have moved by so much, rad, in so many seconds each.
    pub fn take_motion(&mut self, moved_rad: Wheels<f64>, span_s: Wheels<f64>) {
        let found = self.watch.motion(moved_rad, span_s);
        self.take(found);
    }

    /// The wheels are so far from their targets, rad.
    pub fn take_error(&mut self, error_rad: Wheels<f64>) {
        self.take(self.watch.error(error_rad));
    }

    /// The transitions that wait for the operator and for drives that answer:
    /// `all_mean` tells whether both drives' states mean this, `are_at_rest`
    /// whether the wheels have been brought to rest.
    pub fn step(&mut self, all_mean: impl Fn(DriveState) -> bool, are_at_rest: bool) {
        match self.state {
            State::Boot => self.enter(State::Stopped),
            State::Stopped if self.enable_wanted && all_mean(DriveState::Ready) => {
                self.watch.arm();
                self.enter(State::Enabling);
            }
            State::Enabling if all_mean(DriveState::Enabled) => self.enter(State::Running),
            State::Stopping if are_at_rest => self.enter(State::Stopped),
            _ => {}
        }
    }

    /// Whether a wheel at this speed, rad/s, counts as at rest.
    pub fn is_at_rest(&self, speed_rad_s: f64) -> bool {
        speed_rad_s.abs() <= self.limits.rest_speed_rad_s
    }

    /// The torque that may leave, N m, where `wanted_nm` was asked for: zero
    /// unless the state lets torque flow. A torque that is no number trips.
    pub fn pass(&mut self, wanted_nm: Wheels<f64>) -> Wheels<f64> {
        let found = self.watch.torque(wanted_nm);
        self.take(found);
        self.gate.pass(wanted_nm, self.state.lets_torque_flow())
    }

    fn take(&mut self, found: Finding) {
        if let Some((reason, culprit)) = found {
            self.trip(reason, culprit);
        }
    }

    fn latch(&mut self, reason: Reason, culprit: Option<Wheel>) {
        self.enable_wanted = false;
        if !matches!(self.state, State::Tripped(_)) {
            self.enter(State::Tripped(reason));
            self.culprit = culprit;
        }
    }

    fn enter(&mut self, state: State) {
        self.state = state;
        self.culprit = None;
        self.periods_in_state = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.01;

    fn chain() -> Chain {
        let limits = Limits { enable_timeout_s: 0.05, stop_timeout_s: 0.03, ..Limits::for_tests() };
        Chain::new(limits, PERIOD_S)
    }

    fn enabling() -> Chain {
        let mut chain = chain();
        chain.step(|_| false, false);
        chain.operate(Operator::Enable);
        chain.step(|means| means == DriveState::Ready, false);
        assert_eq!(chain.state(), State::Enabling);
        chain
    }

    fn running() -> Chain {
        let mut chain = enabling();
        chain.step(|means| means == DriveState::Enabled, false);
        assert_eq!(chain.state(), State::Running);
        chain
    }

    fn stopping() -> Chain {
        let mut chain = running();
        chain.operate(Operator::Stop);
        assert_eq!(chain.state(), State::Stopping);
        chain
    }

    /// One in every state.
    fn everywhere() -> [Chain; 6] {
        let mut stopped = chain();
        stopped.step(|_| false, false);
        let mut tripped = running();
        tripped.trip(Reason::DriveFault, Some(Wheel::Left));
        [chain(), stopped, enabling(), running(), stopping(), tripped]
    }

    /// Periods until it trips.
    fn patience(mut chain: Chain) -> (usize, State) {
        let periods = (1..100)
            .take_while(|_| {
                Wheel::BOTH.into_iter().for_each(|wheel| chain.take_heartbeat(wheel));
                chain.begin_period();
                chain.state().is_armed()
            })
            .count();
        (periods + 1, chain.state())
    }

    #[test]
    fn it_runs_once_the_operator_and_both_drives_want_to() {
        let mut chain = chain();
        assert_eq!((chain.state(), chain.request()), (State::Boot, Request::Disable));
        chain.step(|_| true, true);
        chain.step(|_| true, true);
        assert_eq!((chain.state(), chain.request()), (State::Stopped, Request::Disable));
        chain.operate(Operator::Enable);
        chain.step(|means| means != DriveState::Ready, true);
        assert_eq!(chain.state(), State::Stopped);
        chain.step(|means| means == DriveState::Ready, true);
        assert_eq!((chain.state(), chain.request()), (State::Enabling, Request::Enable));
        chain.step(|means| means != DriveState::Enabled, true);
        assert_eq!(chain.state(), State::Enabling);
        chain.step(|means| means == DriveState::Enabled, true);
        assert_eq!((chain.state(), chain.request()), (State::Running, Request::Enable));
    }

    #[test]
    fn a_stop_brakes_to_rest_and_then_lets_go() {
        let mut chain = stopping();
        assert_eq!((chain.request(), chain.pass(Wheels::both(1.0))), (Request::Enable, Wheels::both(1.0)));
        chain.step(|_| true, false);
        chain.operate(Operator::Stop);
        assert_eq!(chain.state(), State::Stopping, "to ask again changes nothing");
        chain.step(|_| true, true);
        assert_eq!((chain.state(), chain.request()), (State::Stopped, Request::Disable));
        assert_eq!(chain.pass(Wheels::both(1.0)), Wheels::default());
        chain.step(|_| true, true);
        assert_eq!(chain.state(), State::Stopped, "the wish to move is over");
    }

    #[test]
    fn a_stop_withdraws_the_wish_to_move_in_every_state() {
        for mut chain in everywhere() {
            chain.operate(Operator::Enable);
            chain.operate(Operator::Stop);
            chain.operate(Operator::Stop);
            (0..5).for_each(|_| chain.step(|_| true, true));
            assert!(!chain.state().is_armed(), "{:?}", chain.state());
        }
    }

    #[test]
    fn who_stops_while_drives_enable_lets_go_at_once() {
        let mut chain = enabling();
        chain.operate(Operator::Stop);
        assert_eq!(chain.state(), State::Stopped);
    }

    #[test]
    fn an_emergency_stop_trips_from_every_state() {
        for mut chain in everywhere() {
            let was_tripped = matches!(chain.state(), State::Tripped(_));
            chain.operate(Operator::Enable);
            chain.operate(Operator::EmergencyStop);
            let reason = if was_tripped { Reason::DriveFault } else { Reason::OperatorStop };
            assert_eq!(chain.state(), State::Tripped(reason), "the first reason stays");
            assert_eq!((chain.pass(Wheels::both(1.0)), chain.request()), (Wheels::default(), Request::Disable));
        }
    }

    #[test]
    fn only_an_armed_stack_trips() {
        for mut chain in everywhere() {
            let before = chain.state();
            chain.trip(Reason::BusLost, Some(Wheel::Right));
            let expected = if before.is_armed() { State::Tripped(Reason::BusLost) } else { before };
            assert_eq!(chain.state(), expected);
        }
    }

    #[test]
    fn a_trip_names_its_culprit_until_it_is_reset() {
        let mut chain = running();
        chain.trip(Reason::BusLost, Some(Wheel::Left));
        assert_eq!(chain.culprit(), Some(Wheel::Left));
        chain.operate(Operator::Reset);
        assert_eq!(chain.culprit(), None);
    }

    #[test]
    fn a_reset_leads_to_stopped_asks_once_for_faults_to_be_cleared_and_never_leads_to_motion() {
        let mut chain = running();
        chain.trip(Reason::DriveFault, None);
        chain.operate(Operator::Enable);
        (0..5).for_each(|_| chain.step(|_| true, true));
        assert_eq!(chain.state(), State::Tripped(Reason::DriveFault), "enable alone does not leave a trip");
        chain.operate(Operator::Reset);
        assert_eq!((chain.state(), chain.request()), (State::Stopped, Request::ClearFault));
        chain.request_was_sent();
        assert_eq!(chain.request(), Request::Disable);
        (0..5).for_each(|_| chain.step(|_| true, true));
        assert_eq!((chain.state(), chain.pass(Wheels::both(1.0))), (State::Stopped, Wheels::default()));
    }

    #[test]
    fn a_reset_changes_no_state_but_a_trip() {
        for mut chain in everywhere() {
            let before = chain.state();
            chain.operate(Operator::Reset);
            let expected = if matches!(before, State::Tripped(_)) { State::Stopped } else { before };
            assert_eq!(chain.state(), expected);
        }
    }

    #[test]
    fn letting_go_leaves_motion_at_once_and_trips_as_they_are() {
        for mut chain in everywhere() {
            let before = chain.state();
            chain.operate(Operator::Enable);
            chain.let_go();
            let expected = if before.is_armed() { State::Stopped } else { before };
            assert_eq!(chain.state(), expected);
            (0..5).for_each(|_| chain.step(|_| true, true));
            assert!(!chain.state().is_armed());
        }
    }

    #[test]
    fn drives_must_enable_and_wheels_must_rest_in_time() {
        assert_eq!(patience(enabling()), (5, State::Tripped(Reason::EnableTimeout)));
        assert_eq!(patience(stopping()), (3, State::Tripped(Reason::StopTimeout)));
        assert_eq!(patience(running()), (100, State::Running));
    }

    #[test]
    fn every_watch_trips() {
        let found = |act: &dyn Fn(&mut Chain)| {
            let mut chain = running();
            act(&mut chain);
            (chain.state(), chain.culprit())
        };
        let tripped = |reason, culprit| (State::Tripped(reason), culprit);
        let limits = *chain().limits();
        let stale = |chain: &mut Chain| (0..2).for_each(|_| chain.take_feedback(false, Some(Wheel::Left)));
        assert_eq!(found(&stale), tripped(Reason::StaleFeedback, Some(Wheel::Left)));
        let answered = |chain: &mut Chain| {
            for has_come in [false, true, false] {
                chain.take_feedback(has_come, None);
            }
        };
        assert_eq!(found(&answered), (State::Running, None));
        let damaged = |chain: &mut Chain| (0..limits.damaged_frames).for_each(|_| chain.take_damaged_frame());
        assert_eq!(found(&damaged), tripped(Reason::DamagedFrames, None));
        let jumping = |chain: &mut Chain| {
            chain.take_motion(Wheels::default(), Wheels::both(PERIOD_S));
            chain.take_motion(Wheels { right: 0.0, left: 1.1 * limits.encoder_jump_rad }, Wheels::both(PERIOD_S));
        };
        assert_eq!(found(&jumping), tripped(Reason::EncoderJump, Some(Wheel::Left)));
        let far = |chain: &mut Chain| chain.take_error(Wheels { right: 0.0, left: 1.0 });
        assert_eq!(found(&far), (State::Running, None), "not watched unless it is given");
        let mut watched = running();
        watched.watch = Watch::new(Limits { following_error_rad: 0.9, ..limits }, PERIOD_S);
        far(&mut watched);
        assert_eq!((watched.state(), watched.culprit()), tripped(Reason::FollowingError, Some(Wheel::Left)));
        let silent = |chain: &mut Chain| (0..60).for_each(|_| chain.begin_period());
        assert_eq!(found(&silent), tripped(Reason::HeartbeatLost, Some(Wheel::Right)));
    }

    #[test]
    fn a_drive_that_fails_or_is_not_enabled_trips_a_stack_in_motion() {
        for chain in everywhere() {
            for (means, needs_motion) in [
                (DriveState::Fault, false),
                (DriveState::Ready, true),
                (DriveState::Boot, true),
                (DriveState::Enabled, true),
            ] {
                let mut chain = chain.clone();
                let before = chain.state();
                chain.take_drive_state(Wheel::Right, means);
                let expected = match means {
                    DriveState::Fault if before.is_armed() => State::Tripped(Reason::DriveFault),
                    DriveState::Ready | DriveState::Boot if needs_motion && before.lets_torque_flow() => {
                        State::Tripped(Reason::DriveDisabled)
                    }
                    _ => before,
                };
                assert_eq!(chain.state(), expected);
            }
        }
    }

    #[test]
    fn a_torque_that_is_no_number_trips_and_none_leaves() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut chain = running();
            assert_eq!(chain.pass(Wheels { right: 1.0, left: bad }), Wheels::default());
            assert_eq!(chain.state(), State::Tripped(Reason::NotFinite));
            assert_eq!(chain.pass(Wheels::both(1.0)), Wheels::default());
        }
    }

    #[test]
    fn nothing_passes_unless_running_or_braking() {
        for mut chain in everywhere() {
            let flows = matches!(chain.state(), State::Running | State::Stopping);
            assert_eq!(chain.pass(Wheels::both(1.0)) == Wheels::both(1.0), flows);
        }
    }

    #[test]
    fn torque_changes_by_its_rate_in_a_period() {
        let limits = Limits { torque_rate_nm_per_s: 1000.0, ..Limits::for_tests() };
        let mut chain = Chain { limits, gate: Chain::new(limits, PERIOD_S).gate, ..running() };
        assert_eq!(chain.pass(Wheels::both(50.0)), Wheels::both(10.0));
    }

    #[test]
    fn a_slow_wheel_counts_as_at_rest() {
        let rest_rad_s = chain().limits().rest_speed_rad_s;
        for way in [1.0, -1.0] {
            assert!(chain().is_at_rest(way * rest_rad_s) && !chain().is_at_rest(way * 1.01 * rest_rad_s));
        }
    }
}
