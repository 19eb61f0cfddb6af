//! A simulated motor drive: what a torque-mode drive with an encoder does
//! between its bus and its motor. What it answers to which word is its
//! profile's; what is here is the same for all.

mod trouble;

use canloop::schema::{
    Acts, Applied, Command, Conversation, DriveState, FaultCode, Feedback, Heartbeat, Patience, Profile, StateId,
    Watchdog, WordId,
};

use crate::encoder::Encoder;
use crate::plant::Torque;

pub use trouble::Trouble;

/// What a drive is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveSpec {
    /// Position sensor, at the motor shaft.
    pub encoder: Encoder,
    /// Torque limit at the wheel, N m.
    pub torque_limit_nm: f64,
    /// Smallest step of torque, N m: that of the command signal.
    pub torque_step_nm: f64,
    /// Time constant of the current loop, s; 0 is none.
    pub current_loop_s: f64,
}

/// A motor drive and its state.
#[derive(Clone, Debug)]
pub struct Drive {
    spec: DriveSpec,
    conversation: Conversation,
    watchdog: Option<Watchdog>,
    acts: Acts,
    applied: Applied,
    trouble: Trouble,
    memory: Memory,
}

/// What a drive forgets when it is switched off.
#[derive(Clone, Copy, Debug)]
struct Memory {
    state: StateId,
    /// For how long it has been in that, s.
    in_state_s: f64,
    fault: FaultCode,
    /// The command that the next SYNC puts into force, if one has come since
    /// the last.
    pending: Option<Command>,
    /// Counter of the last valid command: the same one twice is a stale
    /// repetition and does not feed the watchdog.
    last_counter: Option<u8>,
    /// What the last command said.
    last_word: Option<WordId>,
    /// The mode of operation; 0 before any was asked for.
    mode: f64,
    periods_without_command: u32,
    without_command_s: f64,
    /// Torque in force, with the current loop's lag.
    torque: Torque,
    /// Mean torque since the period began, N m, and for how long that is, s.
    mean: (f64, f64),
    /// Mean torque of the period that has ended, N m.
    period_mean_nm: f64,
    /// Torque when time passed last, N m.
    last_nm: f64,
    /// A fault raised since it was last asked about.
    raised: Option<FaultCode>,
}

impl Memory {
    const BLANK: Self = Self {
        state: Conversation::FIRST,
        in_state_s: 0.0,
        fault: FaultCode::None,
        pending: None,
        last_counter: None,
        last_word: None,
        mode: 0.0,
        periods_without_command: 0,
        without_command_s: 0.0,
        torque: Torque::constant(0.0),
        mean: (0.0, 0.0),
        period_mean_nm: 0.0,
        last_nm: 0.0,
        raised: None,
    };
}

impl Drive {
    /// A drive that has just been switched on.
    pub fn new(spec: DriveSpec, profile: &Profile) -> Self {
        Self {
            spec,
            conversation: profile.conversation.clone(),
            watchdog: profile.watchdog,
            acts: profile.acts,
            applied: profile.applied,
            trouble: Trouble::NONE,
            memory: Memory::BLANK,
        }
    }

    /// Switches it off and on again.
    pub fn power_cycle(&mut self) {
        self.memory = Memory::BLANK;
    }

    /// What is wrong with it.
    pub const fn trouble(&self) -> &Trouble {
        &self.trouble
    }

    /// Something else is wrong with it from now on, or nothing any more.
    pub fn get_into(&mut self, trouble: Trouble) {
        if !trouble.is_powered {
            self.power_cycle();
        }
        self.trouble = trouble;
    }

    /// The counts of a sound encoder in this angle of the wheel.
    pub fn counts_in(&self, angle_rad: f64) -> i64 {
        self.spec.encoder.counts(angle_rad)
    }

    /// What its encoder counts while the wheel has turned by `angle_rad`.
    pub fn counts(&self, angle_rad: f64) -> i64 {
        self.trouble.counts(self.counts_in(angle_rad))
    }

    /// Takes a valid command: into force at once, or with the next SYNC.
    pub fn take_command(&mut self, command: Command, has_counter: bool) {
        if !self.trouble.is_powered || has_counter && self.memory.last_counter == Some(command.counter) {
            return;
        }
        self.memory.last_counter = Some(command.counter);
        self.memory.periods_without_command = 0;
        self.memory.without_command_s = 0.0;
        self.memory.pending = Some(command);
        if self.acts == Acts::OnArrival {
            self.step_state();
            self.put_into_force();
        }
    }

