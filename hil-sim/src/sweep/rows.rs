//! Results, read again.

use std::fs::File;
use std::io::{BufRead as _, BufReader};
use std::path::Path;

use canloop::config::nearest;

/// The rows of a file of results, one by one.
pub struct Rows {
    header: Vec<String>,
    lines: std::io::Lines<BufReader<File>>,
}

impl Rows {
    pub fn open(path: &Path) -> Result<Self, String> {
        let cannot = |error| format!("cannot read {}: {error}", path.display());
        let mut lines = BufReader::new(File::open(path).map_err(cannot)?).lines();
        let header = cells(&lines.next().transpose().map_err(cannot)?.unwrap_or_default());
        Ok(Self { header, lines })
    }

    /// Where a column is.
    pub fn column(&self, name: &str) -> Result<usize, String> {
        column(&self.header, name)
    }
}

/// Whole rows; a last one that was not finished is none.
impl Iterator for Rows {
    type Item = Vec<String>;

    fn next(&mut self) -> Option<Vec<String>> {
        self.lines.by_ref().map_while(Result::ok).map(|line| cells(&line)).find(|row| row.len() == self.header.len())
    }
}

pub fn column(header: &[String], name: &str) -> Result<usize, String> {
    header.iter().position(|known| known == name).ok_or_else(|| {
        let near = nearest(name, header.iter().map(String::as_str));
        let hint =
            near.map_or_else(|| format!("there are {}", header.join(", ")), |near| format!("did you mean {near}?"));
        format!("found no column {name}: {hint}")
    })
}

/// The cells of a line of CSV.
fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut cell, mut is_quoted) = (Vec::new(), String::new(), false);
    let mut characters = line.chars().peekable();
    while let Some(character) = characters.next() {
        match character {
            '"' if is_quoted && characters.peek() == Some(&'"') => {
                characters.next();
                cell.push('"');
            }
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(std::mem::take(&mut cell)),
            other => cell.push(other),
        }
    }
    cells.push(cell);
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_hold_commas() {
        assert_eq!(cells("a,\"b, \"\"c\"\"\",,d"), ["a", "b, \"c\"", "", "d"]);
    }
}
