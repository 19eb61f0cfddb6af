//! Every scenario that ships is found by its name, says what it shows, expects
//! something, and holds it.

mod rig;

use std::path::Path;

use rig::Rig;

#[test]
fn every_shipped_scenario_holds_what_it_expects() {
    let rig = Rig::new();
    let list = rig.hil_sim(&["run", "--list"]).expect_status(0).stdout;
    let names: Vec<&str> = list.lines().collect();
    assert!(names.len() >= 40, "only {names:?}");
    let mut arguments = vec!["run", "--no-log"];
    arguments.extend(&names);
    rig.hil_sim(&arguments).expect_status(0);
    for name in names {
        let summary = rig.summary(&format!("runs/{name}"));
        assert_eq!(summary["scenario"], name, "the file is named after its scenario");
        assert_ne!(summary["expectations"].as_array().map(Vec::len), Some(0), "{name} expects nothing");
    }
}

#[test]
fn every_shipped_scenario_says_what_it_shows() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    for entry in std::fs::read_dir(folder).expect("the scenarios are there") {
        let path = entry.expect("a readable folder").path();
        let text = std::fs::read_to_string(&path).expect("a text file");
        assert!(text.starts_with("# "), "{} does not begin with what it shows", path.display());
    }
}
