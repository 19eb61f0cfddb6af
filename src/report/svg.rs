//! Draws a chart: from the top a title, the legend, a strip of marker labels,
//! the plot, tick labels, the x axis' name. Legend and labels stand outside
//! the plot, so they never hide data; the picture grows for them, the plot
//! keeps its size.

use super::chart::{Band, Chart, Role, Series, Stroke};
use super::decimate::{Point, extremes_per_column, straighten};
use super::legend;
use super::markup::Markup;
use super::scale::{Range, Scale, Ticks, drawable, nice_step, power_of_ten, ticks};

pub(super) const WIDTH_PX: f64 = 440.0;
const PLOT_HEIGHT_PX: f64 = 204.0;
const LEFT_PX: f64 = 64.0;
const RIGHT_PX: f64 = 14.0;
const BELOW_PX: f64 = 44.0;
/// What a point may be off the line drawn instead: a tenth of a pixel is invisible.
const TOLERANCE_PX: f64 = 0.1;
const FONT_PX: f64 = 12.5;

/// Writes `chart` as one `svg` element, with a style sheet of its own if given.
pub(super) fn draw(chart: &Chart, out: &mut Markup, style: Option<&str>) {
    let plot = Plot::of(chart);
    let (width, height) = (px(WIDTH_PX), px(plot.top_px + PLOT_HEIGHT_PX + BELOW_PX));
    let view = format!("0 0 {width} {height}");
    out.open(
        "svg",
        &[
            ("xmlns", "http://www.w3.org/2000/svg"),
            ("class", "chart"),
            ("role", "img"),
            ("width", &width),
            ("height", &height),
            ("viewBox", &view),
        ],
    );
    out.leaf("title", &[], &chart.title);
    out.leaf("desc", &[], &description(chart));
    if let Some(style) = style {
        out.trusted("<style>\n");
        out.trusted(style);
        out.trusted("</style>\n");
    }
    out.empty("rect", &[("class", "paper"), ("width", &width), ("height", &height)]);
    plot.write_axes(chart, out);
    plot.write_data(chart, out);
    legend::write(chart, out, plot.left_px);
    legend::write_marker_labels(&plot.marker_labels, out, plot.left_px, plot.top_px);
    out.close("svg");
}

/// Where the plot stands in the picture, and its axes.
struct Plot {
    left_px: f64,
    top_px: f64,
    width_px: f64,
    x: Scale,
    y: Scale,
    x_ticks: Ticks,
    y_ticks: Ticks,
    marker_labels: Vec<legend::MarkerLabel>,
}

impl Plot {
    fn of(chart: &Chart) -> Self {
        let plot = Self::with_left(chart, LEFT_PX);
        let widest = plot.y_ticks.marks.iter().map(|(_, label)| text_width_px(label)).fold(0.0, f64::max);
        // The axis' name is 14 px from the edge; labels end 7 px before the plot.
        let needed = widest + 30.0;
        if needed > LEFT_PX { Self::with_left(chart, needed.min(0.5 * WIDTH_PX)) } else { plot }
    }

    fn with_left(chart: &Chart, left_px: f64) -> Self {
        let width_px = WIDTH_PX - left_px - RIGHT_PX;
        let (x_range, y_range) = ranges(chart, width_px);
        let x = Scale { range: x_range, from_px: 0.0, to_px: width_px };
        let y = Scale { range: y_range, from_px: PLOT_HEIGHT_PX, to_px: 0.0 };
        let mut x_step = nice_step(x_range.span(), 8.0);
        let mut y_step = nice_step(y_range.span(), 7.0);
        if chart.equal_aspect {
            x_step = x_step.min(y_step);
        }
        let mut x_ticks = ticks(x_range, x_step);
        while x_ticks.marks.len() > 2 && crowded(&x_ticks, width_px) {
            x_step = nice_step(2.1 * x_step, 1.0);
            x_ticks = ticks(x_range, x_step);
        }
        if chart.equal_aspect {
            y_step = x_step;
        }
        let placed: Vec<_> = chart
            .markers
            .iter()
            .filter(|(_, at)| (x_range.min..=x_range.max).contains(at))
            .map(|(label, at)| (label.as_str(), x.px(*at)))
            .collect();
        let marker_labels = legend::place_marker_labels(&placed, width_px);
        let top_px = legend::height_px(chart, left_px) + legend::marker_strip_px(&marker_labels);
        let y_ticks = match chart.y_words.as_slice() {
            [] => ticks(y_range, y_step),
            words => Ticks { marks: words.to_vec(), exponent: 0 },
        };
        Self { left_px, top_px, width_px, x, y, x_ticks, y_ticks, marker_labels }
    }

