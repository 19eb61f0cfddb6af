//! The file of results: a line a run, in order of their numbers, so that one
//! which breaks off says by itself what is still to be run.

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Seek as _, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::{Axis, COLUMNS, Plan, Shard};

/// Results being written to `results.csv` in a folder; the plan lies beside it.
pub struct Results {
    file: io::BufWriter<File>,
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
/// That of the plan beside it.
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
        let mut results = Self { file: io::BufWriter::new(file), path, done: lines.saturating_sub(1) };
        if lines == 0 {
            results.put_line(&header(&plan.axes))?;
        }
        Ok(results)
    }

    /// Appends the row of the case of that number.
    ///
    /// # Errors
    /// The file takes no more.
    pub fn put(&mut self, number: u64, cells: &[String]) -> Result<(), ResultsError> {
        let mut row = vec![number.to_string()];
        row.extend_from_slice(cells);
        self.put_line(&row)
    }

    fn put_line(&mut self, cells: &[String]) -> Result<(), ResultsError> {
        let line = cells.iter().map(|cell| quoted(cell)).collect::<Vec<_>>().join(",");
        let written = writeln!(self.file, "{line}").and_then(|()| self.file.flush());
        written.map_err(|error| ResultsError::Io(self.path.clone(), error))
    }
}

/// Names of the columns.
pub fn header(axes: &[Axis]) -> Vec<String> {
    let keys = axes.iter().map(|axis| axis.key.clone());
    ["run".to_owned()].into_iter().chain(keys).chain(COLUMNS.map(str::to_owned)).collect()
}

/// What tells the results of a part of a plan from all others.
fn plan_text(plan: &Plan, shard: Shard) -> String {
    format!("# part {} of {}\n{}", shard.index, shard.of, plan.text)
}

/// How many lines are whole, and where the last of them ends.
fn whole_lines(file: &mut File) -> io::Result<(u64, u64)> {
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

/// A cell as CSV has it (RFC 4180); a line break would end the row.
fn quoted(cell: &str) -> String {
    let cell = cell.replace(['\r', '\n'], " ");
    if cell.contains([',', '"']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell }
}
