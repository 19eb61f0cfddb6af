//! The bounds of a bus budget against a simulated bus: arbitration never takes
//! longer than they say, and at its worst nearly as long.

mod any_robot;
mod robot;
mod wire;

use canloop::budget::response::{Stream, worst_case_responses};
use canloop::budget::{Budget, Row, Terms};
use canloop::schema::Profile;
use canloop::time::Duration;
use proptest::prelude::*;

use any_robot::any_robot;
use robot::{Queues, Robot, order};
use wire::{Chance, Frame, Wire};

/// Name of each drive that ships, its scenario's period and bit rate.
const SHIPPED: [(&str, i64, u32); 7] = [
    ("wheel_drive", 5_000, 500_000),
    ("cia402", 5_000, 500_000),
    ("odrive-0.6", 5_000, 1_000_000),
    ("odrive-0.5", 5_000, 1_000_000),
    ("vesc", 5_000, 500_000),
    ("damiao-dm4310", 5_000, 500_000),
    ("comma-body", 10_000, 500_000),
];
/// Other periods (us) and bit rates for all of them.
const OTHERS: [(i64, u32); 5] =
    [(2_000, 1_000_000), (3_000, 800_000), (5_000, 1_000_000), (10_000, 250_000), (20_000, 125_000)];
/// A bound may be above the worst that happens by this factor.
const TIGHT: f64 = 1.2;

fn terms(period_us: i64, bit_rate_bit_s: u32) -> Terms {
    let period = Duration::from_micros(period_us);
    Terms { period, bit_rate_bit_s, lateness: Duration::ZERO, answer: Duration::ZERO }
}

/// Every shipped profile at its own period and bit rate and at others.
fn configurations() -> impl Iterator<Item = (&'static str, Terms)> {
    SHIPPED.into_iter().flat_map(|(name, period_us, bit_rate)| {
        let all = [(period_us, bit_rate)].into_iter().chain(OTHERS);
        all.map(move |(period_us, bit_rate)| (name, terms(period_us, bit_rate)))
    })
}

#[test]
fn robots_on_a_bus_never_take_longer_than_their_budget() {
    let (mut judged, mut runs) = (0, 0);
    for (name, still) in configurations() {
        for (lateness_us, answer_us) in [(0, 0), (0, 20), (150, 100)] {
            let [lateness, answer] = [lateness_us, answer_us].map(Duration::from_micros);
            let terms = Terms { lateness, answer, ..still };
            let profile = Profile::builtin(name).unwrap();
            let budget = Budget::of(&profile, &terms);
            judged += 1;
            if !budget.exchange_holds() {
                continue;
            }
            for queues in [Queues::OfStackInTurn, Queues::Sorted, Queues::AllInTurn] {
                let robot = Robot::new(&profile, &terms, queues);
                for seed in 0..300 {
                    assert_within(&robot, &budget, queues, (name, seed));
                    runs += 1;
                }
            }
        }
    }
    assert!(runs > judged * 500, "most of them hold: {runs} runs of {judged} configurations");
}

#[track_caller]
fn assert_within(robot: &Robot, budget: &Budget, queues: Queues, of: (&str, u64)) {
    let seen = robot.run(&mut Chance::new(of.1));
    let exchange_ns = budget.exchange.unwrap().as_nanos();
    let terms = &budget.terms;
    assert!(seen.exchange_ns <= exchange_ns, "{of:?} {terms:?}: {} of {exchange_ns}", seen.exchange_ns);
    if queues == Queues::AllInTurn {
        // Messages of drives are taken to wait as mailboxes let them.
        return;
    }
    for (message, &seen_ns) in robot.traffic.iter().zip(&seen.responses_ns) {
        let row = budget.rows.iter().find(|row| (row.id, row.kind) == (message.id, message.kind)).unwrap();
        let bound_ns = row.response.map_or(i64::MAX, Duration::as_nanos);
        assert!(seen_ns <= bound_ns, "{of:?} {terms:?}: {} took {seen_ns} of {bound_ns}", row.name);
    }
}

