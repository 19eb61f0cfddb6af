//! CONTRIBUTING.md shows how a drive is added: its files, taken from there as
//! they stand, drive the robot.

mod rig;

use rig::Rig;

const CONTRIBUTING: &str = include_str!("../../CONTRIBUTING.md");

/// The blocks of this language, in order.
fn blocks(language: &str) -> Vec<&'static str> {
    let fence = format!("```{language}\n");
    let begun = CONTRIBUTING.split(&fence).skip(1).map(|rest| rest.split("```").next());
    begun.map(|block| block.expect("a block has an end")).collect()
}

#[test]
fn the_drive_that_contributing_shows_is_driven_and_impersonated() {
    let rig = Rig::new();
    let ([dbc], [profile, scenario]) = (&blocks("dbc")[..], &blocks("toml")[..]) else { panic!("other blocks") };
    for (name, text) in [("acme.dbc", dbc), ("acme.toml", profile), ("acme-robot.toml", scenario)] {
        rig.write(name, text);
    }
    rig.run("acme-robot.toml", &[]).expect_status(0);
    let summary = rig.summary("runs");
    assert_eq!(summary["state"], "running");
    assert_eq!(summary["passed"], true);
}
