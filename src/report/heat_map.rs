//! A map: a value over two keys, cell by cell, with a boundary around the cells
//! that are stable.

use super::markup::Markup;
use super::scale::decimal;
use super::svg::{px, text};

/// Heat maps side by side, with the same keys and the same colours.
///
/// Columns and rows are as given, from left to right and from the bottom to the
/// top. A line runs between cells that are stable and others.
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
    /// At least one.
    pub panels: Vec<Panel>,
}

/// One of the maps.
#[derive(Clone, Debug)]
pub struct Panel {
    /// What sets it apart from the others; may be empty.
    pub title: String,
    /// By row, then by column.
    pub cells: Vec<Vec<MapCell>>,
}

/// What is known of a place on the map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum MapCell {
    /// It is stable, and has this value, above 0.
    Stable(f64),
    /// It has this value, but rings: hatched.
    Ringing(f64),
    /// It came to no good end, or nobody looked: grey.
    #[default]
    Gone,
}

impl MapCell {
    const fn value(self) -> Option<f64> {
        match self {
            Self::Stable(value) | Self::Ringing(value) => Some(value),
            Self::Gone => None,
        }
    }

    const fn is_stable(self) -> bool {
        matches!(self, Self::Stable(_))
    }
}

const LEFT_PX: f64 = 92.0;
const TOP_PX: f64 = 62.0;
const BELOW_PX: f64 = 76.0;
const LEGEND_PX: f64 = 116.0;
const GAP_PX: f64 = 36.0;
/// Sides of a cell, and what all panels may take beside each other.
const LEAST_CELL_PX: f64 = 12.0;
const MOST_CELL_PX: f64 = 26.0;
const PANELS_PX: f64 = 900.0;
/// What a label of a column and one of a row need.
const LABEL_WIDTH_PX: f64 = 54.0;
const LABEL_HEIGHT_PX: f64 = 15.0;

/// From good to bad: dark blue, blue, teal, green, yellow, in steps that look alike
/// and stay in order without colour.
const COLOURS: [(f64, f64, f64); 5] =
    [(68.0, 1.0, 84.0), (59.0, 82.0, 139.0), (33.0, 145.0, 140.0), (94.0, 201.0, 98.0), (253.0, 231.0, 37.0)];

impl HeatMap {
    /// The map as a picture of its own.
    pub fn to_svg(&self) -> String {
        let mut out = Markup::default();
        self.write(&mut out, Some(include_str!("heat_map.css")));
        out.finish()
    }

    /// Writes the map as one `svg` element, with a style sheet of its own if given.
    pub(super) fn write(&self, out: &mut Markup, style: Option<&str>) {
        let width = LEFT_PX + self.panel_left_px(self.panels.len()) + LEGEND_PX;
        let (w, h) = (px(width), px(TOP_PX + self.height_px() + BELOW_PX));
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
        if let Some(style) = style {
            out.trusted("<style>\n");
            out.trusted(style);
            out.trusted("</style>\n");
        }
        out.empty("rect", &[("class", "paper"), ("width", &w), ("height", &h)]);
        text(out, "title", (LEFT_PX, 22.0), &self.title);
        for (nth, panel) in self.panels.iter().enumerate() {
            let left = LEFT_PX + self.panel_left_px(nth);
            text(out, "panel", (left, TOP_PX - 8.0), &panel.title);
            self.write_cells(panel, left, out);
            self.write_boundary(panel, left, out);
            self.write_column_labels(left, out);
        }
        self.write_row_labels(out);
        self.write_legend(out);
        out.close("svg");
    }

    fn cell_px(&self) -> f64 {
        let columns = (self.panels.len() * self.columns.len()).max(1);
        (PANELS_PX / columns as f64).floor().clamp(LEAST_CELL_PX, MOST_CELL_PX)
    }

    fn panel_width_px(&self) -> f64 {
        self.columns.len() as f64 * self.cell_px()
    }

