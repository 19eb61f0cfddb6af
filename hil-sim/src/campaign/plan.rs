//! What a campaign tries: kinds of faults, moments, sizes, scenarios, seeds,
//! all crossed.

use canloop::config::{Bound, Document, Problems, Reader, Section};

use super::judge::Invariants;

/// A campaign.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Its name.
    pub name: String,
    /// What must hold in each of its runs.
    pub invariants: Invariants,
    /// Its runs.
    pub cases: Vec<Case>,
}

/// One run of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The scenario's name, or its path.
    pub scenario: String,
    /// The kind of fault.
    pub kind: String,
    /// What is laid over the scenario.
    pub overrides: Vec<String>,
}

/// The campaigns that ship with the program, by name.
pub const SHIPPED: &[(&str, &str)] = &[("faults", include_str!("../../campaigns/faults.toml"))];

/// More runs than anybody waits for.
const MOST_CASES: usize = 1_000_000;

impl Plan {
    /// Loads a shipped campaign by its name, or a file by its path.
    pub fn load(name_or_path: &str) -> Result<Self, Problems> {
        let document = Document::open(name_or_path, SHIPPED)?;
        let reader = Reader::new(&document);
        let plan = Self::read(&reader.root());
        reader.finish(plan)
    }

    fn read(root: &Section<'_>) -> Self {
        let name = root.text("name");
        let scenarios = root.texts("scenarios");
        let duration_s = root.number("duration_s", Bound::Within(1e-3, 1e6));
        let moments = root.literals("moments_s");
        if moments.is_empty() {
            root.complain("moments_s", "found no moment, expected at least one");
        }
        let seeds = root.integer_or("seeds", 1, 1, 10_000);
        let mut common = root.texts("set");
        common.extend([format!("duration_s={duration_s:?}"), "expect=[]".to_owned()]);
        let events: Vec<(String, String)> = root.sections("fault").iter().flat_map(crossed).collect();
        let count = scenarios.len() * events.len() * moments.len() * seeds as usize;
        if count == 0 || count > MOST_CASES {
            root.complain("name", &format!("found {count} runs in all, expected 1 to {MOST_CASES}"));
        }
        let mut cases = Vec::new();
        for scenario in &scenarios {
            for (kind, event) in &events {
                for moment in moments.iter().take(MOST_CASES) {
                    for seed in 1..=seeds {
                        let event = format!("event=[{{ at_s = {moment}, {event} }}]");
                        let own = [format!("seed={seed}"), event];
                        let overrides = common.iter().cloned().chain(own).collect();
                        cases.push(Case { scenario: scenario.clone(), kind: kind.clone(), overrides });
                    }
                }
            }
        }
        Self { name, invariants: Invariants::read(&root.section("invariants")), cases }
    }
}

/// A fault's kinds and the text of its event, for each combination of values
/// where several are listed.
fn crossed(fault: &Section<'_>) -> Vec<(String, String)> {
    let mut combinations = vec![(String::new(), String::new())];
    for key in fault.keys() {
        let values = fault.literals(key);
        let with = |(kind, text): &(String, String), value: &String| {
            let kind = if key == "kind" { value.trim_matches('"').to_owned() } else { kind.clone() };
            let comma = if text.is_empty() { "" } else { ", " };
            (kind, format!("{text}{comma}{key} = {value}"))
        };
        combinations = combinations
            .iter()
            .flat_map(|combination| values.iter().map(move |value| with(combination, value)))
            .collect();
    }
    if combinations.iter().any(|(kind, _)| kind.is_empty()) {
        fault.text("kind");
    }
    combinations
}