#[test]
fn the_exchange_s_bound_is_nearly_reached() {
    for (name, terms) in configurations() {
        let profile = Profile::builtin(name).unwrap();
        let budget = Budget::of(&profile, &terms);
        if !budget.holds() {
            continue;
        }
        let robot = Robot::new(&profile, &terms, Queues::OfStackInTurn);
        let worst_ns = (0..3_000).map(|seed| robot.run(&mut Chance::new(seed)).exchange_ns).max().unwrap();
        let factor = budget.exchange.unwrap().as_nanos() as f64 / worst_ns as f64;
        assert!(factor <= TIGHT, "{name} {terms:?}: {factor}");
    }
}

#[test]
fn at_the_critical_instant_messages_take_nearly_as_long_as_they_may() {
    for (name, terms) in configurations() {
        let budget = Budget::of(&Profile::builtin(name).unwrap(), &terms);
        if !budget.holds() {
            continue;
        }
        // When the exchange takes most of the period, what drives send by their
        // own clocks could meet the ends of two in a row, for all that is known.
        let is_short = budget.exchange.unwrap() * 2 <= terms.period;
        for row in budget.rows.iter().filter(|row| is_short || row.is_of_exchange()) {
            let orders =
                [in_turn(&budget.rows, &Profile::builtin(name).unwrap(), &terms), budget.rows.iter().collect()];
            let worst_ns = orders.map(|rows| critical_instant_ns(&rows, row)).into_iter().max().unwrap();
            let bound_ns = row.response.unwrap().as_nanos();
            let factor = bound_ns as f64 / worst_ns as f64;
            assert!(worst_ns <= bound_ns, "{name} {terms:?}: {} took {worst_ns} of {bound_ns}", row.name);
            assert!(factor <= TIGHT, "{name} {terms:?}: {} {factor}", row.name);
        }
    }
}

/// The rows, the stack's among them as it queues them.
fn in_turn<'r>(rows: &'r [Row], profile: &Profile, terms: &Terms) -> Vec<&'r Row> {
    let find = |id, kind| rows.iter().find(|row| (row.id, row.kind) == (id, kind)).unwrap();
    profile.traffic(terms.period).iter().map(|message| find(message.id, message.kind)).collect()
}

/// How long `own` takes when all come at once, just after the longest frame
/// that is less urgent than whatever the stack has queued up to `own` has won
/// the bus. Rows that are not sorted wait in turn where they are the stack's.
fn critical_instant_ns(rows: &[&Row], own: &Row) -> i64 {
    let is_sorted = rows.is_sorted_by_key(|row| row.order());
    let in_turn = |row: &Row| !is_sorted && row.is_stack_s();
    let at = rows.iter().position(|row| row.order() == own.order()).unwrap();
    let before = |row: &&&Row| in_turn(own) && in_turn(row);
    let level = rows[..=at].iter().filter(before).map(|row| row.order()).fold(own.order(), u64::max);
    let lower = rows.iter().filter(|row| row.order() > level).map(|row| row.transmission.as_nanos());
    let mut wire = Wire::default();
    let blocker = Frame { order: u64::MAX, length_ns: lower.max().unwrap_or(0), queue: None };
    wire.queue(0, (usize::MAX, 0), blocker);
    for (index, row) in rows.iter().enumerate() {
        let frame =
            Frame { order: row.order(), length_ns: row.transmission.as_nanos(), queue: in_turn(row).then_some(0) };
        for turn in 0..8 {
            wire.queue(1 + turn * row.period.as_nanos(), (index, turn), frame);
        }
    }
    let ends = std::iter::from_fn(|| wire.next()).filter(|(_, (index, _))| *index == at);
    ends.map(|(end_ns, (_, turn))| end_ns - 1 - turn * own.period.as_nanos()).max().unwrap()
}

