//! What happens to a robot on its way, at its moment: `[[event]]` of a
//! scenario.
//!
//! What lasts is worked out anew whenever it changes, from all events that are
//! going on: two pushes add up, and when one ends the other is still there.
//! What happens once, such as a fault, happens when its event begins.

mod condition;
mod contradiction;
mod effects;
mod read;
mod read_bus;
mod what;

use canloop::event::Mark;
use canloop::path::Path;
use canloop::safety::Operator;
use canloop::time::Instant;
use canloop::wheels::Wheels;

use crate::plant::State;
use crate::virtual_robot::VirtualRobot;
use crate::wire::{FaultId, Wire};

pub use condition::Condition;
use effects::Effects;
pub use read::read_events;
pub use what::{Region, What};

/// An event as a scenario plans it.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// Its name, for logs and expectations.
    pub name: String,
    /// When it begins.
    pub start: Start,
    /// For how long it goes on, s; without end where there is none.
    pub lasts_s: Option<f64>,
    /// How often it comes again, s, if it does.
    pub every_s: Option<f64>,
    /// What happens.
    pub what: What,
}

/// When an event begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// So long after the run began, s.
    At(f64),
    /// When this first holds.
    When(Condition),
}

/// Where it happens.
pub struct Stage<'s> {
    /// Drives and plant.
    pub robot: &'s mut VirtualRobot,
    /// The bus.
    pub wire: &'s mut Wire,
    /// The moment that it stands at.
    pub now: Instant,
}

/// The events of a run, as it goes on.
#[derive(Clone, Debug)]
pub struct Timeline {
    entries: Vec<Entry>,
    /// The robot without them.
    effects: Effects,
}

#[derive(Clone, Debug)]
struct Entry {
    planned: Planned,
    /// When it begins next, if it ever does.
    next: Option<Start>,
    /// When it ends, if it is going on.
    until_s: Option<f64>,
    /// What it remembers of its beginning, by wheel: encoder counts.
    counts: Wheels<i64>,
    /// What it does to the bus, while it is going on.
    fault: Option<FaultId>,
    /// The row of chance for its next beginning.
    row: u64,
}

impl Timeline {
    /// The events that are `planned` for `robot`, which is as it is without them.
    pub fn new(planned: &[Planned], robot: &VirtualRobot) -> Self {
        let entry = |(nth, event): (usize, &Planned)| {
            let namesakes = planned[..nth].iter().filter(|other| other.name == event.name).count();
            Entry::new(event.clone(), row_of_chance(&event.name, namesakes))
        };
        Self { entries: planned.iter().enumerate().map(entry).collect(), effects: Effects::of(robot) }
    }

    /// Whether nothing will ever happen.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Lets happen what is due `t_s` after the run began, and tells what begins
    /// and ends. To be called at the beginning of each period.
    pub fn go_on(&mut self, t_s: f64, stage: &mut Stage<'_>, mut tell: impl FnMut(Mark)) {
        if self.entries.is_empty() {
            return;
        }
        for (index, entry) in self.entries.iter_mut().enumerate() {
            let mut mark = |has_begun| tell(Mark { event: index as u16, has_begun });
            if entry.ends(t_s) {
                mark(false);
                if let Some(fault) = entry.fault.take() {
                    stage.wire.end(stage.now, fault);
                }
            }
            if entry.begins(t_s, stage.robot.state()) {
                mark(true);
                entry.planned.what.begin(stage.robot);
                entry.counts = stage.robot.encoder_counts();
                let fault = entry.planned.what.bus_fault();
                entry.fault = fault.map(|fault| stage.wire.begin_in_row(stage.now, fault, entry.row));
                entry.row = entry.row.wrapping_add(1);
            }
        }
        let going_on = self.entries.iter().filter(|entry| entry.until_s.is_some());
        going_on.clone().for_each(|entry| entry.planned.what.strike(stage.robot));
        self.effects.lay(going_on.map(|entry| (&entry.planned.what, entry.counts)), stage.robot);
    }
}

