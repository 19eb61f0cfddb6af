//! Whatever happens on the bus, torque flows only while stack and drives hear
//! each other and nobody has asked for a stop, and motion never resumes by
//! itself.

use canloop::event::Event;
use canloop::frame::Frame;
use canloop::safety::{Operator, Reason, State};
use canloop::schema::{Command, FaultCode, Feedback, Heartbeat, Message, Patience, Profile};
use canloop::stack::Stack;
use canloop::time::Instant;
use canloop::wheels::{Wheel, Wheels};
use hil_sim::scenario::Scenario;
use hil_sim::virtual_robot::VirtualRobot;

/// Stack and robot on a bus on which frames take no time and can be tampered
/// with.
struct Rig {
    stack: Stack,
    robot: VirtualRobot,
    profile: Profile,
    now: Instant,
    tamper: fn(&Profile, &mut Frame) -> Fate,
    /// The last command to each drive that left the stack.
    sent: Wheels<Command>,
    /// What the stack gave notice of.
    notices: Vec<&'static str>,
}

/// What becomes of a frame.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fate {
    Crosses,
    Vanishes,
}

/// In which friction has stopped the robot.
const ROLLING_PERIODS: u32 = 400;

/// Long enough for drives to boot and enable and for the robot to move.
const UNDER_WAY_PERIODS: u32 = 600;
/// T of the shipped scenario, s.
const PERIOD_S: f64 = 0.005;

impl Rig {
    /// The shipped scenario, driven until the robot moves.
    fn under_way() -> Self {
        let overrides = ["path.duration_s=20.0".to_owned()];
        let scenario = Scenario::load("dac-friction", &overrides).expect("a good scenario");
        let (profile, start) = (scenario.stack.profile.clone(), Instant::ZERO);
        let robot = scenario.virtual_robot(start);
        let mut rig = Self {
            stack: Stack::new(&scenario.stack, start),
            robot,
            profile,
            now: start,
            tamper: |_, _| Fate::Crosses,
            sent: Wheels::default(),
            notices: Vec::new(),
        };
        rig.stack.operate(Operator::Enable);
        rig.run(UNDER_WAY_PERIODS);
        assert_eq!(rig.stack.state(), State::Running);
        assert!(rig.moves_within(1) && !rig.sends_zero_torque());
        rig.notices.clear();
        rig
    }

    /// Lets so many periods pass.
    fn run(&mut self, periods: u32) {
        for _ in 0..periods {
            self.now = self.stack.next_wakeup();
            self.robot.handle_wakeup(self.now);
            self.exchange();
            self.stack.handle_wakeup(self.now);
            self.exchange();
        }
    }

    /// Carries frames to and fro until nobody has anything more to say.
    fn exchange(&mut self) {
        loop {
            while let Some(event) = self.stack.poll_event() {
                if let Event::Notice(notice) = event {
                    self.notices.push(notice.kind);
                }
            }
            if let Some(mut frame) = self.stack.poll_transmit() {
                if let Ok(Message::Command(wheel, command)) = self.profile.decode(&frame) {
                    self.sent[wheel] = command;
                }
                if (self.tamper)(&self.profile, &mut frame) == Fate::Crosses {
                    self.robot.handle_frame(&frame, PERIOD_S);
                }
            } else if let Some((_, mut frame)) = self.robot.poll_transmit() {
                if (self.tamper)(&self.profile, &mut frame) == Fate::Crosses {
                    self.stack.handle_frame(self.now, &frame);
                }
            } else {
                return;
            }
        }
    }

    /// Puts a frame on the bus that neither stack nor robot sent.
    fn inject(&mut self, message: Message) {
        let frame = self.profile.encode(&message);
        self.stack.handle_frame(self.now, &frame);
        self.robot.handle_frame(&frame, PERIOD_S);
        self.exchange();
    }

    fn sends_zero_torque(&self) -> bool {
        Wheel::BOTH.iter().all(|&wheel| self.sent[wheel].torque_nm == 0.0)
    }

    fn asks_for(&self, word: &str) -> bool {
        let word = self.profile.conversation.word(word);
        Wheel::BOTH.iter().all(|&wheel| self.sent[wheel].word == word)
    }

    fn applies_no_torque(&self) -> bool {
        self.robot.torque_applied_nm() == Wheels::default()
    }

    /// Whether a wheel turns in the periods to come.
    fn moves_within(&mut self, periods: u32) -> bool {
        let before = self.robot.state().angle_rad;
        self.run(periods);
        self.robot.state().angle_rad != before
    }

