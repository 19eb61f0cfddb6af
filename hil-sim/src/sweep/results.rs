//! The file of results: a line a run, in order of their numbers, so that one
//! which breaks off says by itself what is still to be run.

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use super::{Plan, Shard, columns};

/// Results being written to `results.csv` in a folder; the plan lies beside it.
pub struct Results {
    rows: csv::Writer<File>,
    path: PathBuf,
    /// Rows that were there already.
    pub done: u64,
}

/// Why results cannot be written, or gone on with.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// The system said no.
    #[error("cannot write {0}: {1}")]
    Io(PathBuf, io::Error),
    /// The folder has results of another plan, or of another part of it.
    #[error("{0} has results of another plan, or of another part of this one")]
    Other(PathBuf),
}

/// The file's name.
pub const FILE: &str = "results.csv";
/// That of the file with the same rows as Parquet.
pub const PARQUET: &str = "results.parquet";
/// That of the plan beside them.
pub const PLAN: &str = "plan.toml";

impl Results {
    /// Goes on with the results of `shard` of `plan` in `folder`, or begins
    /// them. A last line that was not finished is cut off.
    ///
    /// # Errors
    /// They cannot be written, or are of another plan.
    pub fn open(folder: &Path, plan: &Plan, shard: Shard) -> Result<Self, ResultsError> {
        let (path, plan_path) = (folder.join(FILE), folder.join(PLAN));
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |error| ResultsError::Io(path, error)
        };
        let text = plan_text(plan, shard);
        match std::fs::read_to_string(&plan_path) {
            Ok(known) if known != text => return Err(ResultsError::Other(folder.to_owned())),
            Ok(_) => {}
            Err(_) if path.exists() => return Err(ResultsError::Other(folder.to_owned())),
            Err(_) => std::fs::write(&plan_path, text).map_err(failed(&plan_path))?,
        }
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(failed(&path))?;
        let (lines, len) = whole_lines(&mut file).map_err(failed(&path))?;
        file.set_len(len).and_then(|()| file.seek(SeekFrom::End(0))).map_err(failed(&path))?;
        let mut results = Self { rows: csv::Writer::from_writer(file), path, done: lines.saturating_sub(1) };
        if lines == 0 {
            results.put_line(columns(&plan.axes).into_iter().map(|column| column.name))?;
        }
        Ok(results)
    }

    /// Appends the row of the case of that number.
    ///
    /// # Errors
    /// The file takes no more.
    pub fn put(&mut self, number: u64, cells: &[String]) -> Result<(), ResultsError> {
        self.put_line([number.to_string()].into_iter().chain(cells.iter().map(|cell| on_one_line(cell))))
    }

    fn put_line(&mut self, cells: impl Iterator<Item = String>) -> Result<(), ResultsError> {
        let written = self.rows.write_record(cells).map_err(io::Error::from);
        written.and_then(|()| self.rows.flush()).map_err(|error| ResultsError::Io(self.path.clone(), error))
    }
}

/// What tells the results of a part of a plan from all others.
fn plan_text(plan: &Plan, shard: Shard) -> String {
    format!("# part {} of {}\n{}", shard.index, shard.of, plan.text)
}

/// How many lines are whole, and where the last of them ends.
pub fn whole_lines(file: &mut File) -> io::Result<(u64, u64)> {
    let (mut lines, mut len) = (0, 0);
    let mut reader = BufReader::new(file);
    let mut line = Vec::new();
    loop {
        line.clear();
        let read = reader.read_until(b'\n', &mut line)?;
        if read == 0 || line.last() != Some(&b'\n') {
            return Ok((lines, len));
        }
        lines += 1;
        len += read as u64;
    }
}

/// A cell without line breaks: whole rows are told by theirs.
fn on_one_line(cell: &str) -> String {
    cell.replace(['\r', '\n'], " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_commas_and_quotes_are_quoted_and_a_row_is_a_line() {
        let folder = tempfile::tempdir().expect("a folder");
        let text = "name = \"n\"\nscenario = \"line\"\n[[vary]]\nkey = \"a\"\nvalues = [1]\n";
        let plan = Plan::parse(text).expect("a plan");
        let mut results = Results::open(folder.path(), &plan, Shard::WHOLE).expect("writable");
        let mut cells = ["a", "b, \"c\"", "", " d ", "e\r\nf", "#g", "'h'", "\"", "i;j\tk"].map(str::to_owned).to_vec();
        cells.resize(columns(&plan.axes).len() - 1, String::new());
        results.put(7, &cells).expect("writable");
        let written = std::fs::read_to_string(folder.path().join(FILE)).expect("readable");
        let row = "7,a,\"b, \"\"c\"\"\",, d ,e  f,#g,'h',\"\"\"\",i;j\tk";
        let line = written.lines().nth(1).expect("a row");
        assert_eq!(line.trim_end_matches(','), row);
        assert!(written.ends_with(",\n") && !written.contains('\r'));
    }
}