    fn write_axes(&self, chart: &Chart, out: &mut Markup) {
        let (left, top) = (self.left_px, self.top_px);
        let (right, bottom) = (left + self.width_px, top + PLOT_HEIGHT_PX);
        for (value, label) in &self.x_ticks.marks {
            let x = left + self.x.px(*value);
            line(out, "grid", (x, top), (x, bottom));
            text(out, "middle", (x, bottom + 17.0), label);
        }
        for (value, label) in &self.y_ticks.marks {
            let y = top + self.y.px(*value);
            line(out, "grid", (left, y), (right, y));
            text(out, "end", (left - 7.0, y + 4.3), label);
        }
        let name = axis_name(&chart.x_name, &chart.x_unit, self.x_ticks.exponent);
        text(out, "middle", (left + 0.5 * self.width_px, bottom + 36.0), &legend::elided(&name, self.width_px));
        let name = axis_name(&chart.y_name, &chart.y_unit, self.y_ticks.exponent);
        let turned = format!("translate(14 {}) rotate(-90)", px(top + 0.5 * PLOT_HEIGHT_PX));
        out.leaf("text", &[("class", "middle"), ("transform", &turned)], &legend::elided(&name, PLOT_HEIGHT_PX));
    }

    /// Everything that the plot's edges cut off, in an inner `svg` that does
    /// so without a `clipPath`, whose id would clash on a page of many charts.
    fn write_data(&self, chart: &Chart, out: &mut Markup) {
        let (left, top) = (px(self.left_px), px(self.top_px));
        let (width, height) = (px(self.width_px), px(PLOT_HEIGHT_PX));
        let frame = [("x", left.as_str()), ("y", &top), ("width", &width), ("height", &height)];
        out.open("svg", &[&frame[..], &[("overflow", "hidden")]].concat());
        for Band { name, from, to } in chart.y_bands.iter().filter(known) {
            band(out, "y-band", name, (0.0, self.width_px), (self.y.px(*from), self.y.px(*to)));
        }
        for Band { name, from, to } in chart.x_bands.iter().filter(known) {
            band(out, "x-band", name, (self.x.px(*from), self.x.px(*to)), (0.0, PLOT_HEIGHT_PX));
        }
        for (label, at) in chart.markers.iter().filter(|(_, at)| drawable(*at)) {
            let x = self.x.px(*at);
            titled_path(out, "marker", label, &format!("M{} 0V{height}", px(x)));
        }
        for (name, at) in chart.limits.iter().filter(|(_, at)| drawable(*at)) {
            titled_path(out, "limit", name, &format!("M0 {}H{width}", px(self.y.px(*at))));
        }
        let (dotted, others): (Vec<_>, Vec<_>) =
            chart.series.iter().partition(|series| series.stroke == Stroke::Dotted);
        for series in others.into_iter().chain(dotted) {
            let path = self.path(series, chart.equal_aspect);
            if !path.is_empty() {
                out.empty("path", &[("class", &line_class(series)), ("d", &path)]);
            }
        }
        out.close("svg");
        out.empty("rect", &[&[("class", "frame")], &frame[..]].concat());
        if !chart.series.iter().any(|series| series.points.iter().any(shown)) {
            let middle = (self.left_px + 0.5 * self.width_px, self.top_px + 0.5 * PLOT_HEIGHT_PX + 4.0);
            text(out, "middle", middle, "no data");
        }
    }

    /// The series as path data, in pixels of the plot.
    fn path(&self, series: &Series, in_plane: bool) -> String {
        let ascending = !in_plane && series.points.is_sorted_by(|a, b| a.0.partial_cmp(&b.0).is_none_or(|o| o.is_le()));
        let mut path = String::new();
        for piece in series.points.split(|point| !shown(point)).filter(|piece| !piece.is_empty()) {
            let mut points: Vec<Point> = piece.iter().map(|(x, y)| (self.x.px(*x), self.y.px(*y))).collect();
            if ascending {
                points = extremes_per_column(&points);
            }
            points = straighten(&points, TOLERANCE_PX);
            if let [lone] = points[..] {
                // A line to itself is a dot, thanks to its round cap.
                points.push(lone);
            }
            for (nth, (x, y)) in points.iter().enumerate() {
                path.push_str(if nth == 0 { "M" } else { " " });
                path.push_str(&px(*x));
                path.push(' ');
                path.push_str(&px(*y));
            }
        }
        path
    }
}

/// What the axes span: as asked for, else the data with some room.
fn ranges(chart: &Chart, width_px: f64) -> (Range, Range) {
    let points = || chart.series.iter().flat_map(|series| &series.points).filter(|point| shown(point));
    let nothing = Range { min: 0.0, max: 1.0 };
    let asked = |range: Option<(f64, f64)>| range.and_then(|(from, to)| Range::of([from, to].into_iter()));
    let x_extras = chart.markers.iter().map(|(_, at)| *at).chain(ends(&chart.x_bands));
    let y_extras = chart.limits.iter().map(|(_, at)| *at).chain(ends(&chart.y_bands));
    let x_data = Range::of(points().map(|point| point.0)).or_else(|| Range::of(x_extras)).unwrap_or(nothing);
    let y_data = Range::of(points().map(|point| point.1).chain(y_extras)).unwrap_or(nothing);
    let x_room = if chart.equal_aspect { 1.1 } else { 1.0 };
    let mut x = asked(chart.x_range).unwrap_or(x_data.with_span(x_room * x_data.span()));
    let mut y = asked(chart.y_range).unwrap_or(y_data.with_span(1.1 * y_data.span()));
    if chart.equal_aspect {
        let unit_px = (width_px / x.span()).min(PLOT_HEIGHT_PX / y.span());
        (x, y) = (x.with_span(width_px / unit_px), y.with_span(PLOT_HEIGHT_PX / unit_px));
    }
    (x, y)
}

