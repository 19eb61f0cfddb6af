//! On every kind of drive that ships, the paper's robot keeps to its path with
//! friction, as closely as README.md says.

mod rig;

use rig::drives::{DRIVES, Promise};
use rig::{Rig, number};

#[test]
fn the_robot_keeps_to_its_path_on_every_kind_of_drive() {
    for Promise { scenario, max_after_30s_m, chatter_nm } in DRIVES {
        let rig = Rig::new();
        let run = rig.run(scenario, &[]).expect_status(0);
        let summary = rig.summary("runs");
        assert_eq!(summary["state"], "running", "{scenario}: {}", run.stdout);
        assert_eq!(summary["bus"]["lost"], 0, "{scenario}");
        assert!(number(&summary, "/tracking/max_m") > 1e-4, "{scenario} has not moved");
        assert!(number(&summary, "/tracking/max_after_30s_m") <= max_after_30s_m, "{scenario}: {summary}");
        assert!(number(&summary, "/torque/chatter_nm") <= chatter_nm, "{scenario}: {summary}");
    }
}

#[test]
fn every_profile_that_ships_has_a_row_here() {
    let mut driven: Vec<String> = DRIVES
        .iter()
        .map(|Promise { scenario, .. }| {
            hil_sim::scenario::Scenario::load(scenario, &[]).expect("a good scenario").stack.profile.name
        })
        .collect();
    let mut shipped: Vec<String> = canloop::schema::Profile::builtin_names().map(str::to_owned).collect();
    driven.sort();
    shipped.sort();
    assert_eq!(driven, shipped);
}
