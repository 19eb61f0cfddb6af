//! Curves in the plane by arc length.

use crate::robot::Pose;

/// Pieces of curve laid end to end.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    pieces: Vec<Piece>,
    length_m: f64,
}

/// A point of the curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Place and direction; the heading is not wrapped.
    pub pose: Pose,
    /// Turn to the left a metre, rad/m.
    pub curvature_per_m: f64,
    /// Its change a metre, rad/m^2.
    pub curvature_rate_per_m2: f64,
}

/// The heading of a piece, as a function of the distance into it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A straight line (curvature 0) or an arc.
    Arc {
        /// rad/m, positive to the left.
        curvature_per_m: f64,
    },
    /// A clothoid: the curvature changes evenly.
    Ramp {
        /// At the beginning, rad/m.
        curvature_per_m: f64,
        /// rad/m^2.
        rate_per_m2: f64,
    },
    /// A stretch of a sine-generated curve, heading = swing cos(u), where u
    /// grows evenly from `phase_rad`.
    Wave {
        /// Amplitude of the heading, rad.
        swing_rad: f64,
        /// u at the beginning, rad.
        phase_rad: f64,
        /// Growth of u, rad/m.
        rate_rad_m: f64,
    },
}

#[derive(Clone, Debug, PartialEq)]
struct Piece {
    start_m: f64,
    start: Pose,
    shape: Shape,
}

/// First zero of the Bessel function J0: a sine-generated curve that swings
/// by this much closes into a figure eight.
const EIGHT_SWING_RAD: f64 = 2.404_825_557_695_773;

impl Geometry {
    /// Lays pieces of `(length_m, shape)` end to end from `start`.
    pub fn new(start: Pose, shapes: &[(f64, Shape)]) -> Self {
        let mut geometry = Self { pieces: Vec::with_capacity(shapes.len()), length_m: 0.0 };
        let mut end = start;
        for &(length_m, shape) in shapes {
            let piece = Piece { start_m: geometry.length_m, start: end, shape };
            end = piece.at(length_m).pose;
            geometry.pieces.push(piece);
            geometry.length_m += length_m;
        }
        geometry
    }

    /// A figure eight that begins in its middle, `width_m` from tip to tip
    /// along `axis_rad`.
    pub fn figure_eight(center_m: [f64; 2], width_m: f64, axis_rad: f64) -> Self {
        const PIECES: usize = 64;
        let full_turn = 2.0 * std::f64::consts::PI;
        let lay = |length_m: f64, middle: Pose| {
            let shapes = std::array::from_fn::<_, PIECES, _>(|index| {
                let shape = Shape::Wave {
                    swing_rad: EIGHT_SWING_RAD,
                    phase_rad: full_turn * index as f64 / PIECES as f64,
                    rate_rad_m: full_turn / length_m,
                };
                (length_m / PIECES as f64, shape)
            });
            Self::new(middle, &shapes)
        };
        // The tip lies a quarter of the way along, square to where the wave's mean points.
        let unit = lay(1.0, Pose { heading_rad: EIGHT_SWING_RAD, ..Pose::default() });
        let length_m = width_m / (2.0 * unit.at(0.25).pose.y_m);
        let heading_rad = axis_rad - std::f64::consts::FRAC_PI_2 + EIGHT_SWING_RAD;
        lay(length_m, Pose { x_m: center_m[0], y_m: center_m[1], heading_rad })
    }

    /// The point `distance_m` along, clamped to the curve's ends.
    pub fn at(&self, distance_m: f64) -> Point {
        let distance_m = distance_m.clamp(0.0, self.length_m);
        let after = self.pieces.partition_point(|piece| piece.start_m <= distance_m);
        let piece = &self.pieces[after.max(1) - 1];
        piece.at(distance_m - piece.start_m)
    }

    /// Where it begins.
    pub fn start(&self) -> Pose {
        self.pieces[0].start
    }

    /// Length, m.
    pub fn length_m(&self) -> f64 {
        self.length_m
    }
}

impl Piece {
    fn at(&self, into_m: f64) -> Point {
        let (turn_rad, curvature_per_m, curvature_rate_per_m2) = self.shape.turn(into_m);
        let heading_rad = self.start.heading_rad + turn_rad;
        let (dx_m, dy_m) = self.displacement(into_m, heading_rad);
        Point {
            pose: Pose { x_m: self.start.x_m + dx_m, y_m: self.start.y_m + dy_m, heading_rad },
            curvature_per_m,
            curvature_rate_per_m2,
        }
    }

    fn displacement(&self, into_m: f64, heading_rad: f64) -> (f64, f64) {
        let start_rad = self.start.heading_rad;
        match self.shape {
            Shape::Arc { curvature_per_m: 0.0 } => {
                let (sin, cos) = libm::sincos(start_rad);
                (into_m * cos, into_m * sin)
            }
            Shape::Arc { curvature_per_m } => {
                let ((sin_0, cos_0), (sin_1, cos_1)) = (libm::sincos(start_rad), libm::sincos(heading_rad));
                ((sin_1 - sin_0) / curvature_per_m, (cos_0 - cos_1) / curvature_per_m)
            }
            shape => integrate(into_m, |at_m| libm::sincos(start_rad + shape.turn(at_m).0)),
        }
    }
}