fn ends(bands: &[Band]) -> impl Iterator<Item = f64> {
    bands.iter().flat_map(|band| [band.from, band.to])
}

/// A band may reach to infinity, but not from nowhere.
fn known(band: &&Band) -> bool {
    !band.from.is_nan() && !band.to.is_nan()
}

fn shown(point: &(f64, f64)) -> bool {
    drawable(point.0) && drawable(point.1)
}

/// Whether two tick labels would touch.
fn crowded(ticks: &Ticks, width_px: f64) -> bool {
    let widest = ticks.marks.iter().map(|(_, label)| text_width_px(label)).fold(0.0, f64::max);
    (widest + 14.0) * ticks.marks.len() as f64 > width_px
}

/// `heading (rad)`, `x (10⁴² m)`.
fn axis_name(name: &str, unit: &str, exponent: i32) -> String {
    let scale = if exponent == 0 { String::new() } else { power_of_ten(exponent) };
    match (scale.as_str(), unit) {
        ("", "") => name.to_owned(),
        ("", word) | (word, "") => format!("{name} ({word})"),
        (scale, unit) => format!("{name} ({scale} {unit})"),
    }
}

/// For those who hear the chart.
fn description(chart: &Chart) -> String {
    let names: Vec<_> = chart.series.iter().map(|series| series.name.as_str()).collect();
    let (x, y) = (axis_name(&chart.x_name, &chart.x_unit, 0), axis_name(&chart.y_name, &chart.y_unit, 0));
    format!("{y} over {x}: {}", names.join(", "))
}

/// The classes that give a series its stroke and colour.
pub(super) fn line_class(series: &Series) -> String {
    let stroke = match series.stroke {
        Stroke::Solid => "solid",
        Stroke::Dotted => "dotted",
        Stroke::Dashed => "dashed",
    };
    let role = match series.role {
        Role::Reference => "reference",
        Role::Response => "response",
        Role::Estimate => "estimate",
        Role::Right => "right",
        Role::Left => "left",
    };
    format!("line {stroke} {role}")
}

/// A length, to a hundredth of a pixel.
pub(super) fn px(value: f64) -> String {
    let digits = format!("{value:.2}");
    let short = digits.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".into() } else { short.into() }
}

/// About how wide a text is. The reader's font is unknown, so this errs on the wide side.
pub(super) fn text_width_px(text: &str) -> f64 {
    let ems: f64 = text
        .chars()
        .map(|character| match character {
            'i' | 'j' | 'l' | 'I' | '.' | ',' | ':' | '\'' | '|' => 0.3,
            ' ' | 'f' | 't' | 'r' | '(' | ')' | '/' | '-' => 0.4,
            'm' | 'w' | 'M' | 'W' | '@' | '%' => 0.9,
            '−' | 'a'..='z' | '0'..='9' => 0.6,
            other if other.is_ascii() => 0.7,
            _ => 0.8,
        })
        .sum();
    ems * FONT_PX
}

pub(super) fn text(out: &mut Markup, class: &str, at: Point, text: &str) {
    out.leaf("text", &[("class", class), ("x", &px(at.0)), ("y", &px(at.1))], text);
}

fn line(out: &mut Markup, class: &str, from: Point, to: Point) {
    let path = format!("M{} {}L{} {}", px(from.0), px(from.1), px(to.0), px(to.1));
    out.empty("path", &[("class", class), ("d", &path)]);
}

fn titled_path(out: &mut Markup, class: &str, title: &str, path: &str) {
    out.open("path", &[("class", class), ("d", path)]);
    out.leaf("title", &[], title);
    out.close("path");
}

fn band(out: &mut Markup, class: &str, title: &str, x: Point, y: Point) {
    let corner = (x.0.min(x.1), y.0.min(y.1));
    let (width, height) = ((x.1 - x.0).abs(), (y.1 - y.0).abs());
    let place = [("x", px(corner.0)), ("y", px(corner.1)), ("width", px(width)), ("height", px(height))];
    let mut attributes = vec![("class", class)];
    attributes.extend(place.iter().map(|(name, value)| (*name, value.as_str())));
    out.open("rect", &attributes);
    out.leaf("title", &[], title);
    out.close("rect");
}
