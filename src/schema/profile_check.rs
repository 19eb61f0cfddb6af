//! Everything that is wrong with a drive profile and its DBC, in one go.

use std::path::Path;

use super::dbc::Dbc;
use super::profile::Profile;
use super::profile_reader;
use crate::config::{Document, Problem, Reader};

impl Profile {
    /// All that is wrong with a profile, and with the DBC that it names, seen
    /// from `folder`. Roles are looked for in whatever of the DBC makes sense.
    pub fn check(toml: &Document, folder: &Path) -> Vec<Problem> {
        let source = match profile_reader::dbc_source(toml, folder) {
            Ok(source) => source,
            Err(problem) => return vec![problem],
        };
        let (dbc, mut findings) = Dbc::check(&source);
        let reader = Reader::new(toml);
        let profile = profile_reader::profile(&reader.root(), toml, dbc);
        if let Err(problems) = reader.finish(profile) {
            findings.extend(problems.0);
        }
        findings
    }
}
