//! Frames, moments and wishes into the stack, between periods in which a far
//! side answers as it should.

use std::collections::VecDeque;
use std::path::Path;

use canloop::frame::Frame;
use canloop::safety::Operator;
use canloop::schema::Profile;

use canloop::time::{Duration, Instant};
use hil_sim::far_side::{FarSide, Happening};
use hil_sim::scenario::Scenario;

use crate::drives_that_ship::{ShippedDrives, bit_rates};
use crate::frames;
use crate::harness::{Chance, Target, digest, seeds_in};
use crate::script::Script;
use crate::watched_stack::WatchedStack;

/// What can happen; the number behind it is said with each.
#[derive(Clone, Copy)]
enum Act {
    /// Wants something.
    Operate(Operator),
    /// So many periods pass as they should.
    Run,
    /// Wakes up so many nanoseconds after it wanted to, or before.
    WakeUp,
    /// The time stamps of frames are so many nanoseconds off from now on.
    Skew,
    /// So many of the next frames from drives get lost.
    Lose,
    /// One of the next frames from drives is damaged.
    Damage,
    /// One of the next frames from drives comes twice.
    Repeat,
    /// A frame comes again that had come so many frames before.
    Replay,
    /// A valid frame comes in a drive's name and says something else.
    Forge,
    /// A frame with a known id and any contents comes.
    Known,
    /// Any frame comes.
    Any,
    /// The runtime ends, or so it says.
    Farewell,
}

const VERBS: [(&str, Act); 15] = [
    ("enable", Act::Operate(Operator::Enable)),
    ("stop", Act::Operate(Operator::Stop)),
    ("emergency", Act::Operate(Operator::EmergencyStop)),
    ("reset", Act::Operate(Operator::Reset)),
    ("run", Act::Run),
    ("wake", Act::WakeUp),
    ("skew", Act::Skew),
    ("lose", Act::Lose),
    ("damage", Act::Damage),
    ("repeat", Act::Repeat),
    ("replay", Act::Replay),
    ("forge", Act::Forge),
    ("known", Act::Known),
    ("any", Act::Any),
    ("farewell", Act::Farewell),
];

const WORDS: [&str; 25] = [
    "\nenable\n",
    "\nreset\nenable\nrun 30\n",
    "\nstop\n",
    "\nemergency\n",
    "\nreset\n",
    "\nrun 1\n",
    "\nrun 3\n",
    "\nrun 100\n",
    "\nwake 0\n",
    "\nwake 4999999\n",
    "\nwake 5000001\n",
    "\nwake -1\n",
    "\nskew 2000000\n",
    "\nlose 1\n",
    "\nlose 4\n",
    "\ndamage 1\n",
    "\nrepeat 1\n",
    "\nreplay 4\n",
    "\nforge 1\n",
    "\nforge 2\nrun 1\n",
    "\nknown 3\n",
    "\nany 4\n",
    "\nfarewell\n",
    "comma-body\nenable\nrun 200\n",
    "odrive-0.6\nenable\nrun 200\n",
];

/// Periods of a script that pass: the rest would only take time.
const MOST_PERIODS: i64 = 500;
/// Frames that are remembered.
const RECENT: usize = 16;

#[test]
fn frames_into_the_stack() {
    let drives = ShippedDrives::load();
    let seeds = seeds_in(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/seeds/stack"));
    Target { name: "frames_into_the_stack", seeds, words: &WORDS, share: 1.0 }.fuzz(|input| {
        let text = String::from_utf8_lossy(input);
        let script = Script::read(&text);
        let scenario = drives.chosen_by(&script);
        let mut bench = Bench::new(scenario);
        script.acts(&VERBS).for_each(|(act, number)| bench.act(act, number));
        digest(format!("{} {:?}", scenario.name, bench.stack.seen).as_bytes())
    });
}

/// A stack and its far side, with somebody between them.
struct Bench<'s> {
    stack: WatchedStack<'s>,
    far_side: FarSide,
    profile: &'s Profile,
    /// When the stack woke up last.
    now: Instant,
    skew: Duration,
    /// What becomes of the next frames from drives.
    fates: VecDeque<Fate>,
    /// The last frames from drives.
    recent: VecDeque<Frame>,
    periods_left: i64,
}