    /// The robot rolls to rest, and nothing moves it any more.
    #[track_caller]
    fn assert_at_rest_for_good(&mut self) {
        self.run(ROLLING_PERIODS);
        for _ in 0..200 {
            assert!(!self.moves_within(1), "it moves, and the stack is {:?}", self.stack.state());
            assert!(self.sends_zero_torque() && self.applies_no_torque());
        }
    }

    /// Reset leads to stopped and not to motion; a new enable moves again.
    #[track_caller]
    fn assert_only_reset_and_enable_move_it_again(&mut self) {
        self.stack.operate(Operator::Enable);
        self.assert_at_rest_for_good();
        assert!(matches!(self.stack.state(), State::Tripped(_)), "enable alone does not leave a trip");
        self.stack.operate(Operator::Reset);
        assert_eq!(self.stack.state(), State::Stopped);
        self.assert_at_rest_for_good();
        assert_eq!(self.stack.state(), State::Stopped);
        self.stack.operate(Operator::Enable);
        self.run(UNDER_WAY_PERIODS);
        assert_eq!(self.stack.state(), State::Running);
        assert!(self.moves_within(10));
    }
}

fn is_feedback_of(wheel: Wheel, profile: &Profile, frame: &Frame) -> bool {
    matches!(profile.decode(frame), Ok(Message::Feedback(from, _)) if from == wheel)
}

fn without_feedback_of(wheel: Wheel, profile: &Profile, frame: &Frame) -> Fate {
    if is_feedback_of(wheel, profile, frame) { Fate::Vanishes } else { Fate::Crosses }
}

#[test]
fn torque_is_zero_two_periods_after_a_drive_falls_silent() {
    let silences: [fn(&Profile, &mut Frame) -> Fate; 2] = [
        |profile, frame| without_feedback_of(Wheel::Right, profile, frame),
        |profile, frame| without_feedback_of(Wheel::Left, profile, frame),
    ];
    for silence in silences {
        let mut rig = Rig::under_way();
        rig.tamper = silence;
        rig.run(1);
        rig.run(2);
        assert_eq!(rig.stack.state(), State::Tripped(Reason::StaleFeedback));
        assert!(rig.notices.contains(&"tripped"), "{:?}", rig.notices);
        assert!(rig.sends_zero_torque());
        assert!(rig.asks_for("disable"));
        rig.run(1);
        assert!(rig.applies_no_torque());
    }
}

#[test]
fn after_a_drive_fell_silent_only_reset_and_enable_move_the_robot_again() {
    let mut rig = Rig::under_way();
    rig.tamper = |profile, frame| without_feedback_of(Wheel::Left, profile, frame);
    rig.assert_at_rest_for_good();
    rig.tamper = |_, _| Fate::Crosses;
    rig.assert_only_reset_and_enable_move_it_again();
}

#[test]
fn one_lost_feedback_holds_the_torque_and_the_robot_goes_on() {
    let mut rig = Rig::under_way();
    rig.tamper = |profile, frame| without_feedback_of(Wheel::Right, profile, frame);
    rig.run(1);
    rig.tamper = |_, _| Fate::Crosses;
    rig.run(100);
    assert_eq!(rig.stack.state(), State::Running);
    assert!(rig.moves_within(1));
}

#[test]
fn corrupt_feedback_is_noted_and_counts_as_none() {
    let mut rig = Rig::under_way();
    rig.tamper = |profile, frame| {
        if is_feedback_of(Wheel::Right, profile, frame) {
            frame.payload_mut()[0] ^= 0x10;
        }
        Fate::Crosses
    };
    rig.run(1);
    assert_eq!(rig.notices, ["frame-refused"]);
    assert_eq!(rig.stack.state(), State::Running);
    rig.run(2);
    assert_eq!(rig.stack.state(), State::Tripped(Reason::StaleFeedback));
    assert!(rig.sends_zero_torque());
    rig.tamper = |_, _| Fate::Crosses;
    rig.assert_only_reset_and_enable_move_it_again();
}

#[test]
fn corrupt_commands_are_ignored_until_the_drives_own_watchdog_stops_them() {
    let mut rig = Rig::under_way();
    rig.tamper = |profile, frame| {
        if matches!(profile.decode(frame), Ok(Message::Command(..))) {
            // Ten thousand times the least torque, with the old CRC.
            frame.payload_mut()[1] ^= 0x40;
        }
        Fate::Crosses
    };
    let before = rig.robot.torque_applied_nm();
    rig.run(2);
    let after = rig.robot.torque_applied_nm();
    assert!((after - before).all(|change| change.abs() < 20.0), "a corrupt command went into force: {after:?}");
    rig.run(8);
    assert!(rig.applies_no_torque());
    assert_eq!(rig.stack.state(), State::Tripped(Reason::DriveFault));
}

