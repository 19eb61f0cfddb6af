//! A robot's traffic on the simulated bus: the stack begins its periods, drives
//! answer what they hear, the stack answers them.

use canloop::budget::Terms;
use canloop::bus::worst_case_frame_bits;
use canloop::frame::{CanId, FrameKind};
use canloop::schema::{Cause, Profile, Recurring};

use crate::wire::{Chance, Frame, Wire};

/// How frames wait that a node has ready.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Queues {
    /// The most urgent first.
    Sorted,
    /// The stack's in the order in which it queued them.
    OfStackInTurn,
    /// Everybody's.
    AllInTurn,
}

/// What is sent, and by what.
pub struct Robot {
    pub traffic: Vec<Recurring>,
    frames: Vec<Frame>,
    /// By message: what makes drives send it.
    asked_by: Vec<Option<usize>>,
    period_ns: i64,
    lateness_ns: i64,
    answer_ns: i64,
}

/// The longest times that were seen, ns.
pub struct Seen {
    /// By message, from the moment that it was due.
    pub responses_ns: Vec<i64>,
    /// From the beginning of a period to the end of its exchange.
    pub exchange_ns: i64,
}

const PERIODS: i64 = 6;

impl Robot {
    /// Stack and drives with such queues.
    pub fn new(profile: &Profile, terms: &Terms, queues: Queues) -> Self {
        let traffic = profile.traffic(terms.period);
        let frame = |message: &Recurring| {
            let is_remote = message.kind == FrameKind::Remote;
            let layout = profile.dbc.message_by_id(message.id).unwrap();
            let len = if is_remote { 0 } else { layout.len };
            let is_stack_s = matches!(message.cause, Cause::Beginning | Cause::Answered);
            let drive = 1 + profile.dbc.messages.iter().position(|other| other.sender == layout.sender).unwrap();
            let bits = i64::from(worst_case_frame_bits(message.id, len, message.kind));
            Frame {
                order: order(message.id, is_remote),
                length_ns: bits * 1_000_000_000 / i64::from(terms.bit_rate_bit_s),
                queue: match queues {
                    Queues::Sorted => None,
                    Queues::OfStackInTurn => is_stack_s.then_some(0),
                    Queues::AllInTurn => Some(if is_stack_s { 0 } else { drive }),
                },
            }
        };
        let name = |message: &Recurring| profile.dbc.message_by_id(message.id).unwrap().name.clone();
        let asks = |answer: &Recurring| {
            let beginning = || traffic.iter().enumerate().filter(|(_, message)| message.cause == Cause::Beginning);
            let found = match profile.asks {
                canloop::schema::Asks::BySync => beginning().next(),
                canloop::schema::Asks::ByPoll => {
                    beginning().find(|(_, message)| message.kind == FrameKind::Remote && message.id == answer.id)
                }
                // RightCommand asks for RightFeedback.
                _ => beginning().find(|(_, message)| name(message)[..4] == name(answer)[..4]),
            };
            found.expect("a message that asks").0
        };
        Self {
            frames: traffic.iter().map(frame).collect(),
            asked_by: traffic.iter().map(|message| (message.cause == Cause::Asked).then(|| asks(message))).collect(),
            traffic,
            period_ns: terms.period.as_nanos(),
            lateness_ns: terms.lateness.as_nanos(),
            answer_ns: terms.answer.as_nanos(),
        }
    }

    /// Some periods, with everything that is left to chance as bad or good as
    /// it likes.
    pub fn run(&self, chance: &mut Chance) -> Seen {
        let mut wire = Wire::default();
        let mut due_ns = vec![vec![0; PERIODS as usize]; self.traffic.len()];
        for index in self.of(Cause::OwnClock) {
            due_ns[index].clear();
            self.send_by_own_clock(&mut wire, index, chance, &mut due_ns[index]);
        }
        for period in 0..PERIODS {
            let begun_ns = self.first_ns() + period * self.period_ns;
            let queued_ns = begun_ns + chance.extreme(self.lateness_ns);
            for index in self.of(Cause::Beginning) {
                due_ns[index][period as usize] = begun_ns;
                wire.queue(queued_ns, (index, period), self.frames[index]);
            }
        }
        let mut seen = Seen { responses_ns: vec![0; self.traffic.len()], exchange_ns: 0 };
        let mut answers = [0; PERIODS as usize];
        while let Some((end_ns, (index, period))) = wire.next() {
            let response_ns = end_ns - due_ns[index][period as usize];
            seen.responses_ns[index] = seen.responses_ns[index].max(response_ns);
            let cause = self.traffic[index].cause;
            if cause == Cause::OwnClock {
                continue;
            }
            let since_begun_ns = end_ns - self.first_ns() - period * self.period_ns;
            seen.exchange_ns = seen.exchange_ns.max(since_begun_ns);
            for answer in (0..self.traffic.len()).filter(|&answer| self.asked_by[answer] == Some(index)) {
                due_ns[answer][period as usize] = end_ns;
                wire.queue(end_ns + chance.extreme(self.answer_ns), (answer, period), self.frames[answer]);
            }
            if cause == Cause::Asked {
                answers[period as usize] += 1;
                if answers[period as usize] == self.of(Cause::Asked).count() {
                    let queued_ns = end_ns + chance.extreme(self.lateness_ns);
                    for answered in self.of(Cause::Answered) {
                        due_ns[answered][period as usize] = end_ns;
                        wire.queue(queued_ns, (answered, period), self.frames[answered]);
                    }
                }
            }
        }
        seen
    }

    /// Sends somewhere in the run, often right where a period begins.
    fn send_by_own_clock(&self, wire: &mut Wire, index: usize, chance: &mut Chance, due_ns: &mut Vec<i64>) {
        let cycle_ns = self.traffic[index].cycle.as_nanos();
        let first_ns = match chance.up_to(3) {
            0 => chance.up_to(2 * self.first_ns().min(cycle_ns)),
            1 => self.first_ns() + chance.up_to(self.period_ns / 4),
            late => self.first_ns() - (late - 2),
        };
        let mut queued_ns = i64::MIN;
        for turn in 0..=(PERIODS + 2) * self.period_ns / cycle_ns {
            due_ns.push(first_ns + turn * cycle_ns);
            // A sender does not overtake itself.
            queued_ns = queued_ns.max(first_ns + turn * cycle_ns + chance.extreme(self.answer_ns));
            wire.queue(queued_ns, (index, turn), self.frames[index]);
        }
    }

    fn of(&self, cause: Cause) -> impl Iterator<Item = usize> {
        (0..self.traffic.len()).filter(move |&index| self.traffic[index].cause == cause)
    }

    /// When the first period begins, so that something can be on the bus then.
    const fn first_ns(&self) -> i64 {
        self.period_ns
    }
}

/// The lowest wins; a data frame goes before the request for it.
pub fn order(id: CanId, is_remote: bool) -> u64 {
    2 * u64::from(id.arbitration_order()) + u64::from(is_remote)
}
