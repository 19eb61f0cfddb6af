//! The parts of a sweep made one.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufRead as _, BufReader, BufWriter, Write as _};
use std::path::{Path, PathBuf};

use super::results::{FILE, PLAN};

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

/// Merges the results in `folders` into the file `output`, in order of the runs'
/// numbers. Each folder is in order itself, so no more than a row of each is in
/// memory. `runs` tells how many runs a plan has.
///
/// # Errors
/// What is wrong with which of them.
pub fn merge(folders: &[PathBuf], output: &Path, runs: impl Fn(&str) -> Option<u64>) -> Result<Merged, String> {
    let mut parts = Vec::new();
    let mut plan: Option<(PathBuf, String)> = None;
    for folder in folders {
        let part = Part::open(folder)?;
        match &plan {
            Some((first, text)) if *text != part.plan => {
                return Err(format!("{} and {} are of different plans", first.display(), folder.display()));
            }
            Some(_) => {}
            None => plan = Some((folder.clone(), part.plan.clone())),
        }
        parts.push(part);
    }
    let Some((_, text)) = plan else { return Err("there is nothing to merge".to_owned()) };
    let cannot = |error: io::Error| format!("cannot write {}: {error}", output.display());
    let mut out = BufWriter::new(File::create(output).map_err(cannot)?);
    writeln!(out, "{}", parts[0].header).map_err(cannot)?;
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
        let first = &parts[holders[0]];
        if let Some(other) = holders.iter().find(|&&other| parts[other].row != first.row) {
            let (one, other) = (first.folder.display(), parts[*other].folder.display());
            return Err(format!(
                "run {number} is another in {one} than in {other}: they were made by different programs"
            ));
        }
        writeln!(out, "{}", first.row).map_err(cannot)?;
        merged.rows += 1;
        merged.duplicates += holders.len() as u64 - 1;
        for holder in holders {
            parts[holder].advance()?;
            parts[holder].number.into_iter().for_each(|number| next.entry(number).or_default().push(holder));
        }
    }
    if let Some(runs) = runs(&text).filter(|&runs| runs > expected) {
        merged.gaps.push((expected, runs - 1));
    }
    out.flush().map_err(cannot)?;
    Ok(merged)
}

/// The results in a folder, row by row.
struct Part {
    folder: PathBuf,
    plan: String,
    header: String,
    lines: io::Lines<BufReader<File>>,
    /// The row that is next, and its number.
    row: String,
    number: Option<u64>,
}

impl Part {
    fn open(folder: &Path) -> Result<Self, String> {
        let cannot = |path: &Path, error: io::Error| format!("cannot read {}: {error}", path.display());
        let (plan_path, path) = (folder.join(PLAN), folder.join(FILE));
        let text = std::fs::read_to_string(&plan_path).map_err(|error| cannot(&plan_path, error))?;
        // The first line says which part it is.
        let plan = text.split_once('\n').map_or("", |(_, plan)| plan).to_owned();
        let file = File::open(&path).map_err(|error| cannot(&path, error))?;
        let mut lines = BufReader::new(file).lines();
        let header = lines.next().transpose().map_err(|error| cannot(&path, error))?.unwrap_or_default();
        let mut part = Self { folder: folder.to_owned(), plan, header, lines, row: String::new(), number: None };
        part.advance()?;
        Ok(part)
    }

    fn advance(&mut self) -> Result<(), String> {
        let path = self.folder.join(FILE);
        let line = self.lines.next().transpose().map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        let Some(row) = line else {
            self.number = None;
            return Ok(());
        };
        let number = row.split(',').next().and_then(|number| number.parse().ok());
        let number = number.ok_or_else(|| format!("{}: found {row:?}, expected a row of results", path.display()))?;
        (self.row, self.number) = (row, Some(number));
        Ok(())
    }
}