#[test]
fn drives_that_hear_nothing_any_more_stop_by_themselves() {
    let mut rig = Rig::under_way();
    let patience = rig.profile.watchdog.map(|watchdog| watchdog.patience);
    let Some(Patience::Periods(timeout)) = patience else { panic!("{patience:?}") };
    rig.tamper = |profile, frame| match profile.decode(frame) {
        Ok(Message::Command(..)) => Fate::Vanishes,
        _ => Fate::Crosses,
    };
    rig.run(timeout);
    assert!(!rig.applies_no_torque(), "a few lost commands hold the torque");
    rig.run(3);
    assert!(rig.applies_no_torque());
    assert_eq!(rig.stack.state(), State::Tripped(Reason::DriveFault));
    rig.tamper = |_, _| Fate::Crosses;
    rig.assert_at_rest_for_good();
    rig.assert_only_reset_and_enable_move_it_again();
}

#[test]
fn a_fault_of_one_drive_stops_both_wheels() {
    let mut rig = Rig::under_way();
    rig.inject(Message::Fault(Wheel::Left, FaultCode::OverCurrent));
    assert_eq!(rig.stack.state(), State::Tripped(Reason::DriveFault));
    rig.run(1);
    assert!(rig.sends_zero_torque() && rig.asks_for("disable"));
    rig.run(2);
    assert!(rig.applies_no_torque());
    rig.assert_at_rest_for_good();
    rig.assert_only_reset_and_enable_move_it_again();
}

#[test]
fn a_drive_that_leaves_its_enabled_state_unasked_stops_both_wheels() {
    let mut rig = Rig::under_way();
    let state = rig.profile.conversation.state("ready");
    rig.inject(Message::Heartbeat(Wheel::Right, Heartbeat { state, fault: FaultCode::None }));
    assert_eq!(rig.stack.state(), State::Tripped(Reason::DriveDisabled));
    rig.run(1);
    assert!(rig.sends_zero_torque());
    rig.assert_at_rest_for_good();
}

#[test]
fn the_operator_s_stop_brakes_to_rest_within_limits_and_then_lets_go() {
    let mut rig = Rig::under_way();
    // Fast enough that friction alone would take its time.
    rig.run(2000);
    let fast_rad_s = rig.robot.state().speed_rad_s;
    rig.stack.operate(Operator::Stop);
    assert_eq!(rig.stack.state(), State::Stopping);
    let (mut periods, mut last_rad_s) = (0, fast_rad_s);
    while rig.stack.state() == State::Stopping {
        rig.run(1);
        let speed_rad_s = rig.robot.state().speed_rad_s;
        assert!((speed_rad_s - last_rad_s).all(|change| change.abs() < 0.1), "{last_rad_s:?} to {speed_rad_s:?}");
        last_rad_s = speed_rad_s;
        periods += 1;
    }
    assert_eq!(rig.stack.state(), State::Stopped);
    let ramp_periods = fast_rad_s.right.max(fast_rad_s.left) / 5.0 / PERIOD_S;
    assert!(f64::from(periods) < ramp_periods + 60.0, "{periods} periods, and the ramp takes {ramp_periods}");
    assert!(last_rad_s.all(|speed| speed.abs() < 0.1), "{last_rad_s:?}");
    rig.run(1);
    assert!(rig.sends_zero_torque() && rig.asks_for("disable"));
    rig.run(2);
    assert!(rig.applies_no_torque());
    rig.assert_at_rest_for_good();
    rig.stack.operate(Operator::Enable);
    rig.run(UNDER_WAY_PERIODS);
    assert!(rig.moves_within(10));
}

#[test]
fn a_stop_brakes_along_the_arc_that_the_robot_is_on() {
    let mut rig = Rig::under_way();
    rig.run(2000);
    let fast_rad_s = rig.robot.state().speed_rad_s;
    let before_rad = rig.robot.state().angle_rad;
    rig.stack.operate(Operator::Stop);
    rig.run(ROLLING_PERIODS);
    let moved_rad = rig.robot.state().angle_rad - before_rad;
    let (expected, found) = (fast_rad_s.left / fast_rad_s.right, moved_rad.left / moved_rad.right);
    assert!((found - expected).abs() < 0.05, "{found} instead of {expected}");
}

#[test]
fn a_drive_that_falls_silent_while_braking_takes_the_torque_away() {
    let mut rig = Rig::under_way();
    rig.run(2000);
    rig.stack.operate(Operator::Stop);
    rig.tamper = |profile, frame| without_feedback_of(Wheel::Left, profile, frame);
    rig.run(3);
    assert_eq!(rig.stack.state(), State::Tripped(Reason::StaleFeedback));
    assert!(rig.sends_zero_torque());
    // Nothing but friction slows it down.
    rig.run(2000);
    rig.assert_at_rest_for_good();
}