    /// From the left of the first panel to the left of the `nth`.
    fn panel_left_px(&self, nth: usize) -> f64 {
        nth as f64 * (self.panel_width_px() + GAP_PX)
    }

    fn height_px(&self) -> f64 {
        self.rows.len() as f64 * self.cell_px()
    }

    /// The top of a row; rows go up.
    fn row_top_px(&self, row: usize) -> f64 {
        TOP_PX + (self.rows.len() - 1 - row) as f64 * self.cell_px()
    }

    fn write_cells(&self, panel: &Panel, left: f64, out: &mut Markup) {
        let (range, side) = (self.range(), self.cell_px());
        for (row, cells) in panel.cells.iter().enumerate() {
            for (column, cell) in cells.iter().enumerate() {
                let (x, y) = (left + column as f64 * side, self.row_top_px(row));
                // A hair wider, so that no seam shows between cells.
                let (x_px, y_px, size) = (px(x), px(y), px(side + 0.4));
                let paint = cell.value().map(|value| colour(share(value, range)));
                let paint = paint.as_deref().map_or(("class", "gone"), |colour| ("fill", colour));
                out.open("rect", &[("x", &x_px), ("y", &y_px), ("width", &size), ("height", &size), paint]);
                out.leaf("title", &[], &self.told(panel, row, column));
                out.close("rect");
                if matches!(cell, MapCell::Ringing(_)) {
                    line(out, "ringing", (x + 0.15 * side, y + 0.85 * side), (x + 0.85 * side, y + 0.15 * side));
                }
            }
        }
    }

    /// What a cell says to whoever points at it.
    fn told(&self, panel: &Panel, row: usize, column: usize) -> String {
        let value = match panel.cells[row][column] {
            MapCell::Stable(value) => format!("{value:.4e}"),
            MapCell::Ringing(value) => format!("{value:.4e}, rings"),
            MapCell::Gone => "came to no good end".to_owned(),
        };
        let place = format!("{} {}, {} {}", self.x_name, self.columns[column], self.y_name, self.rows[row]);
        if panel.title.is_empty() { format!("{place}: {value}") } else { format!("{}, {place}: {value}", panel.title) }
    }

    fn write_boundary(&self, panel: &Panel, left: f64, out: &mut Markup) {
        let side = self.cell_px();
        let is_stable = |row: usize, column: usize| panel.cells[row][column].is_stable();
        for row in 0..self.rows.len() {
            for column in 0..self.columns.len() {
                let (x, y) = (left + column as f64 * side, self.row_top_px(row));
                if column + 1 < self.columns.len() && is_stable(row, column) != is_stable(row, column + 1) {
                    line(out, "edge", (x + side, y), (x + side, y + side));
                }
                if row + 1 < self.rows.len() && is_stable(row, column) != is_stable(row + 1, column) {
                    line(out, "edge", (x, y), (x + side, y));
                }
            }
        }
    }

    fn write_column_labels(&self, left: f64, out: &mut Markup) {
        let (side, bottom) = (self.cell_px(), TOP_PX + self.height_px());
        let every = (LABEL_WIDTH_PX / side).ceil() as usize;
        for (column, label) in self.columns.iter().enumerate().step_by(every) {
            text(out, "middle", (left + (column as f64 + 0.5) * side, bottom + 18.0), label);
        }
        text(out, "middle", (left + 0.5 * self.panel_width_px(), bottom + 42.0), &self.x_name);
    }

    fn write_row_labels(&self, out: &mut Markup) {
        let side = self.cell_px();
        let every = (LABEL_HEIGHT_PX / side).ceil() as usize;
        for (row, label) in self.rows.iter().enumerate().step_by(every) {
            text(out, "end", (LEFT_PX - 8.0, self.row_top_px(row) + 0.5 * side + 4.0), label);
        }
        let turned = format!("translate(16 {}) rotate(-90)", px(TOP_PX + 0.5 * self.height_px()));
        out.leaf("text", &[("class", "middle"), ("transform", &turned)], &self.y_name);
        let explained = "red line: where it stops being stable; hatched: rings; grey: fell, tripped or never drove";
        text(out, "soft", (LEFT_PX, TOP_PX + self.height_px() + 66.0), explained);
    }

