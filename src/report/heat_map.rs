//! A map: a value over two keys, cell by cell, with a boundary around cells of
//! which there is none.

use super::markup::Markup;
use super::scale::decimal;

/// A heat map.
///
/// Columns and rows are as given, from left to right and from the bottom to the
/// top. A cell without a value, where nothing was stable, is dark, and a line
/// runs between those and the others.
#[derive(Clone, Debug)]
pub struct HeatMap {
    /// What it shows.
    pub title: String,
    /// Name of the columns' key, unit last.
    pub x_name: String,
    /// Name of the rows' key.
    pub y_name: String,
    /// Name of the value.
    pub value_name: String,
    /// Labels of the columns.
    pub columns: Vec<String>,
    /// Labels of the rows.
    pub rows: Vec<String>,
    /// By row, then by column: positive numbers; none where nothing was stable.
    pub cells: Vec<Vec<Option<f64>>>,
}

const CELL_PX: f64 = 26.0;
const LEFT_PX: f64 = 92.0;
const TOP_PX: f64 = 44.0;
const BELOW_PX: f64 = 74.0;
const LEGEND_PX: f64 = 150.0;
/// Labels have room every so many columns.
const LABEL_PX: f64 = 40.0;

/// From good to bad: dark blue, blue, teal, green, yellow, in steps that look alike
/// and stay in order without colour.
const COLOURS: [(f64, f64, f64); 5] =
    [(68.0, 1.0, 84.0), (59.0, 82.0, 139.0), (33.0, 145.0, 140.0), (94.0, 201.0, 98.0), (253.0, 231.0, 37.0)];

const STYLE: &str = "\
.map { --paper: #ffffff; --ink: #1b2430; --soft: #566170; --gone: #d9dee4; --edge: #b3261e;
  font-family: system-ui, -apple-system, \"Segoe UI\", Roboto, \"Helvetica Neue\", Arial, sans-serif; font-size: 12.5px; }
