//! Annotations that GitHub shows beside a file's lines: workflow commands on
//! standard output.

use std::path::Path;

use crate::expect::Verdict;
use crate::summary::Summary;

/// One line for each expectation that did not hold; a run that failed without
/// any has one of its own.
pub fn annotations(summary: &Summary) -> Vec<String> {
    let failed: Vec<_> = summary.expectations.iter().filter(|verdict| !verdict.passed).collect();
    if failed.is_empty() && !summary.passed {
        let what = format!("the run ended early: {}. Reproduce: {}", summary.end, summary.reproduce_line());
        return vec![format!("::error title={}::{}", property(&summary.scenario), message(&what))];
    }
    failed.into_iter().map(|verdict| annotation(summary, verdict)).collect()
}

fn annotation(summary: &Summary, verdict: &Verdict) -> String {
    let title = property(&format!("{}: {}", summary.scenario, verdict.title()));
    let what = message(&format!("{}: {}. Reproduce: {}", verdict.claim, verdict.result, summary.reproduce_line()));
    // Scenarios that ship and overrides are no files that anybody could look at.
    if Path::new(&verdict.file).is_file() {
        format!("::error file={},line={},title={title}::{what}", property(&verdict.file), verdict.line)
    } else {
        format!("::error title={title}::{what}")
    }
}

/// Text after the second `::`.
fn message(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// The value of a property, which `,` and `:` would end.
fn property(text: &str) -> String {
    message(text).replace(':', "%3A").replace(',', "%2C")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_end_a_line_or_a_property_is_escaped() {
        assert_eq!(message("100 %, a:b\r\nc"), "100 %25, a:b%0D%0Ac");
        assert_eq!(property("100 %, a:b\n"), "100 %25%2C a%3Ab%0A");
    }
}
