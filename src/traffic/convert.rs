//! From a reader to a writer.

use std::io;

use super::{Finding, Losses, Reader, Writer};
use crate::config::Severity;

/// What became of a log.
#[derive(Clone, Debug, Default)]
pub struct Conversion {
    /// Records read, and written as far as the format holds them.
    pub records: u64,
    /// What is wrong with the input: the first of them.
    pub findings: Vec<Finding>,
    /// How many there are in all that are errors.
    pub errors: u64,
    /// And how many that are warnings.
    pub warnings: u64,
    /// What the output could not hold.
    pub losses: Losses,
}

/// So many findings are kept: a damaged file may have millions.
const KEPT: usize = 20;

/// Writes all that `reader` gives.
///
/// # Errors
/// The output takes no more.
pub fn convert(reader: &mut dyn Reader, mut writer: Box<dyn Writer>) -> io::Result<Conversion> {
    let mut conversion = Conversion::default();
    while let Some(item) = reader.next() {
        match item {
            Ok(record) => {
                conversion.records += 1;
                writer.put(&record, reader.buses())?;
            }
            Err(finding) => conversion.note(finding),
        }
    }
    conversion.losses = writer.finish()?;
    Ok(conversion)
}

impl Conversion {
    /// Counts a finding, and keeps it if it is one of the first.
    pub fn note(&mut self, finding: Finding) {
        match finding.severity {
            Severity::Error => self.errors += 1,
            Severity::Warning => self.warnings += 1,
        }
        if self.findings.len() < KEPT {
            self.findings.push(finding);
        }
    }
}
