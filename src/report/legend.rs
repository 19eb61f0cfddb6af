//! What stands above the plot: the title, the legend, and the markers' labels.

use super::chart::Chart;
use super::markup::Markup;
use super::svg::{WIDTH_PX, line_class, px, text, text_width_px};

const TITLE_PX: f64 = 28.0;
const ROW_PX: f64 = 18.0;
const SAMPLE_PX: f64 = 24.0;
const MARKER_ROW_PX: f64 = 14.0;
const MARKER_ROWS: usize = 4;

/// A name and the classes of its sample.
struct Entry {
    name: String,
    class: String,
}

/// A marker's label, placed: row 0 is the one next to the plot.
pub(super) struct MarkerLabel {
    text: String,
    left_px: f64,
    row: usize,
}

/// Writes the title and the legend.
pub(super) fn write(chart: &Chart, out: &mut Markup, left_px: f64) {
    text(out, "title", (left_px, 19.0), &elided(&chart.title, (WIDTH_PX - left_px) / 1.3));
    let entries = entries(chart);
    for (entry, (x, row)) in entries.iter().zip(flow(&entries, left_px)) {
        let middle = TITLE_PX + ROW_PX * row as f64 + 8.0;
        if entry.class.ends_with("band") {
            let place = [("x", px(x)), ("y", px(middle - 5.0)), ("width", px(SAMPLE_PX - 6.0)), ("height", px(10.0))];
            let mut attributes = vec![("class", entry.class.as_str())];
            attributes.extend(place.iter().map(|(name, value)| (*name, value.as_str())));
            out.empty("rect", &attributes);
        } else {
            let sample = format!("M{} {}h{}", px(x), px(middle), px(SAMPLE_PX - 4.0));
            out.empty("path", &[("class", &entry.class), ("d", &sample)]);
        }
        text(out, "legend", (x + SAMPLE_PX + 2.0, middle + 4.3), &entry.name);
    }
}

/// Writes the labels above a plot whose corner is at (`left_px`, `top_px`).
pub(super) fn write_marker_labels(labels: &[MarkerLabel], out: &mut Markup, left_px: f64, top_px: f64) {
    for label in labels {
        let y = top_px - 5.0 - MARKER_ROW_PX * label.row as f64;
        text(out, "event", (left_px + label.left_px, y), &label.text);
    }
}

/// The height of title and legend.
pub(super) fn height_px(chart: &Chart, left_px: f64) -> f64 {
    let rows = flow(&entries(chart), left_px).last().map_or(0, |(_, row)| row + 1);
    TITLE_PX + ROW_PX * rows as f64 + 6.0
}

/// The height of the strip that holds the labels.
pub(super) fn marker_strip_px(labels: &[MarkerLabel]) -> f64 {
    let rows = labels.iter().map(|label| label.row + 1).max().unwrap_or(0);
    MARKER_ROW_PX * rows as f64
}

/// Puts each label near its place (in pixels of the plot), in the lowest row
/// where it touches no other; leaves out those that fit in none.
pub(super) fn place_marker_labels(markers: &[(&str, f64)], width_px: f64) -> Vec<MarkerLabel> {
    let mut taken: Vec<Vec<(f64, f64)>> = vec![Vec::new(); MARKER_ROWS];
    let mut labels = Vec::new();
    for (text, at_px) in markers {
        let text = elided(text, 0.5 * width_px);
        let width = 0.95 * text_width_px(&text);
        let left_px = (at_px - 0.5 * width).clamp(0.0, width_px - width);
        let free =
            |row: &Vec<(f64, f64)>| row.iter().all(|(from, to)| left_px + width + 6.0 < *from || left_px > to + 6.0);
        if let Some(row) = taken.iter().position(free) {
            taken[row].push((left_px, left_px + width));
            labels.push(MarkerLabel { text, left_px, row });
        }
    }
    labels
}

/// The text, cut with an ellipsis when it is wider than the room there is.
pub(super) fn elided(text: &str, room_px: f64) -> String {
    if text_width_px(text) <= room_px {
        return text.to_owned();
    }
    let mut short = String::new();
    for character in text.chars() {
        short.push(character);
        if text_width_px(&short) + text_width_px("…") > room_px {
            short.pop();
            break;
        }
    }
    short.trim_end().to_owned() + "…"
}

/// Everything with a name, each name and look once.
fn entries(chart: &Chart) -> Vec<Entry> {
    let series = chart.series.iter().map(|series| (&series.name, line_class(series)));
    let limits = chart.limits.iter().map(|(name, _)| (name, "limit".to_owned()));
    let x_bands = chart.x_bands.iter().map(|band| (&band.name, "x-band".to_owned()));
    let y_bands = chart.y_bands.iter().map(|band| (&band.name, "y-band".to_owned()));
    let mut entries: Vec<Entry> = Vec::new();
    for (name, class) in series.chain(limits).chain(x_bands).chain(y_bands) {
        let name = elided(name, 0.7 * WIDTH_PX);
        if !name.is_empty() && !entries.iter().any(|entry| entry.name == name && entry.class == class) {
            entries.push(Entry { name, class });
        }
    }
    entries
}

/// Where each entry goes, from left to right in rows.
fn flow(entries: &[Entry], left_px: f64) -> Vec<(f64, usize)> {
    let (mut x, mut row) = (left_px, 0);
    let mut places = Vec::new();
    for entry in entries {
        let width = SAMPLE_PX + 18.0 + text_width_px(&entry.name);
        if x > left_px && x + width > WIDTH_PX {
            (x, row) = (left_px, row + 1);
        }
        places.push((x, row));
        x += width;
    }
    places
}
