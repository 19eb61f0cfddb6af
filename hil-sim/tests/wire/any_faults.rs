//! Whatever is wrong with the bus, nothing panics and time goes on.

use canloop::frame::{CanId, Frame};
use canloop::time::Duration;
use hil_sim::wire::{BurstyLoss, Damage, Fault, Node, Nodes, Pick};
use proptest::prelude::*;

use crate::rig::Loop;

fn node() -> impl Strategy<Value = Node> {
    prop::sample::select(Node::ALL.to_vec())
}

fn nodes() -> impl Strategy<Value = Nodes> {
    prop::collection::vec(node(), 0..4).prop_map(|nodes| nodes.into_iter().collect())
}

/// Nonsense among it.
fn probability() -> impl Strategy<Value = f64> {
    prop_oneof![0.0..1.0, prop::sample::select(vec![0.0, 1.0, -1.0, 2.0, 1e-4, f64::NAN, f64::INFINITY])]
}

fn duration() -> impl Strategy<Value = Duration> {
    prop_oneof![(0_i64..20_000).prop_map(Duration::from_micros), Just(Duration::from_nanos(-5))]
}

fn frame() -> impl Strategy<Value = Frame> {
    let id = prop_oneof![
        prop::sample::select(vec![0_u16, 0x80, 0x7FF]).prop_map(CanId::Standard),
        (0_u16..0x800).prop_map(CanId::Standard),
        (0_u32..0x2000_0000).prop_map(CanId::Extended),
    ];
    (id, prop::collection::vec(any::<u8>(), 0..=8)).prop_map(|(id, payload)| Frame::classic(id, &payload))
}

fn pick() -> impl Strategy<Value = Pick> {
    let id = prop::option::of(frame().prop_map(|frame| frame.id));
    (id, prop::option::of(node()), probability(), prop::option::of(0_u32..10))
        .prop_map(|(id, sender, probability, count)| Pick { id, sender, probability, count })
}

fn fault() -> impl Strategy<Value = Fault> {
    let channel = (probability(), probability(), probability(), probability()).prop_map(
        |(turns_bad, turns_good, lost_when_good, lost_when_bad)| BurstyLoss {
            turns_bad,
            turns_good,
            lost_when_good,
            lost_when_bad,
        },
    );
    let damage = prop::sample::select(vec![Damage::Caught, Damage::Uncaught]);
    prop_oneof![
        pick().prop_map(Fault::Drop),
        (pick(), duration()).prop_map(|(pick, by)| Fault::Delay(pick, by)),
        (pick(), prop_oneof![0_u32..5, Just(u32::MAX)]).prop_map(|(pick, copies)| Fault::Duplicate(pick, copies)),
        pick().prop_map(Fault::Reorder),
        (pick(), damage, nodes()).prop_map(|(pick, damage, at)| Fault::Corrupt(pick, damage, at)),
        node().prop_map(Fault::Silence),
        (frame(), prop::option::of(duration())).prop_map(|(frame, every)| Fault::Babble(frame, every)),
        node().prop_map(Fault::BusOff),
        pick().prop_map(Fault::NoAcknowledge),
        nodes().prop_map(Fault::Cut),
        probability().prop_map(Fault::BitErrors),
        channel.prop_map(Fault::BurstyLoss),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    /// The rig looks that each step ends and that time never goes back.
    #[test]
    fn steps_end_under_any_faults(
        scenario in prop::sample::select(vec!["dac-friction", "cia402", "odrive-0.6", "vesc", "comma-body"]),
        faults in prop::collection::vec((0_u64..20, fault(), 1_u64..40), 1..6),
    ) {
        let mut rig = Loop::new(scenario, &[]);
        let mut ends = Vec::new();
        for (wait, fault, last) in faults {
            rig.run(wait);
            ends.push((rig.steps + last, rig.begin(fault)));
            ends.retain(|&(at, id)| at > rig.steps || !rig.far_side.end_fault(id));
        }
        rig.run(20);
        for (_, id) in ends {
            rig.far_side.end_fault(id);
            rig.run(1);
        }
        rig.run(60);
        prop_assert!(rig.is_heard());
    }
}