#[test]
fn an_emergency_stop_takes_the_torque_away_with_the_next_command_and_is_latched() {
    let mut rig = Rig::under_way();
    rig.stack.operate(Operator::EmergencyStop);
    assert_eq!(rig.stack.state(), State::Tripped(Reason::OperatorStop));
    rig.run(1);
    assert!(rig.sends_zero_torque() && rig.asks_for("disable"));
    rig.run(2);
    assert!(rig.applies_no_torque());
    rig.assert_only_reset_and_enable_move_it_again();
}

#[test]
fn a_drive_that_sends_the_same_feedback_over_and_over_counts_as_silent() {
    let mut rig = Rig::under_way();
    rig.tamper = |profile, frame| {
        if let Ok(Message::Feedback(Wheel::Right, mut feedback)) = profile.decode(frame) {
            (feedback.position, feedback.counter) = (Some(1000.0), Some(3));
            *frame = profile.encode(&Message::Feedback(Wheel::Right, feedback));
        }
        Fate::Crosses
    };
    rig.run(5);
    assert!(matches!(rig.stack.state(), State::Tripped(_)), "{:?}", rig.stack.state());
    assert!(rig.sends_zero_torque());
}

#[test]
fn frames_that_mean_nothing_to_anybody_change_nothing() {
    let mut rig = Rig::under_way();
    let mut untouched = Rig::under_way();
    for number in 0..2048_u16 {
        let payload = [number as u8; 8];
        let len = usize::from(number % 9);
        let frame = Frame::classic(canloop::frame::CanId::Standard(number), &payload[..len]);
        if rig.profile.decode(&frame).is_err() && !rig.profile.is_sent_by_drives(frame.id) {
            rig.stack.handle_frame(rig.now, &frame);
            rig.robot.handle_frame(&frame, PERIOD_S);
        }
        rig.exchange();
    }
    rig.run(50);
    untouched.run(50);
    assert_eq!(rig.stack.state(), State::Running);
    assert_eq!(rig.robot.state(), untouched.robot.state());
}

#[test]
fn a_few_damaged_frames_in_a_drive_s_name_are_tolerated_and_many_stop_the_robot() {
    let mut rig = Rig::under_way();
    let mut damaged = rig.profile.encode(&Message::Feedback(Wheel::Left, Feedback::default()));
    damaged.payload_mut()[3] ^= 1;
    for _ in 0..2 {
        rig.stack.handle_frame(rig.now, &damaged);
        rig.run(100);
    }
    assert_eq!(rig.stack.state(), State::Running);
    rig.run(200);
    for _ in 0..3 {
        assert_eq!(rig.stack.state(), State::Running);
        rig.stack.handle_frame(rig.now, &damaged);
        rig.run(1);
    }
    assert_eq!(rig.stack.state(), State::Tripped(Reason::DamagedFrames));
    rig.run(1);
    assert!(rig.sends_zero_torque());
    rig.assert_only_reset_and_enable_move_it_again();
}

#[test]
fn a_torque_that_the_law_asks_for_and_that_is_too_much_is_cut_to_the_limit() {
    let overrides = ["path.duration_s=2.0".to_owned(), "safety.torque_limit_nm=65.0".to_owned()];
    let scenario = Scenario::load("dac-friction", &overrides).expect("a good scenario");
    let mut rig = Rig::under_way();
    rig.stack = Stack::new(&scenario.stack, rig.now);
    rig.stack.operate(Operator::Enable);
    let mut most_nm: f64 = 0.0;
    for _ in 0..400 {
        rig.run(1);
        most_nm = Wheel::BOTH.iter().fold(most_nm, |most, &wheel| most.max(rig.sent[wheel].torque_nm.abs()));
    }
    assert_eq!(most_nm, 65.0);
}

#[test]
fn feedback_that_nobody_asked_for_stops_the_robot_and_only_reset_and_enable_move_it_again() {
    let mut rig = Rig::under_way();
    let counter = 2;
    assert_ne!(counter, (UNDER_WAY_PERIODS - 1) % 16, "a repeated counter would be ignored");
    let state = rig.profile.conversation.state("enabled");
    let replayed = Feedback { state, counter: Some(counter as u8), ..Feedback::default() };
    rig.inject(Message::Feedback(Wheel::Right, replayed));
    assert_eq!(rig.stack.state(), State::Tripped(Reason::CounterJump));
    rig.run(1);
    assert!(rig.sends_zero_torque());
    rig.assert_only_reset_and_enable_move_it_again();
}