#[test]
fn the_second_instance_of_the_paper_s_example_is_seen_to_be_the_worst() {
    // Davis, Burns, Bril, Lukkien 2007, table 3: 125 bits at 125 kbit/s.
    let streams = [(2_500, 0), (3_500, 0), (3_500, 0)].map(|(period_us, jitter_us)| Stream {
        transmission: Duration::from_micros(1_000),
        period: Duration::from_micros(period_us),
        jitter: Duration::from_micros(jitter_us),
    });
    let bounds = worst_case_responses(&streams, Duration::from_micros(8));
    let seen = simulate(&streams, &mut Chance::new(0), true);
    assert_eq!(seen[2], 3_500_000);
    assert_eq!(bounds[2].unwrap().as_nanos(), 3_500_000);
}

/// The longest response of each of `streams`, which are in the order of their
/// priority: all at once, or as chance has it.
fn simulate(streams: &[Stream], chance: &mut Chance, at_once: bool) -> Vec<i64> {
    let mut wire = Wire::default();
    let longest_ns = streams.iter().map(|stream| stream.period.as_nanos()).max().unwrap();
    let mut due_ns = Vec::new();
    for (index, stream) in streams.iter().enumerate() {
        let period_ns = stream.period.as_nanos();
        let first_ns = if at_once { -stream.jitter.as_nanos() } else { chance.up_to(period_ns) };
        let frame = Frame { order: index as u64, length_ns: stream.transmission.as_nanos(), queue: None };
        let count = 4 * longest_ns / period_ns + 2;
        let due: Vec<i64> = (0..count).map(|turn| first_ns + turn * period_ns).collect();
        let mut queued_ns = i64::MIN;
        for (turn, &due_ns) in due.iter().enumerate() {
            let late_ns = if at_once { due_ns.max(0) } else { due_ns + chance.extreme(stream.jitter.as_nanos()) };
            // A sender does not overtake itself.
            queued_ns = late_ns.max(queued_ns);
            wire.queue(queued_ns, (index, turn as i64), frame);
        }
        due_ns.push(due);
    }
    let mut worst = vec![0; streams.len()];
    while let Some((end_ns, (index, turn))) = wire.next() {
        worst[index] = worst[index].max(end_ns - due_ns[index][turn as usize]);
    }
    worst
}

fn any_streams() -> impl Strategy<Value = Vec<Stream>> {
    // Bits at 500 kbit/s, 2 us each.
    let stream = (0_i64..=8, 300_i64..6_000, 0_i64..1_500).prop_map(|(bytes, period_us, jitter_us)| Stream {
        transmission: Duration::from_micros(2 * (55 + 10 * bytes)),
        period: Duration::from_micros(period_us),
        jitter: Duration::from_micros(jitter_us),
    });
    prop::collection::vec(stream, 2..9)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn messages_of_any_kind_never_take_longer_than_their_bounds(streams in any_streams(), seed: u64) {
        let bounds = worst_case_responses(&streams, Duration::from_micros(2));
        let mut chance = Chance::new(seed);
        for at_once in [true, false, false] {
            for (index, seen_ns) in simulate(&streams, &mut chance, at_once).into_iter().enumerate() {
                let bound_ns = bounds[index].map_or(i64::MAX, Duration::as_nanos);
                prop_assert!(seen_ns <= bound_ns, "message {index}: {seen_ns} of {bound_ns}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn robots_of_any_kind_never_take_longer_than_their_budget((profile, terms) in any_robot(), seed: u64) {
        let budget = Budget::of(&profile, &terms);
        if budget.exchange_holds() {
            for queues in [Queues::OfStackInTurn, Queues::Sorted, Queues::AllInTurn] {
                let robot = Robot::new(&profile, &terms, queues);
                for turn in 0..20 {
                    assert_within(&robot, &budget, queues, ("any", seed.wrapping_add(turn)));
                }
            }
        }
    }
}

#[test]
fn a_data_frame_goes_before_the_request_for_it() {
    let id = canloop::frame::CanId::Standard(0x29);
    assert!(order(id, false) < order(id, true));
}
