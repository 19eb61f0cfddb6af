//! A map from the rows of a sweep.

use std::collections::BTreeMap;
use std::path::Path;

use canloop::config::nearest;
use canloop::report::HeatMap;

/// What of the results is drawn.
#[derive(Clone, Debug)]
pub struct Axes<'a> {
    /// The key from left to right.
    pub x: &'a str,
    /// The key from the bottom to the top.
    pub y: &'a str,
    /// The figure.
    pub value: &'a str,
    /// Only rows in which these columns have these values.
    pub only: Vec<(String, String)>,
}

/// Sum and number of the values of stable runs, and the number of all.
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    sum: f64,
    stable: u32,
    all: u32,
}

/// The rows of the results at `path` as a map. A cell is the mean over its runs,
/// and has no value where less than half of them were stable: went on to their
/// end, did not ring and did not trip.
///
/// # Errors
/// What is wrong with the results, or with what is asked of them.
pub fn map(path: &Path, axes: &Axes<'_>) -> Result<HeatMap, String> {
    let cannot = |error: csv::Error| format!("cannot read {}: {error}", path.display());
    let mut rows = csv::ReaderBuilder::new().flexible(true).from_path(path).map_err(cannot)?;
    let header = rows.headers().map_err(cannot)?.clone();
    let column = |name: &str| column(&header, name);
    let (x, y, value) = (column(axes.x)?, column(axes.y)?, column(axes.value)?);
    let (outcome, state, rings) = (column("outcome")?, column("state")?, column("rings")?);
    let only: Vec<(usize, &str)> =
        axes.only.iter().map(|(name, wanted)| Ok((column(name)?, wanted.as_str()))).collect::<Result<_, String>>()?;
    let mut found: BTreeMap<(Label, Label), Cell> = BTreeMap::new();
    for row in rows.records() {
        let row = row.map_err(cannot)?;
        // The last one may not be finished yet.
        if row.len() != header.len() || only.iter().any(|&(column, wanted)| &row[column] != wanted) {
            continue;
        }
        let cell = found.entry((Label::new(&row[y]), Label::new(&row[x]))).or_default();
        cell.all += 1;
        let is_stable = &row[outcome] == "finished" && &row[state] != "tripped" && &row[rings] != "true";
        if let Some(value) = row[value].parse::<f64>().ok().filter(|_| is_stable) {
            cell.stable += 1;
            cell.sum += value;
        }
    }
    if found.is_empty() {
        return Err(format!("{} has no row that is asked for", path.display()));
    }
    Ok(drawn(axes, &found))
}

fn drawn(axes: &Axes<'_>, found: &BTreeMap<(Label, Label), Cell>) -> HeatMap {
    let distinct = |of: fn(&(Label, Label)) -> &Label| {
        let mut labels: Vec<Label> = found.keys().map(|key| of(key).clone()).collect();
        labels.sort();
        labels.dedup();
        labels
    };
    let (rows, columns) = (distinct(|key| &key.0), distinct(|key| &key.1));
    let cell = |row: &Label, column: &Label| {
        let cell = found.get(&(row.clone(), column.clone())).copied().unwrap_or_default();
        (2 * cell.stable > cell.all).then(|| cell.sum / f64::from(cell.stable))
    };
    let only: Vec<String> = axes.only.iter().map(|(name, value)| format!("{name} = {value}")).collect();
    let which = if only.is_empty() { String::new() } else { format!(", {}", only.join(", ")) };
    HeatMap {
        title: format!("{}{which}", axes.value),
        x_name: axes.x.to_owned(),
        y_name: axes.y.to_owned(),
        value_name: axes.value.to_owned(),
        cells: rows.iter().map(|row| columns.iter().map(|column| cell(row, column)).collect()).collect(),
        columns: columns.iter().map(Label::short).collect(),
        rows: rows.iter().map(Label::short).collect(),
    }
}

/// A value of a key; numbers in their own order, before words.
#[derive(Clone, Debug, PartialEq)]
struct Label {
    number: Option<f64>,
    text: String,
}

impl Label {
    fn new(text: &str) -> Self {
        Self { number: text.parse().ok().filter(|number: &f64| number.is_finite()), text: text.to_owned() }
    }

    /// To three digits.
    fn short(&self) -> String {
        match self.number {
            Some(number) => {
                let text = format!("{number:.3e}");
                let rounded: f64 = text.parse().unwrap_or(number);
                format!("{rounded}")
            }
            None => self.text.clone(),
        }
    }
}

impl Eq for Label {}

impl PartialOrd for Label {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Label {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        match (self.number, other.number) {
            (Some(one), Some(other)) => one.total_cmp(&other),
            (Some(_), None) => std::cmp::Ordering::Less,
            (None, Some(_)) => std::cmp::Ordering::Greater,
            (None, None) => self.text.cmp(&other.text),
        }
    }
}

fn column(header: &csv::StringRecord, name: &str) -> Result<usize, String> {
    header.iter().position(|known| known == name).ok_or_else(|| {
        let all = || header.iter().collect::<Vec<_>>().join(", ");
        let near = nearest(name, header.iter());
        let hint = near.map_or_else(|| format!("there are {}", all()), |near| format!("did you mean {near}?"));
        format!("the results have no column {name}: {hint}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const RESULTS: &str = "run,a,b,outcome,state,rings,tracking.rms_m\n\
        0,1.0,x,finished,running,false,0.5\n1,1.0,x,finished,running,false,1.5\n\
        2,10.0,x,finished,tripped,false,9\n3,2.0,y,diverged,running,false,9\n4,2.0,x,finished,running,true,9\n";

    fn drawn(only: &[(&str, &str)]) -> Result<HeatMap, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(crate::sweep::FILE);
        std::fs::write(&path, RESULTS).expect("writable");
        let only = only.iter().map(|&(name, value)| (name.to_owned(), value.to_owned())).collect();
        map(&path, &Axes { x: "a", y: "b", value: "tracking.rms_m", only })
    }

    #[test]
    fn cells_are_means_of_stable_runs_in_the_order_of_their_numbers() {
        let map = drawn(&[]).expect("a map");
        assert_eq!((map.columns, map.rows), (vec!["1".into(), "2".into(), "10".into()], vec!["x".into(), "y".into()]));
        assert_eq!(map.cells, [vec![Some(1.0), None, None], vec![None, None, None]]);
        assert_eq!(drawn(&[("b", "y")]).expect("a map").rows, ["y"]);
    }

    #[test]
    fn a_column_that_is_not_there_is_said() {
        assert!(drawn(&[("bb", "y")]).expect_err("no such column").contains("no column bb"));
        assert!(drawn(&[("b", "z")]).expect_err("no such row").contains("no row"));
    }
}
