//! JUnit's XML, as Jenkins, GitLab and their kin read it: a suite for each
//! scenario, a case for each of its expectations.

use canloop::report::Markup;

use crate::expect::Verdict;
use crate::summary::Summary;

/// One run, and how long it took by the clock, s.
pub type Timed = (Summary, f64);

/// The whole file.
pub fn junit(runs: &[Timed]) -> String {
    let tests: usize = runs.iter().map(|(summary, _)| cases(summary).len()).sum();
    let failures: usize = runs.iter().map(|(summary, _)| failures(summary)).sum();
    let time_s: f64 = runs.iter().map(|(_, elapsed_s)| elapsed_s).sum();
    let mut out = Markup::default();
    out.trusted("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    out.open(
        "testsuites",
        &[
            ("name", "hil-sim"),
            ("tests", &tests.to_string()),
            ("failures", &failures.to_string()),
            ("errors", "0"),
            ("time", &seconds(time_s)),
        ],
    );
    runs.iter().for_each(|run| write_suite(run, &mut out));
    out.close("testsuites");
    out.finish()
}

/// What becomes a case: a name, and what went wrong where something did.
struct Case<'s> {
    name: &'s str,
    failure: Option<(&'s str, String)>,
}

/// A run that expects nothing, or that ended early, is a case of its own.
fn cases(summary: &Summary) -> Vec<Case<'_>> {
    let mut cases: Vec<_> = summary.expectations.iter().map(|verdict| case(summary, verdict)).collect();
    let ended_early = !summary.passed && summary.expectations.iter().all(|verdict| verdict.passed);
    if cases.is_empty() || ended_early {
        let failure = || (summary.end, format!("the run ended early: {}\n{}\n", summary.end, summary.reproduce_line()));
        cases.push(Case { name: "the run", failure: (!summary.passed).then(failure) });
    }
    cases
}

fn case<'s>(summary: &'s Summary, verdict: &'s Verdict) -> Case<'s> {
    let text = || {
        let lines: String = verdict.lines_around().map(|line| line + "\n").collect();
        format!("{}\n{}\n{lines}reproduce: {}\n", verdict.claim, verdict.result, summary.reproduce_line())
    };
    let failure = (!verdict.passed).then(|| (verdict.result.as_str(), text()));
    Case { name: verdict.title(), failure }
}

fn failures(summary: &Summary) -> usize {
    cases(summary).iter().filter(|case| case.failure.is_some()).count()
}

fn write_suite((summary, elapsed_s): &Timed, out: &mut Markup) {
    let cases = cases(summary);
    out.open(
        "testsuite",
        &[
            ("name", &summary.scenario),
            ("tests", &cases.len().to_string()),
            ("failures", &failures(summary).to_string()),
            ("errors", "0"),
            ("skipped", "0"),
            ("time", &seconds(*elapsed_s)),
        ],
    );
    out.open("properties", &[]);
    let seed = summary.seed.to_string();
    let properties = [
        ("seed", seed.as_str()),
        ("frames_blake3", &summary.frames_blake3),
        ("version", summary.version),
        ("reproduce", summary.reproduce_line()),
    ];
    for (name, value) in properties {
        out.empty("property", &[("name", name), ("value", value)]);
    }
    out.close("properties");
    // All cases come from one run, so each is said to have taken its share of it.
    let share = seconds(elapsed_s / cases.len() as f64);
    for case in &cases {
        let attributes = [("name", case.name), ("classname", &summary.scenario), ("time", &share)];
        match &case.failure {
            None => out.empty("testcase", &attributes),
            Some((message, text)) => {
                out.open("testcase", &attributes);
                out.leaf("failure", &[("message", message), ("type", "expectation")], text);
                out.close("testcase");
            }
        }
    }
    out.close("testsuite");
}

fn seconds(time_s: f64) -> String {
    format!("{time_s:.3}")
}
