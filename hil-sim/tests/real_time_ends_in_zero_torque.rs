//! However a loop in real time ends, the last things the drives hear are zero
//! torque, Disable, and a SYNC that puts them into force.

use std::cell::Cell;
use std::collections::VecDeque;
use std::io;
use std::rc::Rc;
use std::sync::Arc;

use canloop::bus::{Arrival, Bus, BusError, ControllerState};
use canloop::event::{Event, Sink};
use canloop::frame::Frame;
use canloop::run::{Clock, End, Ended, RealTime, StopSwitch};
use canloop::safety::{Operator, Reason, State};
use canloop::schema::{Command, Message, Profile};
use canloop::stack::Stack;
use canloop::time::{Duration, Instant};
use canloop::wheels::{Wheel, Wheels};
use hil_sim::scenario::Scenario;
use hil_sim::virtual_robot::VirtualRobot;

/// What happens once the robot is under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Trouble {
    /// Nothing, until somebody asks the loop to end.
    Stop,
    /// The same, and in a hurry.
    StopAtOnce,
    /// The transmit queue is full, for so many periods.
    QueueFull { periods: u64 },
    /// The interface is down for a while.
    InterfaceDown,
    /// The controller is off the bus.
    BusOff,
    /// The loop is held up for longer than it may be.
    Overrun,
    /// The bus is gone for good.
    Gone,
    /// A reader of events panics.
    Panic,
}

/// Drives and plant behind a bus that gets into trouble.
struct TroubledBus {
    robot: VirtualRobot,
    profile: Profile,
    clock: Clock,
    trouble: Trouble,
    answers: VecDeque<Frame>,
    syncs: u64,
    synced_at: Instant,
    told: bool,
    tries: u64,
    stop: Arc<StopSwitch>,
    heard: Rc<Cell<LastWords>>,
    panic_now: Rc<Cell<bool>>,
}

/// What the drives heard last.
#[derive(Clone, Copy, Debug, Default)]
struct LastWords {
    commands: Wheels<Command>,
    /// Whether a SYNC came behind them.
    in_force: bool,
    /// The greatest torque that was ever asked for, N m.
    most_nm: f64,
}

const PERIOD_S: f64 = 0.005;
/// SYNCs after which the robot is under way.
const UNDER_WAY: u64 = 100;

impl TroubledBus {
    fn is_troubled(&self) -> bool {
        self.syncs >= UNDER_WAY
    }

    fn refuses(&mut self) -> Option<BusError> {
        match self.trouble {
            _ if !self.is_troubled() => None,
            Trouble::QueueFull { periods } => {
                self.tries += 1;
                // One try comes with a period, and the loop tries again every 100 us.
                (self.tries < periods * 50).then_some(BusError::Full)
            }
            Trouble::InterfaceDown => {
                self.tries += 1;
                (self.tries < 3).then_some(BusError::Down)
            }
            Trouble::Gone => Some(BusError::Gone("can0".to_owned(), io::Error::other("unplugged"))),
            _ => None,
        }
    }

    fn make_trouble(&mut self) -> Option<Arrival> {
        if !self.is_troubled() || std::mem::replace(&mut self.told, true) {
            return None;
        }
        match self.trouble {
            Trouble::Stop => self.stop.press(),
            Trouble::StopAtOnce => (0..2).for_each(|_| self.stop.press()),
            Trouble::InterfaceDown => return Some(Arrival::Down),
            Trouble::BusOff => return Some(Arrival::State(ControllerState::BusOff)),
            Trouble::Overrun => self.wait_until(self.clock.now() + Duration::from_secs_f64(60.0 * PERIOD_S)),
            Trouble::Panic => self.panic_now.set(true),
            Trouble::QueueFull { .. } | Trouble::Gone => {}
        }
        None
    }

    fn collect_answers(&mut self) {
        self.answers.extend(std::iter::from_fn(|| self.robot.poll_transmit()).map(|(_, answer)| answer));
    }

    fn wait_until(&self, deadline: Instant) {
        while self.clock.now() < deadline {
            std::hint::spin_loop();
        }
    }

    fn listen(&self, frame: &Frame) {
        let mut words = self.heard.get();
        match self.profile.decode(frame) {
            Ok(Message::Sync { .. }) => words.in_force = true,
            Ok(Message::Command(wheel, command)) => {
                words.in_force = false;
                words.commands[wheel] = command;
                words.most_nm = words.most_nm.max(command.torque_nm.abs());
            }
            other => panic!("the stack sent {other:?}"),
        }
        self.heard.set(words);
    }
}

impl Bus for TroubledBus {
    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        if let Some(error) = self.refuses() {
            return Err(error);
        }
        self.listen(frame);
        let now = self.clock.now();
        // The plant moves by the clock, as the loop does.
        if self.robot.handle_frame(frame, (now - self.synced_at).as_secs_f64()) {
            self.syncs += 1;
            self.synced_at = now;
        }
        self.collect_answers();
        Ok(())
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<(Instant, Arrival)>, BusError> {
        if let Some(arrival) = self.make_trouble() {
            return Ok(Some((self.clock.now(), arrival)));
        }
        if self.clock.now() >= self.robot.next_wakeup() {
            self.robot.handle_wakeup(self.clock.now());
            self.collect_answers();
        }
        if let Some(frame) = self.answers.pop_front() {
            return Ok(Some((self.clock.now(), Arrival::Frame(frame))));
        }
        self.wait_until(deadline);
        Ok(None)
    }
}

