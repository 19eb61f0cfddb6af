//! A simulated motor drive: what a torque-mode drive with an encoder does
//! between its bus and its motor.

use canloop::schema::{Command, DriveState, FaultCode, Feedback, Heartbeat, Request};

use crate::encoder::Encoder;
use crate::plant::Torque;

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
    /// Periods without a valid command after which torque goes to zero.
    pub command_timeout_periods: u32,
}

/// A motor drive and its state.
#[derive(Clone, Debug)]
pub struct Drive {
    spec: DriveSpec,
    state: DriveState,
    fault: FaultCode,
    /// The command that the next SYNC puts into force, if one has come since
    /// the last.
    pending: Option<Command>,
    /// Counter of the last valid command: the same one twice is a stale
    /// repetition and does not feed the watchdog.
    last_counter: Option<u8>,
    periods_without_command: u32,
    /// Torque in force, with the current loop's lag.
    torque: Torque,
    /// A fault raised since it was last asked about.
    raised: Option<FaultCode>,
}

impl Drive {
    /// A drive that has just been switched on.
    pub fn new(spec: DriveSpec) -> Self {
        Self {
            spec,
            state: DriveState::Boot,
            fault: FaultCode::None,
            pending: None,
            last_counter: None,
            periods_without_command: 0,
            torque: Torque::constant(0.0),
            raised: None,
        }
    }

    /// Takes a valid command; it waits for the next SYNC.
    pub fn take_command(&mut self, command: Command) {
        if self.last_counter != Some(command.counter) {
            self.last_counter = Some(command.counter);
            self.periods_without_command = 0;
            self.pending = Some(command);
        }
    }

    /// Torque at the wheel over the period that now runs.
    pub fn torque(&self) -> Torque {
        self.torque
    }

    /// SYNC, `period_s` after the one before (0 for the first): latches the
    /// encoder of a motor whose wheel has turned by `angle_rad`, reports the
    /// period that has ended in a feedback numbered `counter`, and puts the
    /// waiting command into force.
    pub fn sync(&mut self, period_s: f64, angle_rad: f64, counter: u8) -> Feedback {
        let (torque_applied_nm, torque) = self.torque.elapse(period_s);
        self.torque = torque;
        self.step_state();
        self.watch_commands();
        self.put_into_force();
        Feedback { position_counts: self.spec.encoder.counts(angle_rad), torque_applied_nm, state: self.state, counter }
    }

    /// A period of `period_s` in which no SYNC came: what is in force stays in
    /// force, until the watchdog has had enough.
    pub fn go_without_sync(&mut self, period_s: f64) {
        self.torque = self.torque.elapse(period_s).1;
        self.watch_commands();
        if self.state != DriveState::Enabled {
            self.torque = Torque::constant(0.0);
        }
    }

    /// A sign of life.
    pub fn heartbeat(&self) -> Heartbeat {
        Heartbeat { state: self.state, fault: self.fault }
    }

    /// A fault that was raised since the last call.
    pub fn take_raised_fault(&mut self) -> Option<FaultCode> {
        self.raised.take()
    }

    fn step_state(&mut self) {
        let request = self.pending.map(|command| command.request);
        self.state = match (self.state, request) {
            (DriveState::Boot, _) => DriveState::Ready,
            (DriveState::Ready, Some(Request::Enable)) => DriveState::Enabled,
            (DriveState::Enabled, Some(Request::Disable | Request::ClearFault)) => DriveState::Ready,
            (DriveState::Fault, Some(Request::ClearFault)) => {
                self.fault = FaultCode::None;
                DriveState::Ready
            }
            (state, _) => state,
        };
    }

    fn watch_commands(&mut self) {
        if self.state != DriveState::Enabled {
            return;
        }
        self.periods_without_command += 1;
        if self.periods_without_command > self.spec.command_timeout_periods {
            self.state = DriveState::Fault;
            self.fault = FaultCode::CommandTimeout;
            self.raised = Some(self.fault);
        }
    }

    /// The current loop turns the old torque into the new one, with its lag;
    /// a power stage that is off lets go at once.
    fn put_into_force(&mut self) {
        let command = self.pending.take();
        if self.state != DriveState::Enabled {
            self.torque = Torque::constant(0.0);
            return;
        }
        let Some(command) = command else { return };
        let now_nm = self.torque.at(0.0);
        let wanted_nm = self.quantised(command.torque_nm);
        self.torque = if self.spec.current_loop_s > 0.0 {
            Torque { final_nm: wanted_nm, excess_nm: now_nm - wanted_nm, time_constant_s: self.spec.current_loop_s }
        } else {
            Torque::constant(wanted_nm)
        };
    }