    /// Takes the mode of operation that a command asks for. One without torque
    /// is entered as well: its commands ask for none.
    pub fn take_mode(&mut self, mode: f64) {
        self.memory.mode = mode;
    }

    /// Takes a word that came by itself.
    pub fn hear(&mut self, word: WordId) {
        let next = self.conversation.hears(self.memory.state, word);
        if let Some(next) = next.filter(|_| self.trouble.is_powered) {
            self.enter_by(word, next);
        }
    }

    /// Torque at the wheel over the time that now runs.
    pub fn torque(&self) -> Torque {
        self.memory.torque
    }

    /// Lets `span_s` pass, under the torque in force.
    pub fn elapse(&mut self, span_s: f64) {
        if span_s <= 0.0 || !self.trouble.is_powered {
            return;
        }
        let (mean_nm, torque) = self.memory.torque.elapse(span_s);
        self.memory.torque = torque;
        self.memory.last_nm = torque.now_nm();
        let (so_far_nm, so_far_s) = self.memory.mean;
        let whole_s = so_far_s + span_s;
        let joined_nm = if so_far_s > 0.0 { (so_far_nm * so_far_s + mean_nm * span_s) / whole_s } else { mean_nm };
        self.memory.mean = (joined_nm, whole_s);
        self.memory.in_state_s += span_s;
        self.memory.without_command_s += span_s;
        self.step_by_time();
        if let Some(Watchdog { patience: Patience::Seconds(most_s), .. }) = self.watchdog {
            self.bite_if(self.memory.without_command_s > most_s);
        }
    }

    /// The period ends and another begins.
    pub fn begin_period(&mut self) {
        self.memory.period_mean_nm = self.memory.mean.0;
        self.memory.mean = (0.0, 0.0);
    }

    /// Mean torque of the period that has ended, N m.
    pub const fn period_mean_nm(&self) -> f64 {
        self.memory.period_mean_nm
    }

    /// SYNC puts the waiting command into force.
    pub fn sync(&mut self) {
        if self.acts == Acts::AtSync && self.trouble.is_powered {
            self.step_state();
            self.count_period();
            self.put_into_force();
        }
    }

    /// A period passed in which no SYNC came: what is in force stays in force,
    /// until the watchdog has had enough.
    pub fn go_without_sync(&mut self) {
        self.count_period();
    }

    /// What it reports of a motor whose wheel has turned by `angle_rad` and
    /// turns at `speed_rad_s`; `position` makes of an encoder count what the
    /// report carries.
    pub fn feedback(&self, angle_rad: f64, speed_rad_s: f64, position: impl Fn(i64) -> f64) -> Feedback {
        self.trouble.reported(Feedback {
            part: 0,
            position: Some(position(self.counts(angle_rad))),
            speed_rad_s: Some(speed_rad_s),
            torque_applied_nm: Some(if self.applied == Applied::TheMean {
                self.memory.period_mean_nm
            } else {
                self.memory.last_nm
            }),
            state: Some(self.memory.state),
            fault: Some(self.memory.fault),
            mode: Some(self.memory.mode),
            counter: None,
        })
    }

    /// A sign of life.
    pub fn heartbeat(&self) -> Heartbeat {
        Heartbeat { state: Some(self.memory.state), fault: self.memory.fault }
    }

    /// What its state means.
    pub fn state(&self) -> DriveState {
        self.conversation.meaning(self.memory.state)
    }

    /// What its profile calls that state.
    pub fn state_name(&self) -> &str {
        self.conversation.name(self.memory.state)
    }

    /// Whether it gives no feedback.
    pub fn is_silent(&self) -> bool {
        self.trouble.is_mute || !self.trouble.is_powered || self.conversation.is_silent(self.memory.state)
    }

    /// A fault that was raised since the last call.
    pub fn take_raised_fault(&mut self) -> Option<FaultCode> {
        self.memory.raised.take()
    }

    /// Something in it fails.
    pub fn raise(&mut self, fault: FaultCode) {
        let state = self.conversation.state_meaning(DriveState::Fault);
        if let Some(state) = state.filter(|_| self.trouble.is_powered) {
            self.fail(state, fault);
        }
    }