impl Planned {
    /// The path that the operator wants followed then, if there is one.
    pub const fn new_path(&self) -> Option<&Path> {
        match &self.what {
            What::NewPath(path) => Some(path),
            _ => None,
        }
    }

    /// What the operator wants then, if it is he who acts.
    pub const fn operator(&self) -> Option<Operator> {
        match self.what {
            What::Operator(wish) => Some(wish),
            _ => None,
        }
    }
}

/// So close before a moment, s, is at it: times are sums of periods.
const CLOSE_S: f64 = 1e-9;

impl Entry {
    fn new(planned: Planned, row: u64) -> Self {
        Self { next: Some(planned.start), planned, until_s: None, counts: Wheels::default(), fault: None, row }
    }

    fn ends(&mut self, t_s: f64) -> bool {
        self.until_s.take_if(|until_s| t_s >= *until_s - CLOSE_S).is_some()
    }

    fn begins(&mut self, t_s: f64, state: &State) -> bool {
        let begun_s = match self.next {
            Some(Start::At(at_s)) if t_s >= at_s - CLOSE_S => at_s,
            Some(Start::When(condition)) if condition.holds(state) => t_s,
            _ => return false,
        };
        self.until_s = Some(self.planned.lasts_s.map_or(f64::INFINITY, |lasts_s| begun_s + lasts_s));
        self.next = self.planned.every_s.map(|every_s| Start::At(begun_s + every_s));
        true
    }
}

/// Where the chance of an event begins: by its name, so that another event in
/// the scenario changes nothing for this one. FNV-1a of 64 bits.
fn row_of_chance(name: &str, namesakes: usize) -> u64 {
    let mixed = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01B3);
    let row = name.as_bytes().iter().fold(0xCBF2_9CE4_8422_2325, mixed);
    row.wrapping_add((namesakes as u64) << 32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Periods of 0.1 s in which it begins and ends, of the first twenty.
    fn times(start: Start, lasts_s: Option<f64>, every_s: Option<f64>) -> (Vec<u32>, Vec<u32>) {
        let what = What::Operator(Operator::Stop);
        let mut entry = Entry::new(Planned { name: "it".to_owned(), start, lasts_s, every_s, what }, 0);
        let (mut begins, mut ends) = (Vec::new(), Vec::new());
        for tick in 0..20 {
            let mut state = State::default();
            state.pose.x_m = f64::from(tick);
            if entry.ends(f64::from(tick) * 0.1) {
                ends.push(tick);
            }
            if entry.begins(f64::from(tick) * 0.1, &state) {
                begins.push(tick);
            }
        }
        (begins, ends)
    }

    #[test]
    fn it_begins_once_at_its_moment() {
        assert_eq!(times(Start::At(0.3), None, None), (vec![3], vec![]));
        assert_eq!(times(Start::At(0.31), None, None), (vec![4], vec![]), "not before its moment");
        assert_eq!(times(Start::At(9.0), None, None), (vec![], vec![]));
    }

    #[test]
    fn it_ends_after_its_span_and_comes_again_where_it_is_to() {
        assert_eq!(times(Start::At(0.3), Some(0.5), None), (vec![3], vec![8]));
        assert_eq!(times(Start::At(0.3), Some(0.2), Some(0.7)), (vec![3, 10, 17], vec![5, 12, 19]));
        assert_eq!(times(Start::At(0.3), Some(0.7), Some(0.7)), (vec![3, 10, 17], vec![10, 17]));
    }

    #[test]
    fn a_condition_begins_it_once() {
        let condition = Condition::parse("x_m > 4").expect("a condition");
        assert_eq!(times(Start::When(condition), Some(0.3), None), (vec![5], vec![8]));
        assert_eq!(times(Start::When(condition), None, Some(1.0)), (vec![5, 15], vec![]));
    }
}