@media screen and (prefers-color-scheme: dark) {
  .map { --paper: #14181e; --ink: #e8ecf1; --soft: #a5b0bd; --gone: #39424d; --edge: #ff7b72; } }
.map .paper { fill: #ffffff; fill: var(--paper); } .map text { fill: #566170; fill: var(--soft); }
.map .title { fill: #1b2430; fill: var(--ink); font-size: 14px; font-weight: 600; }
.map .gone { fill: #d9dee4; fill: var(--gone); } .map .middle { text-anchor: middle; } .map .end { text-anchor: end; }
.map .edge { stroke: #b3261e; stroke: var(--edge); stroke-width: 2.5; stroke-linecap: square; fill: none; }
";

impl HeatMap {
    /// The map as a picture of its own.
    pub fn to_svg(&self) -> String {
        let mut out = Markup::default();
        let (width, height) = (self.width_px() + LEFT_PX + LEGEND_PX, self.height_px() + TOP_PX + BELOW_PX);
        let (w, h) = (px(width), px(height));
        let view = format!("0 0 {w} {h}");
        out.open(
            "svg",
            &[
                ("xmlns", "http://www.w3.org/2000/svg"),
                ("class", "map"),
                ("role", "img"),
                ("width", &w),
                ("height", &h),
                ("viewBox", &view),
            ],
        );
        out.leaf("title", &[], &self.title);
        out.trusted("<style>\n");
        out.trusted(STYLE);
        out.trusted("</style>\n");
        out.empty("rect", &[("class", "paper"), ("width", &w), ("height", &h)]);
        out.leaf("text", &[("class", "title"), ("x", &px(LEFT_PX)), ("y", "24")], &self.title);
        self.write_cells(&mut out);
        self.write_boundary(&mut out);
        self.write_labels(&mut out);
        self.write_legend(&mut out);
        out.close("svg");
        out.finish()
    }

    fn width_px(&self) -> f64 {
        self.columns.len() as f64 * CELL_PX
    }

    fn height_px(&self) -> f64 {
        self.rows.len() as f64 * CELL_PX
    }

    /// The corner of a cell; rows go up.
    fn corner_px(&self, column: usize, row: usize) -> (f64, f64) {
        (LEFT_PX + column as f64 * CELL_PX, TOP_PX + (self.rows.len() - 1 - row) as f64 * CELL_PX)
    }

    fn write_cells(&self, out: &mut Markup) {
        let range = self.range();
        for (row, cells) in self.cells.iter().enumerate() {
            for (column, cell) in cells.iter().enumerate() {
                let (x, y) = self.corner_px(column, row);
                // A hair wider, so that no seam shows between cells.
                let size = px(CELL_PX + 0.4);
                let (x, y) = (px(x), px(y));
                let mut attributes = vec![("x", x.as_str()), ("y", y.as_str()), ("width", &size), ("height", &size)];
                let colour = cell.map(|value| colour(share(value, range)));
                match &colour {
                    Some(colour) => attributes.push(("fill", colour)),
                    None => attributes.push(("class", "gone")),
                }
                out.open("rect", &attributes);
                let value = cell.map_or("not stable".to_owned(), |value| format!("{value:.4e}"));
                let text =
                    format!("{} {}, {} {}: {value}", self.x_name, self.columns[column], self.y_name, self.rows[row]);
                out.leaf("title", &[], &text);
                out.close("rect");
            }
        }
    }

    /// A line wherever one of two neighbours is stable.
    fn write_boundary(&self, out: &mut Markup) {
        let is_stable = |row: usize, column: usize| self.cells[row][column].is_some();
        let mut line = |x1: f64, y1: f64, x2: f64, y2: f64| {
            let ends = [x1, y1, x2, y2].map(px);
            out.empty(
                "line",
                &[("class", "edge"), ("x1", &ends[0]), ("y1", &ends[1]), ("x2", &ends[2]), ("y2", &ends[3])],
            );
        };
        for row in 0..self.rows.len() {
            for column in 0..self.columns.len() {
                let (x, y) = self.corner_px(column, row);
                if column + 1 < self.columns.len() && is_stable(row, column) != is_stable(row, column + 1) {
                    line(x + CELL_PX, y, x + CELL_PX, y + CELL_PX);
                }
                if row + 1 < self.rows.len() && is_stable(row, column) != is_stable(row + 1, column) {
                    line(x, y, x + CELL_PX, y);
                }
            }
        }
    }

    fn write_labels(&self, out: &mut Markup) {
        let every = (LABEL_PX / CELL_PX).ceil() as usize;
        let bottom = TOP_PX + self.height_px();
        for (column, label) in self.columns.iter().enumerate().step_by(every) {
            let x = px(LEFT_PX + (column as f64 + 0.5) * CELL_PX);
            out.leaf("text", &[("class", "middle"), ("x", &x), ("y", &px(bottom + 18.0))], label);
        }
        for (row, label) in self.rows.iter().enumerate() {
            let (_, y) = self.corner_px(0, row);
            let y = px(y + 0.5 * CELL_PX + 4.0);
            out.leaf("text", &[("class", "end"), ("x", &px(LEFT_PX - 8.0)), ("y", &y)], label);
        }
        let middle = px(LEFT_PX + 0.5 * self.width_px());
        out.leaf("text", &[("class", "middle"), ("x", &middle), ("y", &px(bottom + 42.0))], &self.x_name);
        let y = px(TOP_PX + 0.5 * self.height_px());
        let turned = format!("rotate(-90 16 {y})");
        out.leaf("text", &[("class", "middle"), ("x", "16"), ("y", &y), ("transform", &turned)], &self.y_name);
        let stable = "grey: not stable, or stopped by the safety chain";
        out.leaf("text", &[("x", &px(LEFT_PX)), ("y", &px(bottom + 64.0))], stable);
    }

    fn write_legend(&self, out: &mut Markup) {
        const STEPS: usize = 24;
        let Some((low, high)) = self.range() else { return };
        let left = LEFT_PX + self.width_px() + 20.0;
        let height = self.height_px().clamp(60.0, 220.0);
        for step in 0..STEPS {
            let y = TOP_PX + height * (1.0 - (step + 1) as f64 / STEPS as f64);
            let colour = colour((step as f64 + 0.5) / STEPS as f64);
            let (x, y, h) = (px(left), px(y), px(height / STEPS as f64 + 0.4));
            out.empty("rect", &[("x", &x), ("y", &y), ("width", "14"), ("height", &h), ("fill", &colour)]);
        }
        for (value, y) in [(high, TOP_PX + 10.0), (low, TOP_PX + height)] {
            out.leaf("text", &[("x", &px(left + 20.0)), ("y", &px(y))], &short(value));
        }
        out.leaf("text", &[("x", &px(left)), ("y", &px(TOP_PX - 8.0))], &self.value_name);
    }

    /// Of the values that there are; both above 0.
    fn range(&self) -> Option<(f64, f64)> {
        let values = self.cells.iter().flatten().flatten().filter(|value| value.is_finite() && **value > 0.0);
        let (low, high) =
            values.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), value| (low.min(*value), high.max(*value)));
        (low <= high).then_some((low, high))
    }
}

/// Where a value lies between the two, by its logarithm, from 0 to 1.
fn share(value: f64, range: Option<(f64, f64)>) -> f64 {
    match range {
        Some((low, high)) if high > low => (libm::log(value / low) / libm::log(high / low)).clamp(0.0, 1.0),
        _ => 0.5,
    }
}

fn colour(share: f64) -> String {
    let at = share.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let nth = (at as usize).min(COLOURS.len() - 2);
    let ((r, g, b), (red, green, blue)) = (COLOURS[nth], COLOURS[nth + 1]);
    let mixed = |from: f64, to: f64| (from + (to - from) * (at - nth as f64)).round() as u8;
    format!("#{:02x}{:02x}{:02x}", mixed(r, red), mixed(g, green), mixed(b, blue))
}

/// A number for a legend.
fn short(value: f64) -> String {
    if (0.01..1e4).contains(&value) { decimal(value, 3) } else { format!("{value:.1e}") }
}

fn px(value: f64) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(cells: Vec<Vec<Option<f64>>>) -> HeatMap {
        let (columns, rows) = (cells[0].len(), cells.len());
        HeatMap {
            title: "a < b".to_owned(),
            x_name: "x".to_owned(),
            y_name: "y".to_owned(),
            value_name: "value".to_owned(),
            columns: (0..columns).map(|nth| nth.to_string()).collect(),
            rows: (0..rows).map(|nth| nth.to_string()).collect(),
            cells,
        }
    }

    #[test]
    fn each_cell_is_drawn_and_a_line_runs_between_stable_and_not() {
        let svg = map(vec![vec![Some(1.0), Some(10.0), None], vec![Some(2.0), None, None]]).to_svg();
        assert_eq!(svg.matches("class=\"gone\"").count(), 3);
        assert_eq!(svg.matches("class=\"edge\"").count(), 3);
        assert!(svg.contains("a &lt; b") && svg.contains("not stable"));
        roxmltree::Document::parse(&svg).expect("well-formed");
    }

    #[test]
    fn the_least_value_is_dark_and_the_greatest_light() {
        let range = Some((1.0, 100.0));
        assert_eq!(
            (colour(share(1.0, range)), colour(share(100.0, range))),
            ("#440154".to_owned(), "#fde725".to_owned())
        );
        assert_eq!(colour(share(10.0, range)), "#21918c");
        assert_eq!(share(3.0, None), 0.5);
    }

    #[test]
    fn a_map_without_any_value_is_a_picture_as_well() {
        roxmltree::Document::parse(&map(vec![vec![None]]).to_svg()).expect("well-formed");
    }
}
