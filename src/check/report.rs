//! What was found, for people and for editors.

use std::fmt;

use serde::Serialize;

use crate::config::{Problem, Severity};

/// What was found in a number of files.
#[derive(Debug, Default)]
pub struct Report {
    findings: Vec<Problem>,
    unreadable: Vec<Problem>,
    files: usize,
}

/// A finding as editors take it.
#[derive(Serialize)]
struct Finding<'p> {
    file: Option<&'p str>,
    line: Option<usize>,
    column: Option<usize>,
    end: Option<End>,
    severity: &'static str,
    message: &'p str,
    label: &'p str,
    hint: Option<&'p str>,
}

/// One past the last character.
#[derive(Serialize)]
struct End {
    line: usize,
    column: usize,
}

impl Report {
    pub(super) fn add(&mut self, findings: Vec<Problem>) {
        self.files += 1;
        self.findings.extend(findings);
    }

    pub(super) fn add_unreadable(&mut self, problem: Problem) {
        self.files += 1;
        self.unreadable.push(problem);
    }

    /// All findings, then files that could not be read.
    pub fn problems(&self) -> impl Iterator<Item = &Problem> {
        self.findings.iter().chain(&self.unreadable)
    }

    /// 2 when a file could not be read, 1 when there are errors, else 0.
    pub fn exit_status(&self) -> u8 {
        match self.count(Severity::Error) {
            _ if !self.unreadable.is_empty() => 2,
            0 => 0,
            _ => 1,
        }
    }

    /// All of it for people, or as JSON for editors: an object a finding, one a
    /// line, and nothing where nothing was found.
    pub fn text(&self, as_json: bool) -> String {
        if as_json { self.json_lines() } else { format!("{self}\n") }
    }

    fn json_lines(&self) -> String {
        let lines = self.problems().map(|problem| {
            serde_json::to_string(&finding(problem)).expect("strings and numbers can be written as JSON") + "\n"
        });
        lines.collect()
    }

    fn count(&self, severity: Severity) -> usize {
        self.problems().filter(|problem| problem.severity == severity).count()
    }
}

/// Every finding with its source line, then how many there are.
impl fmt::Display for Report {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.problems().try_for_each(|problem| writeln!(out, "{problem}\n"))?;
        let many = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
        let (errors, warnings) = (self.count(Severity::Error), self.count(Severity::Warning));
        let found = match (errors, warnings) {
            (0, 0) => "nothing to complain of".to_owned(),
            (0, warnings) => many(warnings, "warning"),
            (errors, 0) => many(errors, "error"),
            (errors, warnings) => format!("{}, {}", many(errors, "error"), many(warnings, "warning")),
        };
        write!(out, "{}: {found}", many(self.files, "file"))
    }
}

fn finding(problem: &Problem) -> Finding<'_> {
    let place = problem.place.as_ref();
    let (line, column) = place.map(|(source, span)| source.line_and_column(span.start)).unzip();
    Finding {
        file: place.map(|(source, _)| source.name.as_str()),
        line,
        column,
        end: place.map(|(source, span)| {
            let (line, column) = source.line_and_column(span.end);
            End { line, column }
        }),
        severity: match problem.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        },
        message: &problem.title,
        label: &problem.label,
        hint: hint(problem),
    }
}

/// What to do: the advice, or else what was expected.
fn hint(problem: &Problem) -> Option<&str> {
    let expected = || problem.label.find("expected ").map(|at| &problem.label[at..]);
    problem.help.as_deref().or_else(expected)
}
