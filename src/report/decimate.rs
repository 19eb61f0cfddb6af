//! Fewer points, same picture. All coordinates are pixels.

/// A place in the picture, x and y in pixels.
pub(super) type Point = (f64, f64);

/// For a line whose x never decreases: keeps the lowest and the highest point
/// of each pixel column, so at most two a pixel and every spike, and the ends.
pub(super) fn extremes_per_column(points: &[Point]) -> Vec<Point> {
    let mut kept = Vec::new();
    for column in points.chunk_by(|a, b| a.0.floor() == b.0.floor()) {
        let (mut low, mut high) = (0, 0);
        for (nth, point) in column.iter().enumerate() {
            low = if point.1 < column[low].1 { nth } else { low };
            high = if point.1 > column[high].1 { nth } else { high };
        }
        kept.push(column[low.min(high)]);
        if low != high {
            kept.push(column[low.max(high)]);
        }
    }
    if let (Some(first), Some(last)) = (points.first(), points.last()) {
        if kept.first() != Some(first) {
            kept.insert(0, *first);
        }
        if kept.last() != Some(last) {
            kept.push(*last);
        }
    }
    kept
}

/// For any line: leaves out the points that lie within `tolerance` of the
/// straight segment drawn instead (the cone intersection method of Sklansky
/// and Gonzalez, 1980; one pass). The ends stay.
pub(super) fn straighten(points: &[Point], tolerance: f64) -> Vec<Point> {
    let Some((&first, rest)) = points.split_first() else { return Vec::new() };
    let mut kept = vec![first];
    let mut sleeve = Sleeve::at(first);
    let mut last = first;
    for &point in rest {
        if !sleeve.take(point, tolerance) {
            kept.push(last);
            sleeve = Sleeve::at(last);
            sleeve.take(point, tolerance);
        }
        last = point;
    }
    if !rest.is_empty() {
        kept.push(last);
    }
    kept
}

/// The directions in which a straight segment may leave the anchor and still
/// pass every point so far within the tolerance.
struct Sleeve {
    anchor: Point,
    /// Bounding directions, clockwise and anticlockwise, once there is one.
    cone: Option<(Point, Point)>,
    /// Greatest distance from the anchor so far.
    reach: f64,
}

impl Sleeve {
    fn at(anchor: Point) -> Self {
        Self { anchor, cone: None, reach: 0.0 }
    }

    /// Takes the point in, or says that a segment must end before it.
    fn take(&mut self, point: Point, tolerance: f64) -> bool {
        let offset = (point.0 - self.anchor.0, point.1 - self.anchor.1);
        let distance = (offset.0 * offset.0 + offset.1 * offset.1).sqrt();
        // Turning back on the same line would cut the tip off.
        if distance < self.reach - tolerance {
            return false;
        }
        self.reach = self.reach.max(distance);
        if distance <= tolerance {
            return self.cone.is_none();
        }
        let (sin, cos) = (tolerance / distance, (1.0 - tolerance * tolerance / (distance * distance)).sqrt());
        let (ahead, aside) = ((offset.0 / distance, offset.1 / distance), (-offset.1 / distance, offset.0 / distance));
        let right = (cos * ahead.0 - sin * aside.0, cos * ahead.1 - sin * aside.1);
        let left = (cos * ahead.0 + sin * aside.0, cos * ahead.1 + sin * aside.1);
        self.cone = match self.cone {
            None => Some((right, left)),
            Some((old_right, old_left)) if cross(old_right, ahead) >= 0.0 && cross(ahead, old_left) >= 0.0 => Some((
                if cross(old_right, right) > 0.0 { right } else { old_right },
                if cross(left, old_left) > 0.0 { left } else { old_left },
            )),
            Some(_) => return false,
        };
        true
    }
}

fn cross(a: Point, b: Point) -> f64 {
    a.0 * b.1 - a.1 * b.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wave of two periods across 400 px, 100 points a pixel.
    fn wave() -> Vec<Point> {
        (0..=40_000).map(|nth| f64::from(nth) / 100.0).map(|x| (x, 100.0 + 80.0 * libm::sin(x / 32.0))).collect()
    }

    #[test]
    fn columns_keep_single_sample_spikes_both_ways() {
        let mut points = wave();
        points[12_345].1 = 300.0;
        points[12_350].1 = -50.0;
        let kept = extremes_per_column(&points);
        assert!(kept.contains(&points[12_345]) && kept.contains(&points[12_350]));
        assert!(kept.len() <= 2 * 401, "{} points in 401 columns", kept.len());
        assert!(kept.is_sorted_by(|a, b| a.0 <= b.0));
        assert_eq!((kept.first(), kept.last()), (points.first(), points.last()));
    }

    #[test]
    fn straightening_stays_within_the_tolerance() {
        let points = wave();
        let kept = straighten(&points, 0.1);
        assert!(kept.len() < 100, "{} points", kept.len());
        let mut segments = kept.windows(2);
        let mut segment = segments.next().expect("two points");
        for point in &points {
            while point.0 > segment[1].0 {
                segment = segments.next().expect("the ends stay");
            }
            let slope = (segment[1].1 - segment[0].1) / (segment[1].0 - segment[0].0);
            let off = segment[0].1 + slope * (point.0 - segment[0].0) - point.1;
            assert!(off.abs() / (1.0 + slope * slope).sqrt() <= 0.1 + 1e-9, "{point:?} is off by {off}");
        }
    }

    #[test]
    fn straightening_keeps_the_tip_of_a_line_that_turns_back() {
        let there_and_back = [(0.0, 0.0), (5.0, 0.0), (10.0, 0.0), (5.0, 0.0), (2.0, 0.0)];
        assert_eq!(straighten(&there_and_back, 0.1), [(0.0, 0.0), (10.0, 0.0), (2.0, 0.0)]);
    }

    #[test]
    fn nothing_and_one_point_survive() {
        for points in [&[][..], &[(1.0, 2.0)]] {
            assert_eq!(extremes_per_column(points), points);
            assert_eq!(straighten(points, 0.1), points);
        }
    }
}
