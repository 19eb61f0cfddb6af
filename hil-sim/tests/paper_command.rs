//! `hil-sim paper` reproduces the paper in one go: a table, a page that opens
//! offline, and pictures.

mod rig;

use rig::{Rig, files_in, read_json};

#[test]
fn the_paper_s_table_page_and_pictures_come_from_one_command() {
    let rig = Rig::new();
    let run = rig.hil_sim(&["paper", "--out", "out"]).expect_status(0);
    assert_eq!(rig.files(), ["out"]);
    every_controller_has_its_rows(&run.stdout);
    the_page_opens_offline(&std::fs::read_to_string(rig.path("out/report.html")).expect("the report"));
    the_pictures_are_svg(&rig);
    let all = read_json(&rig.path("out/paper.json"));
    assert_eq!(all.as_array().map(Vec::len), Some(rows(&run.stdout).len()));
    assert!(run.stdout.contains("out/report.html"), "{}", run.stdout);
}

fn every_controller_has_its_rows(stdout: &str) {
    let heading = stdout.lines().next().expect("a table");
    for column in ["controller", "friction", "link", "rms", "max", "final"] {
        assert!(heading.contains(column), "{heading}");
    }
    let rows = rows(stdout);
    for controller in ["dac", "dac-matched", "pi-speed", "pi-angle"] {
        for friction in ["none", "paper"] {
            for link in ["ideal", "CAN"] {
                let row = [controller, friction, link];
                assert!(rows.iter().any(|found| found[..3] == row), "no row {row:?} in\n{stdout}");
            }
        }
    }
    let outcome = |controller: &str, friction: &str, link: &str| {
        let row = rows.iter().find(|found| found[..3] == [controller, friction, link]);
        row.and_then(|row| row.last().copied()).expect("a row")
    };
    assert_eq!(outcome("dac", "paper", "ideal"), "tracks");
    assert_eq!(outcome("pi-speed", "paper", "ideal"), "drifts");
    assert_eq!(outcome("pi-angle", "none", "ideal"), "diverges");
    assert_eq!(outcome("dac-matched", "paper", "CAN"), "tracks");
    assert!(["rings", "trips"].contains(&outcome("dac", "paper", "CAN")));
}

/// The words of each row of the table.
fn rows(stdout: &str) -> Vec<Vec<&str>> {
    stdout.lines().skip(1).take_while(|line| !line.is_empty()).map(|line| line.split_whitespace().collect()).collect()
}

fn the_page_opens_offline(html: &str) {
    assert!(html.starts_with("<!DOCTYPE html>") || html.starts_with("<!doctype html>"));
    assert!(html.trim_end().ends_with("</html>"));
    assert!(html.matches("<svg").count() >= 24, "the figures are in the page");
    for (index, _) in html.match_indices("://") {
        let before = &html[..index];
        let attribute = before.rsplit(['"', '\'']).nth(1).unwrap_or("");
        assert!(attribute.trim_end().ends_with("xmlns="), "the page asks for something: {attribute}");
    }
    for outside in ["<link", "<script src", "<iframe", "@import", "url(http"] {
        assert!(!html.contains(outside), "the page has {outside}");
    }
    for word in ["dac-matched", "pi-angle", "z^2 - z + 1", "hil-sim run dac-friction"] {
        assert!(html.contains(word), "the page says nothing of {word}");
    }
}

fn the_pictures_are_svg(rig: &Rig) {
    let files = files_in(&rig.path("out"));
    let pictures: Vec<_> = files.iter().filter(|name| name.ends_with(".svg")).collect();
    // Figures 5 and 6: x, y, heading and track, for several controllers each.
    for wanted in ["figure-5a-x.svg", "figure-5a-y.svg", "figure-5a-heading.svg", "figure-5a-track.svg"] {
        assert!(files.iter().any(|name| name == wanted), "{wanted} is not in {files:?}");
        let other = wanted.replace("figure-5", "figure-6");
        assert!(files.contains(&other), "{other} is not in {files:?}");
    }
    for name in pictures {
        let text = std::fs::read_to_string(rig.path("out").join(name)).expect("a picture");
        let document = roxmltree::Document::parse(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
        let root = document.root_element();
        assert_eq!(root.tag_name().name(), "svg", "{name}");
        assert!(root.descendants().any(|node| ["path", "polyline"].contains(&node.tag_name().name())), "{name}");
        assert!(!text.contains("NaN") && !text.contains("inf"), "{name}");
    }
}