impl Shape {
    /// Heading gained, curvature and its rate, `into_m` from the beginning.
    fn turn(self, into_m: f64) -> (f64, f64, f64) {
        match self {
            Self::Arc { curvature_per_m } => (curvature_per_m * into_m, curvature_per_m, 0.0),
            Self::Ramp { curvature_per_m, rate_per_m2 } => (
                (curvature_per_m + 0.5 * rate_per_m2 * into_m) * into_m,
                curvature_per_m + rate_per_m2 * into_m,
                rate_per_m2,
            ),
            Self::Wave { swing_rad, phase_rad, rate_rad_m } => {
                let (sin, cos) = libm::sincos(phase_rad + rate_rad_m * into_m);
                (
                    swing_rad * (cos - libm::cos(phase_rad)),
                    -swing_rad * rate_rad_m * sin,
                    -swing_rad * rate_rad_m * rate_rad_m * cos,
                )
            }
        }
    }
}

/// The integral of `(cos, sin)` of the heading over `length_m`, by Gauss and
/// Legendre's rule of order 8: exact to rounding while the piece turns by less
/// than about a radian.
fn integrate(length_m: f64, sincos_at: impl Fn(f64) -> (f64, f64)) -> (f64, f64) {
    const NODES: [(f64, f64); 4] = [
        (0.183_434_642_495_649_8, 0.362_683_783_378_362),
        (0.525_532_409_916_329, 0.313_706_645_877_887_29),
        (0.796_666_477_413_626_7, 0.222_381_034_453_374_47),
        (0.960_289_856_497_536_2, 0.101_228_536_290_376_26),
    ];
    let half_m = 0.5 * length_m;
    let (mut x_m, mut y_m) = (0.0, 0.0);
    for (node, weight) in NODES {
        for side in [-node, node] {
            let (sin, cos) = sincos_at(half_m * (1.0 + side));
            x_m += weight * half_m * cos;
            y_m += weight * half_m * sin;
        }
    }
    (x_m, y_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_arc_comes_back_to_its_start() {
        let start = Pose { x_m: 9.0, y_m: 5.0, heading_rad: std::f64::consts::FRAC_PI_2 };
        let length_m = 8.0 * std::f64::consts::PI;
        let circle = Geometry::new(start, &[(length_m, Shape::Arc { curvature_per_m: 0.25 })]);
        assert!(circle.at(length_m).pose.distance_m(&start) < 1e-12);
        assert!((circle.at(length_m / 2.0).pose.x_m - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_figure_eight_closes_and_is_as_wide_as_asked() {
        let eight = Geometry::figure_eight([2.0, -1.0], 6.0, 0.3);
        let point = |share: f64| eight.at(share * eight.length_m()).pose;
        for share in [0.5, 1.0] {
            assert!(point(share).distance_m(&point(0.0)) < 1e-12, "not back in the middle at {share}");
        }
        assert!((point(0.25).distance_m(&point(0.75)) - 6.0).abs() < 1e-12);
        let axis = libm::atan2(point(0.25).y_m - point(0.75).y_m, point(0.25).x_m - point(0.75).x_m);
        assert!((axis - 0.3).abs() < 1e-12, "the axis points to {axis}");
    }

    #[test]
    fn heading_and_curvature_are_the_curve_s_own_derivatives() {
        let shapes = [
            (1.0, Shape::Arc { curvature_per_m: 0.0 }),
            (0.5, Shape::Ramp { curvature_per_m: 0.0, rate_per_m2: 2.0 }),
            (0.7, Shape::Arc { curvature_per_m: 1.0 }),
        ];
        let curves = [Geometry::new(Pose::default(), &shapes), Geometry::figure_eight([0.0, 0.0], 3.0, 0.0)];
        let step_m = 1e-5;
        for curve in &curves {
            for index in 1..100 {
                let at_m = curve.length_m() * f64::from(index) / 100.3;
                let (before, now, after) = (curve.at(at_m - step_m), curve.at(at_m), curve.at(at_m + step_m));
                let dx = (after.pose.x_m - before.pose.x_m) / (2.0 * step_m);
                let dy = (after.pose.y_m - before.pose.y_m) / (2.0 * step_m);
                assert!((dx - libm::cos(now.pose.heading_rad)).abs() < 1e-8);
                assert!((dy - libm::sin(now.pose.heading_rad)).abs() < 1e-8);
                let turn = (after.pose.heading_rad - before.pose.heading_rad) / (2.0 * step_m);
                assert!((turn - now.curvature_per_m).abs() < 1e-4, "at {at_m} m");
            }
        }
    }
}
