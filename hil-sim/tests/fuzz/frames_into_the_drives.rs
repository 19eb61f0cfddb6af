//! Frames, moments and mishaps into the simulated drives, between periods in
//! which a stack drives them as it should.

use std::collections::VecDeque;
use std::path::Path;

use canloop::frame::Frame;
use canloop::safety::Operator;
use canloop::schema::{FaultCode, Profile};
use canloop::stack::Stack;
use canloop::time::{Duration, Instant};
use canloop::wheels::Wheel;
use hil_sim::scenario::Scenario;
use hil_sim::virtual_robot::VirtualRobot;

use crate::drives_that_ship::ShippedDrives;
use crate::frames;
use crate::harness::{Chance, Target, digest, seeds_in};
use crate::script::Script;
use crate::watched_drives::{WatchedFarSide, WatchedRobot};

/// What can happen; the number behind it is said with each.
#[derive(Clone, Copy)]
enum Act {
    /// Wants something of the stack.
    Operate(Operator),
    /// So many periods pass as they should.
    Run,
    /// So many of the next frames from the stack get lost.
    Lose,
    /// A frame comes again that had come so many frames before.
    Replay,
    /// A frame that had come comes again, damaged.
    Damage,
    /// A valid frame comes in the stack's name and says something else.
    Forge,
    /// A frame with a known id and any contents comes.
    Known,
    /// Any frame comes.
    Any,
    /// A moment comes, so many nanoseconds from now.
    Moment,
    /// A time passes within a period.
    Advance,
    /// A time passes without SYNC.
    GoWithoutSync,
    /// A period begins, by the clock.
    Begin,
    /// Something fails in the drive of a wheel.
    Fault,
    /// The drive of a wheel is switched off and on again.
    PowerCycle,
}

const VERBS: [(&str, Act); 17] = [
    ("enable", Act::Operate(Operator::Enable)),
    ("stop", Act::Operate(Operator::Stop)),
    ("emergency", Act::Operate(Operator::EmergencyStop)),
    ("reset", Act::Operate(Operator::Reset)),
    ("run", Act::Run),
    ("lose", Act::Lose),
    ("replay", Act::Replay),
    ("damage", Act::Damage),
    ("forge", Act::Forge),
    ("known", Act::Known),
    ("any", Act::Any),
    ("moment", Act::Moment),
    ("advance", Act::Advance),
    ("without", Act::GoWithoutSync),
    ("begin", Act::Begin),
    ("fault", Act::Fault),
    ("power", Act::PowerCycle),
];

const WORDS: [&str; 24] = [
    "\nenable\n",
    "\nreset\nenable\nrun 30\n",
    "\nstop\n",
    "\nreset\n",
    "\nrun 1\n",
    "\nrun 3\n",
    "\nrun 100\n",
    "\nlose 1\n",
    "\nlose 20\nrun 10\n",
    "\nreplay 1\n",
    "\nreplay 5\n",
    "\ndamage 2\n",
    "\nforge 1\n",
    "\nforge 2\nrun 1\n",
    "\nknown 3\n",
    "\nany 4\n",
    "\nmoment 1000000000\n",
    "\nadvance 3\n",
    "\nwithout 3\n",
    "\nbegin 3\n",
    "\nfault 1\n",
    "\npower 1\n",
    "comma-body\nenable\nrun 200\n",
    "cia402\nenable\nrun 200\n",
];

/// Periods of a script that pass: the rest would only take time.
const MOST_PERIODS: i64 = 400;
/// Frames that are remembered.
const RECENT: usize = 16;

#[test]
fn frames_into_the_drives() {
    let drives = ShippedDrives::load();
    let seeds = seeds_in(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/seeds/drives"));
    Target { name: "frames_into_the_drives", seeds, words: &WORDS, share: 1.0 }.fuzz(|input| {
        let text = String::from_utf8_lossy(input);
        let script = Script::read(&text);
        let scenario = drives.chosen_by(&script);
        let mut bench = Bench::new(scenario);
        script.acts(&VERBS).for_each(|(act, number)| bench.act(act, number));
        let seen = bench.robots.each_ref().map(|robot| &robot.seen);
        digest(format!("{} {seen:?}", scenario.name).as_bytes())
    });
}

/// A stack and the drives that hear it, each in its way: on a wire, at once
/// with periods that frames begin, and with periods by the clock.
struct Bench<'s> {
    stack: Stack,
    far_side: WatchedFarSide,
    robots: [WatchedRobot; 2],
    profile: &'s Profile,
    period_s: f64,
    now: Instant,
    /// How many of the next frames from the stack get lost.
    to_lose: i64,
    /// The last frames from the stack.
    recent: VecDeque<Frame>,
    periods_left: i64,
}

