//! Maps of the rows of a sweep.

use std::collections::BTreeMap;
use std::path::Path;

use canloop::config::Section;
use canloop::report::{HeatMap, MapCell, Panel};
use csv::StringRecord;

use super::Column;
use super::rows::{Rows, place};

/// What of the results is drawn: a `[[map]]` table of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Axes {
    /// What stands above it.
    pub title: String,
    /// The key from left to right.
    pub x: String,
    /// The key from the bottom to the top.
    pub y: String,
    /// The figure.
    pub value: String,
    /// The key of which each value has a map of its own.
    pub panels: Option<String>,
    /// Only rows in which these columns have these values.
    pub only: Vec<(String, String)>,
}

impl Axes {
    /// Reads a `[[map]]` table over the columns of a sweep.
    pub fn read(section: &Section<'_>, columns: &[Column]) -> Self {
        let column = |key: &str, name: Option<String>| {
            if let Some(name) = name.as_ref().filter(|name| !name.is_empty())
                && let Err(what) = place(columns.iter().map(|column| column.name.as_str()), name)
            {
                section.complain(key, &what);
            }
            name
        };
        let needed = |key: &str| column(key, Some(section.text(key))).unwrap_or_default();
        let value = column("value", section.text_or_none("value"));
        let value = value.unwrap_or_else(|| "tracking.rms_m".to_owned());
        Self {
            title: section.text_or_none("title").unwrap_or_else(|| value.clone()),
            x: needed("x"),
            y: needed("y"),
            value,
            panels: column("panels", section.text_or_none("panels")),
            only: Vec::new(),
        }
    }
}

/// Sum and number of the values of runs that ended well, and the number of all.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    stable: u32,
    ringing: u32,
    all: u32,
    sum_stable: f64,
    sum_ringing: f64,
}

impl Tally {
    /// The mean over the runs that are alike, where they are more than half.
    fn cell(&self) -> MapCell {
        let both = self.stable + self.ringing;
        if 2 * self.stable > self.all {
            MapCell::Stable(self.sum_stable / f64::from(self.stable))
        } else if 2 * both > self.all {
            MapCell::Ringing((self.sum_stable + self.sum_ringing) / f64::from(both))
        } else {
            MapCell::Gone
        }
    }
}

/// Who came less far than this, m, never drove: a robot that friction holds is
/// not stable but stuck.
const MOVED_M: f64 = 0.01;

/// Where a run is on the map: panel, row, column.
type Place = (Label, Label, Label);

/// The rows of the results at `path` as a map. A run is stable that drove on to
/// its end, did not trip and did not ring.
///
/// # Errors
/// What is wrong with the results, or with what is asked of them.
pub fn map(path: &Path, axes: &Axes) -> Result<HeatMap, String> {
    let mut rows = Rows::open(path)?;
    let column = |name: &str| rows.column(name);
    let (x, y, value) = (column(&axes.x)?, column(&axes.y)?, column(&axes.value)?);
    let panels = axes.panels.as_deref().map(column).transpose()?;
    let (outcome, state, rings, travelled) =
        (column("outcome")?, column("state")?, column("rings")?, column("tracking.travelled_m")?);
    let only: Vec<(usize, &str)> =
        axes.only.iter().map(|(name, wanted)| Ok((column(name)?, wanted.as_str()))).collect::<Result<_, String>>()?;
    let mut found: BTreeMap<Place, Tally> = BTreeMap::new();
    let mut row = StringRecord::new();
    while rows.next(&mut row)? {
        if only.iter().any(|&(column, wanted)| &row[column] != wanted) {
            continue;
        }
        let panel = Label::new(panels.map_or("", |column| &row[column]));
        let tally = found.entry((panel, Label::new(&row[y]), Label::new(&row[x]))).or_default();
        tally.all += 1;
        let drove = row[travelled].parse::<f64>().is_ok_and(|travelled_m| travelled_m > MOVED_M);
        let is_well = drove && &row[outcome] == "finished" && &row[state] != "tripped";
        let Some(value) = row[value].parse::<f64>().ok().filter(|_| is_well) else { continue };
        if &row[rings] == "true" {
            (tally.ringing, tally.sum_ringing) = (tally.ringing + 1, tally.sum_ringing + value);
        } else {
            (tally.stable, tally.sum_stable) = (tally.stable + 1, tally.sum_stable + value);
        }
    }
    if found.is_empty() {
        return Err(format!("{} has no row that is asked for", path.display()));
    }
    Ok(drawn(axes, &found))
}

