//! The text of a drive profile, over the DBC that ships.

use std::path::Path;

use canloop::config::{Document, Problems, Source};
use canloop::schema::{Command, Feedback, Message, Profile};
use canloop::wheels::Wheel;

use crate::harness::{Target, digest, seeds_in};

const WORDS: [&str; 24] = [
    "[wheels]\n",
    "[sync]\n",
    "[command]\n",
    "[feedback]\n",
    "[heartbeat]\n",
    "[fault]\n",
    "[crc]\n",
    "[values.state]\n",
    "message = ",
    "\"{node}Command\"",
    "\"Torque\"",
    "\"Position\"",
    "\"Counter\"",
    "\"Crc\"",
    "node_id_mask = ",
    "timeout_periods = ",
    "id = ",
    "polynomial = ",
    "{ node = \"Right\", id = 1 }",
    "=",
    "\"",
    "[[",
    "]]",
    "\n",
];

#[test]
fn profile_toml() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut seeds = seeds_in(&root.join("tests/fuzz/seeds/profile"));
    seeds.push(std::fs::read(root.join("dbc/wheel_drive.toml")).expect("a seed"));
    let dbc = Source::new("wheel_drive.dbc", include_str!("../../dbc/wheel_drive.dbc"));
    Target { name: "profile_toml", seeds, words: &WORDS, share: 1.0 }.fuzz(|input| {
        let parsed = Document::parse("fuzz.toml", String::from_utf8_lossy(input))
            .map_err(Problems::from)
            .and_then(|document| Profile::parse(&document, &dbc));
        match parsed {
            Ok(profile) => exercise(&profile),
            Err(problems) => {
                assert!(problems.0.iter().all(|problem| problem.position().is_some()));
                assert!(!problems.to_string().is_empty());
                let titles: Vec<_> = problems.0.iter().map(|problem| problem.title.as_str()).collect();
                digest(titles.join("\n").as_bytes())
            }
        }
    });
}

/// Sends what a stack and its drives send.
fn exercise(profile: &Profile) -> u64 {
    let mut outcome = String::new();
    for wheel in Wheel::BOTH {
        let command = Command { torque_nm: f64::MAX, ..Command::default() };
        for message in [Message::Command(wheel, command), Message::Feedback(wheel, Feedback::default())] {
            let frame = profile.encode(&message);
            outcome += &format!("{} {:?}\n", frame.len(), profile.decode(&frame).is_ok());
        }
    }
    digest(outcome.as_bytes())
}