impl<'s> Bench<'s> {
    fn new(scenario: &'s Scenario) -> Self {
        Self {
            stack: Stack::new(&scenario.stack, Instant::ZERO),
            far_side: WatchedFarSide::new(scenario),
            robots: [false, true].map(|is_by_clock| WatchedRobot::new(scenario, is_by_clock)),
            profile: &scenario.stack.profile,
            period_s: scenario.period_s(),
            now: Instant::ZERO,
            to_lose: 0,
            recent: VecDeque::new(),
            periods_left: MOST_PERIODS,
        }
    }

    fn act(&mut self, act: Act, number: i64) {
        let mut chance = Chance(number as u64);
        let wheel = if number & 1 == 0 { Wheel::Right } else { Wheel::Left };
        let span_s = [0.0, 1e-9, 1e-4, self.period_s, 0.1, 1.0][number.rem_euclid(6) as usize];
        match act {
            Act::Operate(wish) => self.stack.operate(wish),
            Act::Run => self.run(number),
            Act::Lose => self.to_lose = number.rem_euclid(100),
            Act::Replay => self.inject(self.recent(number)),
            Act::Damage => self.inject(self.recent(number).map(|real| frames::damaged(&real, &mut chance))),
            Act::Forge => {
                let real = self.recent(number);
                self.inject(real.and_then(|real| frames::forged(self.profile, &real, &mut chance)));
            }
            Act::Known => self.inject(Some(frames::in_a_known_name(self.profile, &mut chance))),
            Act::Any => self.inject(Some(frames::any(&mut chance))),
            Act::Moment => {
                let at = self.now + Duration::from_nanos(number);
                self.happen(|robot| robot.handle_wakeup(at));
            }
            Act::Advance => self.happen(|robot| robot.advance(span_s)),
            Act::GoWithoutSync => self.happen(|robot| robot.go_without_sync(span_s)),
            Act::Begin => self.happen(|robot| robot.begin_period(span_s)),
            Act::Fault => self.happen(|robot| robot.raise_fault(wheel, FaultCode::OverCurrent)),
            Act::PowerCycle => self.happen(|robot| robot.power_cycle(wheel)),
        }
    }

    fn run(&mut self, periods: i64) {
        let periods = periods.rem_euclid(MOST_PERIODS).min(self.periods_left);
        self.periods_left -= periods;
        for _ in 0..periods {
            self.now = self.stack.next_wakeup();
            let now = self.now;
            self.happen(|robot| robot.handle_wakeup(now));
            self.stack.handle_wakeup(now);
            self.hand_over();
        }
    }

    /// Gives the drives what the stack has sent, and the stack what they answer.
    fn hand_over(&mut self) {
        while let Some(frame) = self.stack.poll_transmit() {
            self.recent.push_front(frame);
            self.recent.truncate(RECENT);
            if self.to_lose > 0 {
                self.to_lose -= 1;
            } else {
                self.deliver(&frame);
            }
        }
        while self.stack.poll_event().is_some() {}
    }

    fn deliver(&mut self, frame: &Frame) {
        let span_s = self.period_s;
        self.happen(|robot| _ = robot.handle_frame(frame, span_s));
        for answer in self.far_side.take(*frame) {
            self.stack.handle_frame(self.now, &answer);
        }
    }

    fn inject(&mut self, frame: Option<Frame>) {
        if let Some(frame) = frame {
            self.deliver(&frame);
            self.hand_over();
        }
    }

    fn recent(&self, back: i64) -> Option<Frame> {
        let len = self.recent.len().max(1);
        self.recent.get(back.rem_euclid(len as i64) as usize).copied()
    }

    fn happen(&mut self, happen: impl Fn(&mut VirtualRobot)) {
        self.robots.iter_mut().for_each(|robot| robot.watch(&happen));
    }
}