/// Panics when it is told to.
struct Reader(Rc<Cell<bool>>);

impl Sink for Reader {
    fn event(&mut self, _at: Instant, _event: &Event) {
        assert!(!self.0.take(), "a reader panics");
    }
}

/// Runs the shipped scenario into trouble. The run itself is `Err` where it
/// panicked.
fn run_into(trouble: Trouble) -> (std::thread::Result<Ended>, LastWords) {
    // Machines that run tests are late at times; only trouble may trip here.
    let overrides = ["safety.overrun_periods=50".to_owned(), "path.duration_s=20.0".to_owned()];
    let scenario = Scenario::load("dac-friction", &overrides).expect("a good scenario");
    let clock = Clock::new();
    let start = clock.now() + Duration::from_millis(1);
    let profile = scenario.stack.profile.clone();
    let (stop, heard) = (Arc::new(StopSwitch::new()), Rc::new(Cell::default()));
    let mut reader = Reader(Rc::default());
    let mut bus = TroubledBus {
        robot: VirtualRobot::new(profile.clone(), scenario.plant(), scenario.drive_spec(), start),
        profile,
        clock,
        trouble,
        answers: VecDeque::new(),
        syncs: 0,
        synced_at: start,
        told: false,
        tries: 0,
        stop: Arc::clone(&stop),
        heard: Rc::clone(&heard),
        panic_now: Rc::clone(&reader.0),
    };
    let mut stack = Stack::new(&scenario.stack, start);
    stack.operate(Operator::Enable);
    let until = start + Duration::from_secs_f64(20.0);
    let run = RealTime::new(stack, &mut bus, &mut reader, clock);
    let ended = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| run.run(&stop, until)));
    (ended, heard.get())
}

#[track_caller]
fn assert_told_to_let_go(words: &LastWords) {
    assert!(words.most_nm > 1.0, "the robot was under way: {words:?}");
    let profile = Profile::builtin("wheel_drive").expect("it is built in");
    for wheel in Wheel::BOTH {
        let Command { torque_nm, word, .. } = words.commands[wheel];
        assert_eq!((torque_nm, word), (0.0, profile.conversation.word("disable")), "{wheel:?}");
    }
    assert!(words.in_force, "no SYNC came behind the last commands");
}

#[track_caller]
fn assert_trips(trouble: Trouble, reason: Reason) {
    let (ended, words) = run_into(trouble);
    let ended = ended.expect("no panic");
    assert!(matches!(ended.end, End::Tripped), "{ended:?}");
    assert_eq!(ended.state, State::Tripped(reason));
    assert_told_to_let_go(&words);
}

#[test]
fn a_stop_that_is_asked_for_brakes_to_rest_first() {
    let (ended, words) = run_into(Trouble::Stop);
    let ended = ended.expect("no panic");
    assert!(matches!((&ended.end, ended.state), (End::Stopped, State::Stopped)), "{ended:?}");
    assert_told_to_let_go(&words);
}

#[test]
fn a_stop_that_is_asked_for_twice_lets_go_at_once() {
    let (ended, words) = run_into(Trouble::StopAtOnce);
    let ended = ended.expect("no panic");
    assert!(matches!((&ended.end, ended.state), (End::Stopped, State::Stopping)), "{ended:?}");
    assert_told_to_let_go(&words);
}

#[test]
fn a_transmit_queue_that_stays_full_is_a_bus_that_is_lost() {
    assert_trips(Trouble::QueueFull { periods: 4 }, Reason::BusLost);
}

#[test]
fn an_interface_that_goes_down() {
    assert_trips(Trouble::InterfaceDown, Reason::BusLost);
}

#[test]
fn a_controller_that_is_bus_off() {
    assert_trips(Trouble::BusOff, Reason::BusOff);
}

#[test]
fn a_loop_that_is_held_up() {
    assert_trips(Trouble::Overrun, Reason::LoopOverrun);
}

#[test]
fn a_bus_that_is_gone_ends_the_loop_and_says_why() {
    let (ended, _) = run_into(Trouble::Gone);
    let ended = ended.expect("no panic");
    assert!(matches!(&ended.end, End::Lost(error) if error.to_string().contains("unplugged")), "{ended:?}");
}

#[test]
fn a_panic() {
    let (ended, words) = run_into(Trouble::Panic);
    assert!(ended.is_err(), "it panicked");
    assert_told_to_let_go(&words);
}

#[test]
fn frames_that_found_no_room_are_counted() {
    let (ended, _) = run_into(Trouble::QueueFull { periods: 4 });
    let counts = ended.expect("no panic").bus;
    assert!(counts.delayed >= 1 && counts.given_up >= 1, "{counts:?}");
    assert!(counts.sent > 300 && counts.received > 200 && counts.lost == 0, "{counts:?}");
}