    fn enter_by(&mut self, word: WordId, state: StateId) {
        match self.conversation.raises(word) {
            FaultCode::None => self.enter(state),
            fault => self.fail(state, fault),
        }
    }

    fn fail(&mut self, state: StateId, fault: FaultCode) {
        self.enter(state);
        self.memory.fault = fault;
        self.memory.raised = Some(fault).filter(|fault| *fault != FaultCode::None);
    }

    /// A power stage that is off lets go at once.
    fn enter(&mut self, state: StateId) {
        self.memory.state = state;
        self.memory.in_state_s = 0.0;
        let means = self.state();
        if means != DriveState::Fault {
            self.memory.fault = FaultCode::None;
        }
        if means != DriveState::Enabled {
            self.memory.torque = Torque::constant(0.0);
        }
    }

    /// Time leads somewhere, or else the waiting command does.
    fn step_state(&mut self) {
        if self.step_by_time() {
            return;
        }
        let Some(command) = self.memory.pending else { return };
        let is_new = |word: &WordId| !self.conversation.is_edge(*word) || self.memory.last_word != Some(*word);
        let heard = command
            .word
            .filter(is_new)
            .and_then(|word| Some((word, self.conversation.hears(self.memory.state, word)?)));
        self.memory.last_word = command.word;
        if let Some((word, next)) = heard {
            self.enter_by(word, next);
        } else if let Some(next) = self.conversation.commanded(self.memory.state) {
            self.enter(next);
        }
    }

    fn step_by_time(&mut self) -> bool {
        let due = self.conversation.after(self.memory.state).filter(|(after_s, _)| self.memory.in_state_s >= *after_s);
        if let Some((_, next)) = due {
            self.enter(next);
        }
        due.is_some()
    }

    fn count_period(&mut self) {
        if self.state() != DriveState::Enabled {
            return;
        }
        self.memory.periods_without_command += 1;
        if let Some(Watchdog { patience: Patience::Periods(most), .. }) = self.watchdog {
            self.bite_if(self.memory.periods_without_command > most);
        }
    }

    fn bite_if(&mut self, has_waited: bool) {
        if let Some(watchdog) = self.watchdog.filter(|_| has_waited && self.state() == DriveState::Enabled) {
            self.fail(watchdog.leads_to, watchdog.fault);
        }
    }

    /// The current loop turns the old torque into the new one, with its lag.
    fn put_into_force(&mut self) {
        let Some(command) = self.memory.pending.take().filter(|_| self.state() == DriveState::Enabled) else { return };
        let now_nm = self.memory.torque.now_nm();
        let wanted_nm = self.quantised(command.torque_nm);
        self.memory.torque = if self.spec.current_loop_s > 0.0 {
            Torque { final_nm: wanted_nm, excess_nm: now_nm - wanted_nm, time_constant_s: self.spec.current_loop_s }
        } else {
            Torque::constant(wanted_nm)
        };
    }