    fn quantised(&self, torque_nm: f64) -> f64 {
        let step_nm = self.spec.torque_step_nm;
        let limited = torque_nm.clamp(-self.spec.torque_limit_nm, self.spec.torque_limit_nm);
        if step_nm > 0.0 { (limited / step_nm).round() * step_nm } else { limited }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.005;

    fn drive() -> Drive {
        Drive::new(DriveSpec {
            encoder: Encoder { counts_per_turn: 65536, gear_ratio: 3.0 },
            torque_limit_nm: 90.0,
            torque_step_nm: 0.005,
            current_loop_s: 0.001,
            command_timeout_periods: 4,
        })
    }

    fn command(counter: u8, torque_nm: f64, request: Request) -> Command {
        Command { torque_nm, request, counter }
    }

    fn enabled() -> Drive {
        let mut drive = drive();
        drive.sync(0.0, 0.0, 0);
        drive.take_command(command(0, 0.0, Request::Enable));
        assert_eq!(drive.sync(PERIOD_S, 0.0, 0).state, DriveState::Enabled);
        drive
    }

    #[test]
    fn a_command_acts_from_the_next_sync_on_and_not_before() {
        let mut drive = enabled();
        drive.take_command(command(1, 10.0, Request::Enable));
        assert_eq!(drive.torque().at(PERIOD_S), 0.0);
        drive.sync(PERIOD_S, 0.0, 0);
        assert!((drive.torque().at(PERIOD_S) - 10.0).abs() < 0.1);
    }

    #[test]
    fn the_torque_reported_is_the_mean_of_what_the_current_loop_applied() {
        let mut drive = enabled();
        drive.take_command(command(1, 10.0, Request::Enable));
        drive.sync(PERIOD_S, 0.0, 0);
        let expected = 10.0 * (1.0 - 0.2 * (1.0 - libm::exp(-5.0)));
        assert!((drive.sync(PERIOD_S, 0.0, 0).torque_applied_nm - expected).abs() < 1e-9);
    }

    #[test]
    fn no_torque_flows_unless_enabled() {
        let mut drive = drive();
        for counter in 0..5 {
            drive.take_command(command(counter, 10.0, Request::Disable));
            drive.sync(PERIOD_S, 0.0, 0);
            assert_eq!(drive.torque().at(0.0), 0.0);
        }
    }

    #[test]
    fn the_watchdog_faults_a_drive_whose_commands_stop_and_clearing_does_not_enable() {
        let mut drive = enabled();
        drive.take_command(command(1, 10.0, Request::Enable));
        let states: Vec<_> = (0..6).map(|_| drive.sync(PERIOD_S, 0.0, 0).state).collect();
        assert_eq!(states.iter().filter(|&&state| state == DriveState::Enabled).count(), 4);
        assert_eq!(drive.torque().at(0.0), 0.0);
        assert_eq!(drive.take_raised_fault(), Some(FaultCode::CommandTimeout));
        drive.take_command(command(2, 10.0, Request::Enable));
        assert_eq!(drive.sync(PERIOD_S, 0.0, 0).state, DriveState::Fault);
        drive.take_command(command(3, 10.0, Request::ClearFault));
        assert_eq!(drive.sync(PERIOD_S, 0.0, 0).state, DriveState::Ready);
    }

    #[test]
    fn a_repeated_command_does_not_feed_the_watchdog() {
        let mut drive = enabled();
        for _ in 0..10 {
            drive.take_command(command(1, 10.0, Request::Enable));
            drive.sync(PERIOD_S, 0.0, 0);
        }
        assert_eq!(drive.heartbeat().fault, FaultCode::CommandTimeout);
    }

    #[test]
    fn torque_is_limited_and_quantised() {
        let mut drive = enabled();
        for (counter, wanted, expected) in [(1, 1e3, 90.0), (2, -1e3, -90.0), (3, 1.0024, 1.0), (4, 1.0026, 1.005)] {
            drive.take_command(command(counter, wanted, Request::Enable));
            drive.sync(PERIOD_S, 0.0, 0);
            assert!((drive.torque().final_nm - expected).abs() < 1e-12);
        }
    }
}
