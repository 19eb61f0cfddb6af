//! What a chart shows. How it is drawn is in `svg.rs`.

use super::markup::Markup;
use super::svg;

/// A line chart: series over a common x axis, or a track in the plane.
///
/// Numbers that are not finite (or beyond +-1e300) interrupt a line. Points
/// that nobody could tell apart at the size of the picture are left out;
/// spikes stay.
#[derive(Clone, Debug, Default)]
pub struct Chart {
    pub(super) title: String,
    pub(super) x_name: String,
    pub(super) x_unit: String,
    pub(super) y_name: String,
    pub(super) y_unit: String,
    pub(super) x_range: Option<(f64, f64)>,
    pub(super) y_range: Option<(f64, f64)>,
    pub(super) y_words: Vec<(f64, String)>,
    pub(super) equal_aspect: bool,
    pub(super) series: Vec<Series>,
    pub(super) limits: Vec<(String, f64)>,
    pub(super) markers: Vec<(String, f64)>,
    pub(super) x_bands: Vec<Band>,
    pub(super) y_bands: Vec<Band>,
}

/// One line of a chart.
#[derive(Clone, Debug)]
pub struct Series {
    pub(super) name: String,
    pub(super) role: Role,
    pub(super) stroke: Stroke,
    pub(super) points: Vec<(f64, f64)>,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// Without gaps.
    Solid,
    /// Round dots, drawn above the other lines so that a line it coincides
    /// with hides neither.
    Dotted,
    /// Dashes.
    Dashed,
}

/// What a line stands for, which decides its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// What was asked for.
    Reference,
    /// What really came.
    Response,
    /// What the robot believes, such as odometry.
    Estimate,
    /// The right wheel, the paper's wheel 1.
    Right,
    /// The left wheel, the paper's wheel 2.
    Left,
}

/// A shaded stretch of an axis.
#[derive(Clone, Debug)]
pub(super) struct Band {
    pub name: String,
    pub from: f64,
    pub to: f64,
}

impl Chart {
    /// An empty chart.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// Labels the x axis; `unit` may be empty.
    pub fn x_axis(mut self, name: impl Into<String>, unit: impl Into<String>) -> Self {
        (self.x_name, self.x_unit) = (name.into(), unit.into());
        self
    }

    /// Labels the y axis; `unit` may be empty.
    pub fn y_axis(mut self, name: impl Into<String>, unit: impl Into<String>) -> Self {
        (self.y_name, self.y_unit) = (name.into(), unit.into());
        self
    }

    /// Shows this part of the x axis, whatever the data span.
    pub fn x_range(mut self, from: f64, to: f64) -> Self {
        self.x_range = Some((from, to));
        self
    }

    /// Shows this part of the y axis, whatever the data span. Lines that leave
    /// it are cut off.
    pub fn y_range(mut self, from: f64, to: f64) -> Self {
        self.y_range = Some((from, to));
        self
    }

    /// Writes words beside the y axis in place of numbers.
    pub fn y_words<'w>(mut self, words: impl IntoIterator<Item = (f64, &'w str)>) -> Self {
        self.y_words = words.into_iter().map(|(y, word)| (y, word.to_owned())).collect();
        self
    }

    /// One unit is as long on the x axis as on the y axis: a circle is round.
    /// The axis that has room to spare shows more than was asked for.
    pub fn equal_aspect(mut self) -> Self {
        self.equal_aspect = true;
        self
    }

    /// Adds a line.
    pub fn series(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Adds a horizontal line across the chart; the y axis is made to hold it.
    pub fn limit(mut self, name: impl Into<String>, y: f64) -> Self {
        self.limits.push((name.into(), y));
        self
    }

    /// Adds a vertical line with a label above the chart. A label that finds
    /// no room in four rows shows as a tool tip only.
    pub fn marker(mut self, label: impl Into<String>, x: f64) -> Self {
        self.markers.push((label.into(), x));
        self
    }

    /// Shades a stretch of the x axis, such as the time for which a fault lasted.
    pub fn x_band(mut self, name: impl Into<String>, from: f64, to: f64) -> Self {
        self.x_bands.push(Band { name: name.into(), from, to });
        self
    }

    /// Shades a stretch of the y axis, such as a tolerance.
    pub fn y_band(mut self, name: impl Into<String>, from: f64, to: f64) -> Self {
        self.y_bands.push(Band { name: name.into(), from, to });
        self
    }

    /// The chart as an SVG file of its own, in light or dark colours as the
    /// reader prefers.
    pub fn to_svg(&self) -> String {
        let mut markup = Markup::default();
        svg::draw(self, &mut markup, Some(include_str!("chart.css")));
        markup.finish()
    }
}

impl Series {
    /// A line through `points`, in the axes' units.
    pub fn new(name: impl Into<String>, role: Role, stroke: Stroke, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), role, stroke, points }
    }

    /// A dotted line named "reference".
    pub fn reference(points: Vec<(f64, f64)>) -> Self {
        Self::new("reference", Role::Reference, Stroke::Dotted, points)
    }

    /// A solid line named "response".
    pub fn response(points: Vec<(f64, f64)>) -> Self {
        Self::new("response", Role::Response, Stroke::Solid, points)
    }
}
