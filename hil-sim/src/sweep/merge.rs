//! The parts of a sweep made one.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use csv::StringRecord;

use super::Plan;
use super::parquet::Table;
use super::results::{FILE, PLAN};
use super::rows::Rows;

/// What became of parts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Merged {
    /// Rows in the whole.
    pub rows: u64,
    /// Rows that were there more than once.
    pub duplicates: u64,
    /// Numbers of runs that are missing: first and last of each stretch.
    pub gaps: Vec<(u64, u64)>,
}

/// Parts of one plan. Each is in order itself, so no more than a row of each is
/// in memory.
pub struct Parts {
    parts: Vec<Part>,
    plan: String,
}

impl Parts {
    /// Opens the results in `folders`.
    ///
    /// # Errors
    /// What is wrong with which of them.
    pub fn open(folders: &[PathBuf]) -> Result<Self, String> {
        let parts: Vec<Part> = folders.iter().map(|folder| Part::open(folder)).collect::<Result<_, _>>()?;
        let Some(first) = parts.first() else { return Err("there is nothing to merge".to_owned()) };
        for other in &parts[1..] {
            let both = || format!("{} and {}", first.folder.display(), other.folder.display());
            if other.plan != first.plan {
                return Err(format!("{} are of different plans", both()));
            }
            if other.rows.header != first.rows.header {
                return Err(format!("{} have different columns: they were made by different programs", both()));
            }
        }
        Ok(Self { plan: first.plan.clone(), parts })
    }

    /// Their plan.
    ///
    /// # Errors
    /// It is none that this program knows.
    pub fn plan(&self) -> Result<Plan, String> {
        Plan::parse(&self.plan).ok_or_else(|| {
            let path = self.parts[0].folder.join(PLAN);
            format!("{} is no plan that this program understands: another version wrote it", path.display())
        })
    }

    /// Writes all rows to a CSV file, in order of the runs' numbers.
    ///
    /// # Errors
    /// What is wrong with which part, or with the file.
    pub fn to_csv(self, output: &Path) -> Result<Merged, String> {
        let cannot = |error: &dyn std::fmt::Display| format!("cannot write {}: {error}", output.display());
        let mut out = csv::Writer::from_path(output).map_err(|error| cannot(&error))?;
        out.write_record(&self.parts[0].rows.header).map_err(|error| cannot(&error))?;
        let merged = self.each(|row| out.write_record(row).map_err(|error| cannot(&error)))?;
        out.flush().map_err(|error| cannot(&error))?;
        Ok(merged)
    }

    /// Writes all rows to a Parquet file, in order of the runs' numbers.
    ///
    /// # Errors
    /// What is wrong with which part, or with the file.
    pub fn to_parquet(self, output: &Path) -> Result<Merged, String> {
        let mut table = Table::create(output, &self.plan()?, &self.parts[0].rows.header)?;
        let merged = self.each(|row| table.put(row))?;
        table.finish()?;
        Ok(merged)
    }

    fn each(self, mut put: impl FnMut(&StringRecord) -> Result<(), String>) -> Result<Merged, String> {
        let Self { mut parts, plan } = self;
        let mut merged = Merged::default();
        let mut expected = 0;
        // By number: the rows of all parts that are next.
        let mut next: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
        for (nth, part) in parts.iter().enumerate() {
            part.number.into_iter().for_each(|number| next.entry(number).or_default().push(nth));
        }
        while let Some((number, holders)) = next.pop_first() {
            if number > expected {
                merged.gaps.push((expected, number - 1));
            }
            expected = number + 1;
            put(same_row(&parts, number, &holders)?)?;
            merged.rows += 1;
            merged.duplicates += holders.len() as u64 - 1;
            for holder in holders {
                parts[holder].advance()?;
                parts[holder].number.into_iter().for_each(|number| next.entry(number).or_default().push(holder));
            }
        }
        if let Some(runs) = Plan::parse(&plan).map(|plan| plan.runs()).filter(|&runs| runs > expected) {
            merged.gaps.push((expected, runs - 1));
        }
        Ok(merged)
    }
}

/// The row of the run of that number, which all its holders must have alike.
fn same_row<'a>(parts: &'a [Part], number: u64, holders: &[usize]) -> Result<&'a StringRecord, String> {
    let first = &parts[holders[0]];
    match holders.iter().map(|&other| &parts[other]).find(|other| other.row != first.row) {
        Some(other) => Err(format!(
            "run {number} is another in {} than in {}: they were made by different programs",
            first.folder.display(),
            other.folder.display()
        )),
        None => Ok(&first.row),
    }
}

/// The results in a folder, row by row.
struct Part {
    folder: PathBuf,
    plan: String,
    rows: Rows,
    /// The row that is next, and its number.
    row: StringRecord,
    number: Option<u64>,
}

impl Part {
    fn open(folder: &Path) -> Result<Self, String> {
        let plan_path = folder.join(PLAN);
        let text = std::fs::read_to_string(&plan_path)
            .map_err(|error| format!("cannot read {}: {error}", plan_path.display()))?;
        // The first line says which part it is.
        let plan = text.split_once('\n').map_or("", |(_, plan)| plan).to_owned();
        let rows = Rows::open(&folder.join(FILE))?;
        let mut part = Self { folder: folder.to_owned(), plan, rows, row: StringRecord::new(), number: None };
        part.advance()?;
        Ok(part)
    }

    fn advance(&mut self) -> Result<(), String> {
        if !self.rows.next(&mut self.row)? {
            self.number = None;
            return Ok(());
        }
        let number = self.row[0].parse().map_err(|_| {
            let path = self.folder.join(FILE);
            format!("{}: found a row that begins with {:?}, expected a run's number", path.display(), &self.row[0])
        })?;
        self.number = Some(number);
        Ok(())
    }
}
