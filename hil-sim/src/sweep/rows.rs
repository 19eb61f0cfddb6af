//! The rows of a file of results, one after the other.

use std::fs::File;
use std::io::{self, Read as _, Seek as _, Take};
use std::path::{Path, PathBuf};

use canloop::config::nearest;
use csv::StringRecord;

use super::results::whole_lines;

/// Rows being read. A last line that was not finished is none of them.
pub struct Rows {
    /// The names of their columns.
    pub header: StringRecord,
    path: PathBuf,
    reader: csv::Reader<Take<File>>,
}

impl Rows {
    /// Opens the file at `path`.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn open(path: &Path) -> Result<Self, String> {
        let opened = whole(path).map_err(csv::Error::from).and_then(|file| {
            let mut reader = csv::Reader::from_reader(file);
            Ok((reader.headers()?.clone(), reader))
        });
        let (header, reader) = opened.map_err(|error| cannot(path, &error))?;
        Ok(Self { header, path: path.to_owned(), reader })
    }

    /// Where the column of that name is.
    ///
    /// # Errors
    /// There is none.
    pub fn column(&self, name: &str) -> Result<usize, String> {
        place(self.header.iter(), name)
    }

    /// Reads the next row into `row`; false after the last.
    ///
    /// # Errors
    /// It cannot be read, or has not as many cells as there are columns.
    pub fn next(&mut self, row: &mut StringRecord) -> Result<bool, String> {
        self.reader.read_record(row).map_err(|error| cannot(&self.path, &error))
    }
}

/// Where a name is among those of columns.
///
/// # Errors
/// It is not there.
pub fn place<'n>(names: impl Iterator<Item = &'n str> + Clone, name: &str) -> Result<usize, String> {
    names.clone().position(|known| known == name).ok_or_else(|| match nearest(name, names.clone()) {
        Some(near) => format!("found no column {name}: did you mean {near}?"),
        None => format!("found no column {name}: there are {}", names.collect::<Vec<_>>().join(", ")),
    })
}

fn whole(path: &Path) -> io::Result<Take<File>> {
    let mut file = File::open(path)?;
    let (_, len) = whole_lines(&mut file)?;
    file.rewind()?;
    Ok(file.take(len))
}

fn cannot(path: &Path, error: &csv::Error) -> String {
    format!("cannot read {}: {error}", path.display())
}
