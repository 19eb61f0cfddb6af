//! A path from the `[path]` section of a configuration.

use super::Path;
use super::geometry::{Geometry, Shape};
use super::profile::SpeedProfile;
use crate::config::{Bound, Section};
use crate::robot::Pose;

// Far beyond what wheels do: a wrong unit or a slip of the key, no path.
const FIELD_M: Bound = Bound::Within(-1e6, 1e6);
const LENGTH_M: Bound = Bound::Within(1e-6, 1e6);
const ANGLE_RAD: Bound = Bound::Within(-1e3, 1e3);
const DURATION_S: Bound = Bound::Within(1e-3, 1e9);
/// For accelerations, too.
const SPEED_M_S: Bound = Bound::Within(1e-6, 1e6);

/// Keys of one kind or another.
const ALL_KEYS: [&str; 15] = [
    "center_m",
    "radius_m",
    "duration_s",
    "start_angle_rad",
    "clockwise",
    "from_m",
    "to_m",
    "width_m",
    "axis_rad",
    "heading_rad",
    "speed_m_s",
    "acceleration_m_s2",
    "easing_m",
    "segment",
    "kind",
];

#[derive(Clone, Copy)]
enum Kind {
    Circle,
    Line,
    FigureEight,
    Segments,
}

/// A line or an arc: length, m, signed curvature, rad/m, and speed limit, m/s.
struct Segment {
    length_m: f64,
    curvature_per_m: f64,
    speed_limit_m_s: f64,
}

impl Path {
    /// Reads a path; what is wrong is reported to the section's reader, and
    /// the path that comes back is then of no use.
    pub fn read(section: &Section<'_>) -> Self {
        let kinds = [
            ("circle", Kind::Circle),
            ("line", Kind::Line),
            ("figure-eight", Kind::FigureEight),
            ("segments", Kind::Segments),
        ];
        section.allow(&ALL_KEYS);
        match section.choice("kind", &kinds, true) {
            Kind::Circle => circle(section),
            Kind::Line => line(section),
            Kind::FigureEight => figure_eight(section),
            Kind::Segments => segments(section),
        }
    }
}

/// Eq 19: once around, counter-clockwise unless told otherwise.
fn circle(section: &Section<'_>) -> Path {
    let [center_x, center_y] = section.numbers("center_m", FIELD_M);
    let radius_m = section.number("radius_m", LENGTH_M);
    let duration_s = section.number("duration_s", DURATION_S);
    let start_angle_rad = section.number_or("start_angle_rad", 0.0, ANGLE_RAD);
    let side = if section.boolean_or("clockwise", false) { -1.0 } else { 1.0 };
    let (sin, cos) = libm::sincos(start_angle_rad);
    let start = Pose {
        x_m: center_x + radius_m * cos,
        y_m: center_y + radius_m * sin,
        heading_rad: start_angle_rad + side * std::f64::consts::FRAC_PI_2,
    };
    let length_m = 2.0 * std::f64::consts::PI * radius_m;
    let arc = Shape::Arc { curvature_per_m: side / radius_m };
    Path::new(Geometry::new(start, &[(length_m, arc)]), SpeedProfile::even(length_m, duration_s))
}

fn line(section: &Section<'_>) -> Path {
    let [from_x, from_y] = section.numbers("from_m", FIELD_M);
    let [to_x, to_y] = section.numbers("to_m", FIELD_M);
    let duration_s = section.number("duration_s", DURATION_S);
    let length_m = libm::hypot(to_x - from_x, to_y - from_y);
    if length_m == 0.0 {
        section.complain("to_m", "found the same point as `from_m`, expected another");
    }
    let start = Pose { x_m: from_x, y_m: from_y, heading_rad: libm::atan2(to_y - from_y, to_x - from_x) };
    let geometry = Geometry::new(start, &[(length_m, Shape::Arc { curvature_per_m: 0.0 })]);
    Path::new(geometry, SpeedProfile::Soft { length_m, duration_s })
}

