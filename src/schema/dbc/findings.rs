//! What is wrong with a DBC file, gathered while it is read.

use std::ops::Range;
use std::sync::Arc;

use crate::config::{Problem, Source};

/// The findings of one file.
pub(super) struct Findings<'s> {
    pub source: &'s Arc<Source>,
    pub list: Vec<Problem>,
}

impl Findings<'_> {
    /// Something that does not say what it means. `hint` is what to do.
    pub fn error(&mut self, span: &Range<usize>, title: impl Into<String>, label: impl Into<String>, hint: &str) {
        self.list.push(Problem::at(self.source, span.clone(), title, label).help(hint));
    }

    /// Something that can be read in spite of it. `hint` is what to do.
    pub fn warn(&mut self, span: &Range<usize>, title: impl Into<String>, label: impl Into<String>, hint: &str) {
        self.list.push(Problem::at(self.source, span.clone(), title, label).help(hint).warning());
    }
}