#[derive(Clone, Copy)]
enum Fate {
    Comes,
    IsLost,
    IsDamaged(i64),
    ComesTwice,
}

impl<'s> Bench<'s> {
    fn new(scenario: &'s Scenario) -> Self {
        Self {
            stack: WatchedStack::new(&scenario.stack),
            far_side: FarSide::new(scenario, bit_rates(scenario), Instant::ZERO),
            profile: &scenario.stack.profile,
            now: Instant::ZERO,
            skew: Duration::ZERO,
            fates: VecDeque::new(),
            recent: VecDeque::new(),
            periods_left: MOST_PERIODS,
        }
    }

    fn act(&mut self, act: Act, number: i64) {
        let mut chance = Chance(number as u64);
        match act {
            Act::Operate(wish) => self.stack.operate(wish),
            Act::Run => self.run(number),
            Act::WakeUp => self.wake_up(self.stack.next_wakeup() + Duration::from_nanos(number)),
            Act::Skew => self.skew = Duration::from_nanos(number),
            Act::Lose => self.fates.extend((0..number.rem_euclid(30)).map(|_| Fate::IsLost)),
            Act::Damage => self.doom(Fate::IsDamaged(number), number),
            Act::Repeat => self.doom(Fate::ComesTwice, number),
            Act::Replay => self.inject(self.recent(number)),
            Act::Forge => {
                let real = self.recent(number);
                self.inject(real.and_then(|real| frames::forged(self.profile, &real, &mut chance)));
            }
            Act::Known => self.inject(Some(frames::in_a_known_name(self.profile, &mut chance))),
            Act::Any => self.inject(Some(frames::any(&mut chance))),
            Act::Farewell => {
                self.stack.say_farewell();
                self.exchange();
            }
        }
    }

    fn run(&mut self, periods: i64) {
        let periods = periods.rem_euclid(MOST_PERIODS).min(self.periods_left);
        (0..periods).for_each(|_| self.wake_up(self.stack.next_wakeup()));
    }

    fn wake_up(&mut self, at: Instant) {
        self.periods_left -= 1;
        self.now = at;
        self.stack.handle_wakeup(at);
        self.exchange();
    }

    /// A fate for a frame that comes soon.
    fn doom(&mut self, fate: Fate, number: i64) {
        self.fates.extend((0..number.rem_euclid(7)).map(|_| Fate::Comes));
        self.fates.push_back(fate);
    }

    fn recent(&self, back: i64) -> Option<Frame> {
        let len = self.recent.len().max(1);
        self.recent.get(back.rem_euclid(len as i64) as usize).copied()
    }

    fn inject(&mut self, frame: Option<Frame>) {
        if let Some(frame) = frame {
            self.stack.handle_frame(self.now + self.skew, &frame);
            self.exchange();
        }
    }

    /// Carries frames to and fro until nobody has anything more to say.
    fn exchange(&mut self) {
        loop {
            if let Some(frame) = self.stack.sent.pop_front() {
                self.far_side.take(frame);
            } else if let Some((_, happening)) = self.far_side.poll() {
                if let Happening::Frame(crossed) = happening
                    && !crossed.sent_by_stack
                {
                    self.carry(crossed.frame);
                }
            } else {
                return;
            }
        }
    }

    /// Carries a frame from a drive, or does something else with it.
    fn carry(&mut self, frame: Frame) {
        self.recent.push_front(frame);
        self.recent.truncate(RECENT);
        let at = self.now + self.skew;
        match self.fates.pop_front().unwrap_or(Fate::Comes) {
            Fate::Comes => self.stack.handle_frame(at, &frame),
            Fate::IsLost => {}
            Fate::IsDamaged(number) => {
                self.stack.handle_frame(at, &frames::damaged(&frame, &mut Chance(number as u64)));
            }
            Fate::ComesTwice => (0..2).for_each(|_| self.stack.handle_frame(at, &frame)),
        }
    }
}
