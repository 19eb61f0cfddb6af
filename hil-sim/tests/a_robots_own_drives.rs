//! A robot gives the node ids that its drives were set to, and what commands
//! say of those constants for which the profile lists several values. Both ends
//! of the bus and the log go by it, with the profile and the DBC as they ship.

mod rig;

use canloop::frame::CanId;
use canloop::time::Duration;
use hil_sim::scenario::Scenario;
use rig::{Rig, number, python};

const IDS: &str = "drive.node_ids={right=5,left=6}";
const MODE_4: &str = r#"drive.constants.Mode_Of_Operation="ProfileTorque""#;

/// Scenario and node ids for it, below and above its own, and in the other
/// order.
const MOVED: [(&str, &str); 6] = [
    ("dac-friction", "drive.node_ids={right=126,left=1}"),
    ("cia402", IDS),
    ("odrive-0.6", "drive.node_ids={right=12,left=3}"),
    ("odrive-0.5", "drive.node_ids.right=62"),
    ("vesc", "drive.node_ids={right=2,left=1}"),
    ("damiao-dm4310", "drive.node_ids={right=9,left=15}"),
];

/// How closely the path is kept to.
#[track_caller]
fn tracking(scenario: &str, overrides: &[&str]) -> serde_json::Value {
    let rig = Rig::new();
    rig.run(scenario, &[&["duration_s=31.0"], overrides].concat()).expect_status(0);
    let summary = rig.summary("runs");
    assert_eq!((&summary["state"], &summary["bus"]["lost"]), (&"running".into(), &0.into()), "{scenario}");
    assert!(number(&summary, "/tracking/max_m") > 1e-4, "{scenario} has not moved");
    summary["tracking"].clone()
}

#[test]
fn the_robot_keeps_to_its_path_as_before_whatever_the_node_ids() {
    for (scenario, node_ids) in MOVED {
        assert_eq!(tracking(scenario, &[node_ids]), tracking(scenario, &[]), "{scenario} with {node_ids}");
    }
}

#[test]
fn in_profile_torque_a_cia402_drive_tracks_as_in_cyclic_synchronous_torque() {
    assert_eq!(tracking("cia402", &[MODE_4, IDS]), tracking("cia402", &[]));
}

#[test]
fn the_bus_and_the_log_have_the_robot_s_ids_and_the_mode_that_it_asks_for() {
    let rig = Rig::new();
    let sets = ["duration_s=2.0", "expect=[]", IDS, MODE_4].map(|set| ["--set", set]);
    rig.hil_sim(&[&["run", "cia402"][..], sets.as_flattened()].concat()).expect_status(0);
    let told = python("messages_in_a_log.py", &[&rig.path("runs"), "cia402.dbc".as_ref()]);
    let told: Vec<&str> = told.lines().collect();
    let wanted = [
        "000 NMT Node: 5 6",
        "080 Sync",
        "185 RightTPDO1 Mode_Display: 4",
        "186 LeftTPDO1 Mode_Display: 4",
        "205 RightRPDO1 Mode_Of_Operation: 4",
        "206 LeftRPDO1 Mode_Of_Operation: 4",
        "285 RightTPDO2",
        "286 LeftTPDO2",
        "705 RightHeartbeat",
        "706 LeftHeartbeat",
    ];
    assert_eq!(told, wanted);
}

#[test]
fn what_is_received_and_what_loads_the_bus_has_the_robot_s_ids() {
    let overrides = [IDS.to_owned()];
    let scenario = Scenario::load("cia402", &overrides).unwrap_or_else(|problems| panic!("{problems}"));
    let profile = scenario.stack.profile;
    let mut ids: Vec<CanId> = profile.drive_ids().collect();
    ids.sort_by_key(|id| id.raw());
    let drives = [0x085, 0x086, 0x185, 0x186, 0x285, 0x286, 0x705, 0x706].map(CanId::Standard);
    assert_eq!(ids, drives);
    let traffic = profile.traffic(Duration::from_millis(5));
    assert!(traffic.iter().all(|sent| profile.dbc.message_by_id(sent.id).is_some()));
    assert!(traffic.iter().any(|sent| sent.id == CanId::Standard(0x205)));
}

#[test]
fn node_ids_and_constants_that_will_not_do_are_refused_with_their_place() {
    let table = [
        ("cia402", "drive.node_ids={right=5,left=5}", "1:30", "found 5, which the other wheel's drive has too"),
        ("cia402", "drive.node_ids.right=2", "1:22", "found 2, which the other wheel's drive has too"),
        ("cia402", "drive.node_ids.right=128", "1:22", "found 128, expected a whole number from 0 to 127"),
        ("cia402", "drive.node_ids.right=1.5", "1:22", "found 1.5, expected a whole number from 0 to 127"),
        ("cia402", "drive.node_ids.left=0", "1:21", "gives LeftEmergency the id 080, which is that of Sync"),
        ("cia402", "drive.node_ids.middle=3", "1:16", "found `middle`, expected one of `left`, `right`"),
        ("cia402", "drive.node_ids=3", "1:16", "found 3, expected a table"),
        ("dac-friction", "drive.node_ids.left=128", "1:21", "expected a whole number from 0 to 127"),
        ("odrive-0.6", "drive.node_ids.right=63", "1:22", "found 63, which means all nodes"),
        ("damiao-dm4310", "drive.node_ids.right=16", "1:22", "expected a whole number from 0 to 15"),
        ("comma-body", "drive.node_ids.right=3", "1:16", "the profile `comma-body` carry none"),
        ("cia402", "drive.constants.Mode=4", "1:22", "found no such constant"),
        ("cia402", "drive.constants.Mode_Of_Operation=\"Position\"", "1:35", "\"CyclicSynchronousTorque\" or"),
        ("cia402", "drive.constants.Mode_Of_Operation=[]", "1:35", "found an array, expected a name"),
        ("cia402", "drive.constants.Mode_Of_Operation=true", "1:35", "found true"),
        ("cia402", "drive.constants=3", "1:17", "found 3, expected a table"),
        ("vesc", "drive.constants.x=3", "1:19", "commands of the profile `vesc` have none"),
    ];
    for (scenario, set, place, words) in table {
        let rig = Rig::new();
        let run = rig.run(scenario, &[set]).expect_status(2);
        assert_eq!(run.stderr.matches("error: ").count(), 1, "one message, please:\n{}", run.stderr);
        for part in [&format!("--set:{place}"), words] {
            assert!(run.stderr.contains(part), "{set}: {part} is missing in\n{}", run.stderr);
        }
        assert!(rig.files().is_empty(), "something was left behind");
    }
}
