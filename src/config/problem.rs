//! What is wrong with an input file, and where.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

/// A text with the name that messages call it by.
#[derive(Debug, PartialEq, Eq)]
pub struct Source {
    /// A path, or `--set` for an override from the command line.
    pub name: String,
    /// All of it.
    pub text: String,
}

/// How much a problem matters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// It may be meant; what it stands in can be used.
    Warning,
    /// It cannot be used as it is.
    #[default]
    Error,
}

/// One thing wrong with one input.
#[derive(Clone, Debug)]
pub struct Problem {
    /// How much it matters.
    pub severity: Severity,
    /// Where: the text and a byte range in it.
    pub place: Option<(Arc<Source>, Range<usize>)>,
    /// What is wrong, in one line.
    pub title: String,
    /// Found and expected, beside the place.
    pub label: String,
    /// What to do about it.
    pub help: Option<String>,
}

/// All that is wrong with an input; never empty.
#[derive(Clone, Debug)]
pub struct Problems(pub Vec<Problem>);

impl Source {
    /// A named text.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Arc<Self> {
        Arc::new(Self { name: name.into(), text: text.into() })
    }

    /// The byte range of line `line` (from 1), without its end.
    pub fn line_span(&self, line: usize) -> Range<usize> {
        let start = self.text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
        let text = self.text[start..].split('\n').next().unwrap_or("").trim_end_matches('\r');
        start..start + text.len()
    }

    /// Line and column of a byte, counted from 1, columns in characters.
    pub fn line_and_column(&self, at: usize) -> (usize, usize) {
        let before = &self.text[..floor_char(&self.text, at)];
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }
}

impl Problem {
    /// A problem at `span` of `source`.
    pub fn at(source: &Arc<Source>, span: Range<usize>, title: impl Into<String>, label: impl Into<String>) -> Self {
        Self { place: Some((Arc::clone(source), span)), label: label.into(), ..Self::bare(title) }
    }

    /// A problem that has no place in a text, such as a missing file.
    pub fn bare(title: impl Into<String>) -> Self {
        Self { severity: Severity::Error, place: None, title: title.into(), label: String::new(), help: None }
    }

    /// The same as a warning.
    pub fn warning(self) -> Self {
        Self { severity: Severity::Warning, ..self }
    }

    /// Adds advice.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// `name:line:column`, counted from 1 in characters.
    pub fn position(&self) -> Option<String> {
        let (source, span) = self.place.as_ref()?;
        let (line, column) = source.line_and_column(span.start);
        Some(format!("{}:{line}:{column}", source.name))
    }
}

impl From<Problem> for Problems {
    fn from(problem: Problem) -> Self {
        Self(vec![problem])
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let level = match self.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let mut group = Group::with_title(level.primary_title(self.title.as_str()));
        if let Some((source, span)) = &self.place {
            let end = floor_char(&source.text, span.end);
            let span = floor_char(&source.text, span.start).min(end)..end;
            let annotation = AnnotationKind::Primary.span(span).label(self.label.as_str());
            group = group.element(Snippet::source(&source.text).path(&source.name).annotation(annotation));
        }
        if let Some(help) = &self.help {
            group = group.element(Level::HELP.message(help.as_str()));
        }
        write!(out, "{}", Renderer::plain().render(&[group]))
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, problem) in self.0.iter().enumerate() {
            write!(out, "{}{problem}", if index > 0 { "\n\n" } else { "" })?;
        }
        Ok(())
    }
}

impl std::error::Error for Problem {}
impl std::error::Error for Problems {}

/// The nearest character boundary at or before `at`.
fn floor_char(text: &str, at: usize) -> usize {
    (0..=at.min(text.len())).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0)
}