    fn quantised(&self, torque_nm: f64) -> f64 {
        let DriveSpec { torque_step_nm, .. } = self.spec;
        let torque_limit_nm = self.spec.torque_limit_nm.min(self.trouble.torque_limit_nm);
        let in_steps_nm =
            if torque_step_nm > 0.0 { (torque_nm / torque_step_nm).round() * torque_step_nm } else { torque_nm };
        in_steps_nm.clamp(-torque_limit_nm, torque_limit_nm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.005;

    /// A drive on a SYNC of its own.
    struct Rig {
        drive: Drive,
        profile: Profile,
    }

    impl Rig {
        fn new() -> Self {
            let profile = Profile::builtin("wheel_drive").expect("it is built in");
            let spec = DriveSpec {
                encoder: Encoder { counts_per_turn: 65536, gear_ratio: 3.0 },
                torque_limit_nm: 90.0,
                torque_step_nm: 0.005,
                current_loop_s: 0.001,
            };
            Self { drive: Drive::new(spec, &profile), profile }
        }

        fn enabled() -> Self {
            let mut rig = Self::new();
            rig.sync(0.0);
            rig.command(0, 0.0, "enable");
            rig.sync(PERIOD_S);
            assert_eq!(rig.drive.state(), DriveState::Enabled);
            rig
        }

        fn command(&mut self, counter: u8, torque_nm: f64, word: &str) {
            let word = self.profile.conversation.word(word);
            self.drive.take_command(Command { torque_nm, word, counter }, true);
        }

        fn sync(&mut self, span_s: f64) -> Feedback {
            self.drive.elapse(span_s);
            self.drive.begin_period();
            self.drive.sync();
            self.drive.feedback(0.0, 0.0, |count| count as f64)
        }

        fn torque_at_nm(&self, t_s: f64) -> f64 {
            self.drive.torque().at(t_s)
        }
    }

    #[test]
    fn a_command_acts_from_the_next_sync_on_and_not_before() {
        let mut rig = Rig::enabled();
        rig.command(1, 10.0, "enable");
        assert_eq!(rig.torque_at_nm(PERIOD_S), 0.0);
        rig.sync(PERIOD_S);
        assert!((rig.torque_at_nm(PERIOD_S) - 10.0).abs() < 0.1);
    }

    #[test]
    fn the_torque_reported_is_the_mean_of_what_the_current_loop_applied() {
        let mut rig = Rig::enabled();
        rig.command(1, 10.0, "enable");
        rig.sync(PERIOD_S);
        let expected = 10.0 * (1.0 - 0.2 * (1.0 - libm::exp(-5.0)));
        let reported = rig.sync(PERIOD_S).torque_applied_nm.expect("it is always known");
        assert!((reported - expected).abs() < 1e-9);
    }

    #[test]
    fn no_torque_flows_unless_enabled() {
        let mut rig = Rig::new();
        for counter in 0..5 {
            rig.command(counter, 10.0, "disable");
            rig.sync(PERIOD_S);
            assert_eq!(rig.torque_at_nm(0.0), 0.0);
        }
    }

    #[test]
    fn the_watchdog_faults_a_drive_whose_commands_stop_and_clearing_does_not_enable() {
        let mut rig = Rig::enabled();
        rig.command(1, 10.0, "enable");
        let states: Vec<_> = (0..6)
            .map(|_| {
                rig.sync(PERIOD_S);
                rig.drive.state()
            })
            .collect();
        assert_eq!(states.iter().filter(|&&state| state == DriveState::Enabled).count(), 4);
        assert_eq!(rig.torque_at_nm(0.0), 0.0);
        assert_eq!(rig.drive.take_raised_fault(), Some(FaultCode::CommandTimeout));
        rig.command(2, 10.0, "enable");
        rig.sync(PERIOD_S);
        assert_eq!(rig.drive.state(), DriveState::Fault);
        rig.command(3, 10.0, "clear_fault");
        rig.sync(PERIOD_S);
        assert_eq!(rig.drive.state(), DriveState::Ready);
    }

    #[test]
    fn a_repeated_command_does_not_feed_the_watchdog() {
        let mut rig = Rig::enabled();
        for _ in 0..10 {
            rig.command(1, 10.0, "enable");
            rig.sync(PERIOD_S);
        }
        assert_eq!(rig.drive.heartbeat().fault, FaultCode::CommandTimeout);
    }

    #[test]
    fn torque_is_limited_and_quantised() {
        let mut rig = Rig::enabled();
        for (counter, wanted, expected) in [(1, 1e3, 90.0), (2, -1e3, -90.0), (3, 1.0024, 1.0), (4, 1.0026, 1.005)] {
            rig.command(counter, wanted, "enable");
            rig.sync(PERIOD_S);
            assert!((rig.drive.torque().final_nm - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn a_limit_between_two_steps_of_torque_is_kept() {
        let mut rig = Rig::enabled();
        rig.drive.spec.torque_step_nm = 0.7;
        rig.command(1, 90.0, "enable");
        rig.sync(PERIOD_S);
        assert_eq!(rig.drive.torque().final_nm, 90.0);
    }

    #[test]
    fn a_drive_that_was_switched_off_begins_anew() {
        let mut rig = Rig::enabled();
        rig.command(1, 10.0, "enable");
        rig.sync(PERIOD_S);
        rig.drive.power_cycle();
        assert_eq!((rig.drive.state(), rig.torque_at_nm(0.0)), (DriveState::Boot, 0.0));
    }
}