fn figure_eight(section: &Section<'_>) -> Path {
    let center_m = section.numbers("center_m", FIELD_M);
    let width_m = section.number("width_m", LENGTH_M);
    let duration_s = section.number("duration_s", DURATION_S);
    let axis_rad = section.number_or("axis_rad", 0.0, ANGLE_RAD);
    let geometry = Geometry::figure_eight(center_m, width_m, axis_rad);
    let length_m = geometry.length_m();
    Path::new(geometry, SpeedProfile::Soft { length_m, duration_s })
}

/// Lines and arcs under a speed limit; `easing_m` turns the jumps of
/// curvature between them into clothoids of that length inside the arcs.
fn segments(section: &Section<'_>) -> Path {
    let [x_m, y_m] = section.numbers("from_m", FIELD_M);
    let heading_rad = section.number("heading_rad", ANGLE_RAD);
    let speed_m_s = section.number("speed_m_s", SPEED_M_S);
    let acceleration_m_s2 = section.number("acceleration_m_s2", SPEED_M_S);
    let easing_m = section.number_or("easing_m", 0.0, Bound::Within(0.0, 1e6));
    let tables = section.sections("segment");
    if tables.is_empty() {
        section.complain("segment", "found no segment, expected at least one [[path.segment]]");
    }
    let mut shapes = Vec::new();
    let mut stretches = Vec::new();
    for table in &tables {
        let segment = segment(table, speed_m_s);
        if segment.curvature_per_m != 0.0 && segment.length_m <= easing_m {
            table.complain("arc_rad", "found an arc shorter than `easing_m`, expected a longer one");
        }
        lay(&segment, easing_m, &mut shapes, &mut stretches);
    }
    if shapes.is_empty() {
        shapes.push((1.0, Shape::Arc { curvature_per_m: 0.0 }));
    }
    let start = Pose { x_m, y_m, heading_rad };
    Path::new(Geometry::new(start, &shapes), SpeedProfile::limited(&stretches, acceleration_m_s2))
}

fn segment(table: &Section<'_>, speed_m_s: f64) -> Segment {
    let speed_limit_m_s = table.number_or("speed_m_s", speed_m_s, SPEED_M_S);
    if table.has("line_m") == table.has("arc_rad") {
        table.complain("line_m", "expected either `line_m`, or `arc_rad` with `radius_m`");
    }
    if table.has("line_m") {
        let length_m = table.number("line_m", LENGTH_M);
        return Segment { length_m, curvature_per_m: 0.0, speed_limit_m_s };
    }
    let arc_rad = table.number("arc_rad", ANGLE_RAD);
    let radius_m = table.number("radius_m", LENGTH_M);
    if arc_rad == 0.0 {
        table.complain("arc_rad", "found 0, expected an angle: positive turns left, negative right");
    }
    Segment { length_m: arc_rad.abs() * radius_m, curvature_per_m: arc_rad.signum() / radius_m, speed_limit_m_s }
}

/// An eased arc turns by as much as the sharp one: its ramps, which turn half
/// as much a metre, each take half their length from it and add it outside.
fn lay(segment: &Segment, easing_m: f64, shapes: &mut Vec<(f64, Shape)>, stretches: &mut Vec<(f64, f64)>) {
    let curvature_per_m = segment.curvature_per_m;
    let mut push = |length_m: f64, shape: Shape| {
        shapes.push((length_m, shape));
        stretches.push((length_m, segment.speed_limit_m_s));
    };
    if curvature_per_m == 0.0 || easing_m == 0.0 {
        return push(segment.length_m, Shape::Arc { curvature_per_m });
    }
    let rate_per_m2 = curvature_per_m / easing_m;
    push(easing_m, Shape::Ramp { curvature_per_m: 0.0, rate_per_m2 });
    push(segment.length_m - easing_m, Shape::Arc { curvature_per_m });
    push(easing_m, Shape::Ramp { curvature_per_m, rate_per_m2: -rate_per_m2 });
}