fn drawn(axes: &Axes, found: &BTreeMap<Place, Tally>) -> HeatMap {
    let distinct = |of: fn(&Place) -> &Label| {
        let mut labels: Vec<Label> = found.keys().map(|place| of(place).clone()).collect();
        labels.sort();
        labels.dedup();
        labels
    };
    let (panels, rows, columns) = (distinct(|place| &place.0), distinct(|place| &place.1), distinct(|place| &place.2));
    let panel = |panel: &Label| {
        let cell = |row: &Label, column: &Label| {
            found.get(&(panel.clone(), row.clone(), column.clone())).map_or(MapCell::Gone, Tally::cell)
        };
        let title = axes.panels.as_ref().map_or_else(String::new, |key| format!("{key} = {}", panel.text));
        let cells = rows.iter().map(|row| columns.iter().map(|column| cell(row, column)).collect()).collect();
        Panel { title, cells }
    };
    let only: Vec<String> = axes.only.iter().map(|(name, value)| format!("{name} = {value}")).collect();
    let which = if only.is_empty() { String::new() } else { format!(", {}", only.join(", ")) };
    HeatMap {
        title: format!("{}{which}", axes.title),
        x_name: axes.x.clone(),
        y_name: axes.y.clone(),
        value_name: axes.value.clone(),
        columns: columns.iter().map(Label::short).collect(),
        rows: rows.iter().map(Label::short).collect(),
        panels: panels.iter().map(panel).collect(),
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
                let text = format!("{number:.2e}");
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

#[cfg(test)]
mod tests {
    use super::*;

    const RESULTS: &str = "run,a,b,outcome,state,rings,tracking.travelled_m,tracking.rms_m\n\
        0,1.0,x,finished,running,false,9,0.5\n1,1.0,x,finished,running,false,9,1.5\n\
        2,10.0,x,finished,tripped,false,9,9\n3,2.0,y,diverged,running,false,9,9\n\
        4,2.0,x,finished,running,true,9,4.0\n5,10.0,y,finished,stopped,false,0.0,0.0\n";

    fn drawn(panels: Option<&str>, only: &[(&str, &str)]) -> Result<HeatMap, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(crate::sweep::FILE);
        std::fs::write(&path, RESULTS).expect("writable");
        let only = only.iter().map(|&(name, value)| (name.to_owned(), value.to_owned())).collect();
        let [title, x, y, value] = ["how far", "a", "b", "tracking.rms_m"].map(str::to_owned);
        map(&path, &Axes { title, x, y, value, panels: panels.map(str::to_owned), only })
    }

    #[test]
    fn cells_are_means_of_stable_runs_in_the_order_of_their_numbers() {
        use MapCell::{Gone, Ringing, Stable};
        let map = drawn(None, &[]).expect("a map");
        assert_eq!((map.columns, map.rows), (vec!["1".into(), "2".into(), "10".into()], vec!["x".into(), "y".into()]));
        let cells = &map.panels[0].cells;
        assert_eq!(cells[0], [Stable(1.0), Ringing(4.0), Gone], "the third tripped");
        assert_eq!(cells[1], [Gone, Gone, Gone], "no run, one that diverged, one that never drove");
        assert_eq!(drawn(None, &[("b", "y")]).expect("a map").rows, ["y"]);
    }

    #[test]
    fn a_key_can_have_a_map_for_each_of_its_values() {
        let map = drawn(Some("b"), &[]).expect("a map");
        let titles: Vec<&str> = map.panels.iter().map(|panel| panel.title.as_str()).collect();
        assert_eq!(titles, ["b = x", "b = y"]);
    }

    #[test]
    fn a_column_that_is_not_there_is_said() {
        assert!(drawn(None, &[("bb", "y")]).expect_err("no such column").contains("no column bb"));
        assert!(drawn(None, &[("b", "z")]).expect_err("no such row").contains("no row"));
    }
}
