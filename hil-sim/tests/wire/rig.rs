//! A bus to send on and to listen to, and a stack on a far side whose bus goes
//! wrong when the test wants it.

use canloop::bus::BitRates;
use canloop::bus::ControllerState;
use canloop::event::BusFrame;
use canloop::frame::{CanId, Frame};
use canloop::safety::{Operator, Reason, State};
use canloop::stack::Stack;
use canloop::time::Instant;
use hil_sim::far_side::{FarSide, Happening, Synced};
use hil_sim::scenario::{Link, Scenario};
use hil_sim::wire::{Crossing, Fault, FaultId, Node, Wire};

/// A bit takes a microsecond.
pub const RATES: BitRates = BitRates::both(1_000_000);

pub fn wire() -> Wire {
    Wire::new(RATES, 1)
}

pub fn frame(id: u16) -> Frame {
    Frame::classic(CanId::Standard(id), &[0x55; 4])
}

pub fn us(us: i64) -> Instant {
    Instant::from_nanos(1_000 * us)
}

pub fn length_us(frame: &Frame) -> i64 {
    RATES.frame(frame).as_nanos() / 1_000
}

/// All that crosses until then.
pub fn until(wire: &mut Wire, end: Instant) -> Vec<Crossing> {
    let mut crossed = Vec::new();
    while wire.next_event().is_some_and(|at| at <= end) {
        crossed.extend(wire.advance());
    }
    crossed
}

/// Sender, id and end of each, us.
pub fn seen(wire: &mut Wire, end: Instant) -> Vec<(Node, u32, i64)> {
    let of = |crossing: &Crossing| (crossing.sender, crossing.frame.id.raw(), crossing.at.as_nanos() / 1_000);
    until(wire, end).iter().map(of).collect()
}

pub fn ids(wire: &mut Wire, end: Instant) -> Vec<u32> {
    seen(wire, end).into_iter().map(|(_, id, _)| id).collect()
}

/// A stack and its far side, in lock-step.
pub struct Loop {
    pub stack: Stack,
    pub far_side: FarSide,
    /// All that crossed, with its moment.
    pub frames: Vec<(Instant, BusFrame)>,
    /// The frames that the stack could not hear.
    pub unheard: usize,
    pub controller: Vec<ControllerState>,
    pub last: Option<Synced>,
    pub steps: u64,
}

impl Loop {
    pub fn new(scenario: &str, overrides: &[&str]) -> Self {
        let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
        let scenario = Scenario::load(scenario, &overrides).expect("a good scenario");
        let Link::Can(rates) = scenario.link else { panic!("it has a bus") };
        let mut stack = Stack::new(&scenario.stack, Instant::ZERO);
        stack.operate(Operator::Enable);
        Self {
            far_side: FarSide::new(&scenario, rates, Instant::ZERO),
            stack,
            frames: Vec::new(),
            unheard: 0,
            controller: Vec::new(),
            last: None,
            steps: 0,
        }
    }

    pub fn begin(&mut self, fault: Fault) -> FaultId {
        self.far_side.begin_fault(fault)
    }

    pub fn run(&mut self, periods: u64) -> &mut Self {
        (0..periods).for_each(|_| self.step());
        self
    }

    /// One period. It must end, the plant must have moved on by one, and time
    /// must not go back.
    pub fn step(&mut self) {
        let now = self.stack.next_wakeup();
        self.stack.handle_wakeup(now);
        self.hand_over();
        let (mut answered, mut synced_count) = (0, 0);
        while let Some((at, happening)) = self.far_side.poll() {
            match happening {
                Happening::Marked(_) => {}
                Happening::Frame(crossed) => {
                    self.tell(at, crossed);
                    if !crossed.sent_by_stack {
                        self.stack.handle_frame(now, &crossed.frame);
                        self.hand_over();
                    }
                }
                Happening::Unheard(crossed) => {
                    self.unheard += 1;
                    self.tell(at, crossed);
                }
                Happening::Synced(synced) => {
                    synced_count += 1;
                    self.last = Some(synced);
                }
                Happening::Controller(state) => self.controller.push(state),
                Happening::Answered(state) => {
                    answered += 1;
                    if state == ControllerState::BusOff {
                        self.stack.trip(Reason::BusOff);
                    }
                }
            }
            while self.stack.poll_event().is_some() {}
        }
        assert_eq!((answered, synced_count), (1, 1), "a step ends once and moves the plant once");
        assert_eq!(self.last.map(|synced| synced.tick), Some(self.steps), "the plant's time is the stack's");
        self.steps += 1;
    }

    /// Whether a SYNC has begun the last period.
    pub fn is_heard(&self) -> bool {
        self.last.is_some_and(|synced| synced.is_heard)
    }

    pub fn is_tripped(&self) -> bool {
        matches!(self.stack.state(), State::Tripped(_))
    }

    fn hand_over(&mut self) {
        while let Some(frame) = self.stack.poll_transmit() {
            self.far_side.take(frame);
        }
    }

    fn tell(&mut self, at: Instant, crossed: BusFrame) {
        assert!(self.frames.last().is_none_or(|&(before, _)| before <= at), "time goes back to {at:?}");
        self.frames.push((at, crossed));
    }
}