    fn write_legend(&self, out: &mut Markup) {
        const STEPS: usize = 24;
        let Some((low, high)) = self.range() else { return };
        let left = LEFT_PX + self.panel_left_px(self.panels.len());
        let height = self.height_px().clamp(60.0, 220.0);
        for step in 0..STEPS {
            let y = TOP_PX + height * (1.0 - (step + 1) as f64 / STEPS as f64);
            let colour = colour((step as f64 + 0.5) / STEPS as f64);
            let (x, y, h) = (px(left), px(y), px(height / STEPS as f64 + 0.4));
            out.empty("rect", &[("x", &x), ("y", &y), ("width", "14"), ("height", &h), ("fill", &colour)]);
        }
        for (value, y) in
            [(high, TOP_PX + 10.0), (libm::sqrt(low * high), TOP_PX + 0.5 * height + 4.0), (low, TOP_PX + height)]
        {
            text(out, "soft", (left + 20.0, y), &short(value));
        }
        text(out, "soft", (left, TOP_PX - 8.0), &self.value_name);
    }

    /// Of the values that there are; both above 0.
    fn range(&self) -> Option<(f64, f64)> {
        let cells = self.panels.iter().flat_map(|panel| panel.cells.iter().flatten());
        let values = cells.filter_map(|cell| cell.value()).filter(|value| value.is_finite() && *value > 0.0);
        let (low, high) =
            values.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), value| (low.min(value), high.max(value)));
        (low <= high).then_some((low, high))
    }
}

fn line(out: &mut Markup, class: &str, from: (f64, f64), to: (f64, f64)) {
    let ends = [from.0, from.1, to.0, to.1].map(px);
    out.empty("line", &[("class", class), ("x1", &ends[0]), ("y1", &ends[1]), ("x2", &ends[2]), ("y2", &ends[3])]);
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

#[cfg(test)]
mod tests {
    use super::*;
    use MapCell::{Gone, Ringing, Stable};

    fn map(panels: Vec<Vec<Vec<MapCell>>>) -> HeatMap {
        let (columns, rows) = (panels[0][0].len(), panels[0].len());
        HeatMap {
            title: "a < b".to_owned(),
            x_name: "x".to_owned(),
            y_name: "y".to_owned(),
            value_name: "value".to_owned(),
            columns: (0..columns).map(|nth| nth.to_string()).collect(),
            rows: (0..rows).map(|nth| nth.to_string()).collect(),
            panels: panels.into_iter().map(|cells| Panel { title: "law".to_owned(), cells }).collect(),
        }
    }

    #[test]
    fn each_cell_is_drawn_and_a_line_runs_between_stable_and_not() {
        let cells = vec![vec![Stable(1.0), Stable(10.0), Gone], vec![Stable(2.0), Ringing(3.0), Gone]];
        let svg = map(vec![cells]).to_svg();
        assert_eq!(svg.matches("class=\"gone\"").count(), 2);
        assert_eq!(svg.matches("class=\"ringing\"").count(), 1);
        assert_eq!(svg.matches("class=\"edge\"").count(), 3);
        assert!(svg.contains("a &lt; b") && svg.contains("no good end") && svg.contains("3.0000e0, rings"));
        roxmltree::Document::parse(&svg).expect("well-formed");
    }

    #[test]
    fn panels_share_their_colours() {
        let svg = map(vec![vec![vec![Stable(1.0)]], vec![vec![Stable(100.0)]]]).to_svg();
        let drawn = |colour: &str| svg.contains(&format!("fill=\"{colour}\""));
        assert!(drawn("#440154") && drawn("#fde725"), "the least and the greatest of all");
        assert_eq!(svg.matches("class=\"panel\"").count(), 2);
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
        roxmltree::Document::parse(&map(vec![vec![vec![Gone]]]).to_svg()).expect("well-formed");
    }
}
