//! Axes: which numbers they span, where the ticks go, how numbers are written.

/// Beyond this a number counts as not finite: sums and spans would overflow.
const LARGEST: f64 = 1e300;
/// A span smaller than this share of its numbers is rounding noise.
const NOISE: f64 = 1e-9;

/// Whether a number can be drawn at all.
pub(super) fn drawable(value: f64) -> bool {
    value.abs() <= LARGEST
}

/// The numbers that an axis spans; `min < max`, both drawable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    pub min: f64,
    pub max: f64,
}

impl Range {
    /// The smallest range that holds every drawable value, or `None` if there
    /// is none. One lone value gets room on both sides.
    pub fn of(values: impl Iterator<Item = f64>) -> Option<Self> {
        let (min, max) = values
            .filter(|value| drawable(*value))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), value| (min.min(value), max.max(value)));
        if min > max {
            return None;
        }
        let magnitude = min.abs().max(max.abs());
        if max - min > NOISE * magnitude && max - min > f64::MIN_POSITIVE / NOISE {
            return Some(Self { min, max });
        }
        let room = if magnitude > f64::MIN_POSITIVE / NOISE { 0.1 * magnitude } else { 1.0 };
        Some(Self { min: min - room, max: max + room })
    }

    pub fn span(self) -> f64 {
        self.max - self.min
    }

    /// The same centre, another span.
    pub fn with_span(self, span: f64) -> Self {
        let centre = 0.5 * self.min + 0.5 * self.max;
        Self { min: centre - 0.5 * span, max: centre + 0.5 * span }
    }
}

/// Maps numbers to pixels, linearly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    pub range: Range,
    /// Where `range.min` is drawn.
    pub from_px: f64,
    /// Where `range.max` is drawn.
    pub to_px: f64,
}

impl Scale {
    /// Where `value` is drawn. Far outside the picture all numbers are the
    /// same: renderers compute in 32 bits.
    pub fn px(&self, value: f64) -> f64 {
        let share = (value - self.range.min) / self.range.span();
        self.from_px + share.clamp(-20.0, 21.0) * (self.to_px - self.from_px)
    }
}

/// An axis' ticks and their labels.
#[derive(Debug)]
pub(super) struct Ticks {
    /// Value and label, ascending.
    pub marks: Vec<(f64, String)>,
    /// Labels are in units of ten to this power, a multiple of three.
    pub exponent: i32,
}

/// The smallest step of 1, 2 or 5 times a power of ten that cuts `span` into
/// `most` parts or fewer.
pub(super) fn nice_step(span: f64, most: f64) -> f64 {
    let decade = ten_to(exponent_of(span / most));
    let fits = |step: &f64| span / step <= most * (1.0 + NOISE);
    [decade, 2.0 * decade, 5.0 * decade].into_iter().find(fits).unwrap_or(10.0 * decade)
}

/// The multiples of `step` within `range`.
pub(super) fn ticks(range: Range, step: f64) -> Ticks {
    let magnitude = range.min.abs().max(range.max.abs());
    let exponent = if (1e-3..1e5).contains(&magnitude) { 0 } else { exponent_of(magnitude).div_euclid(3) * 3 };
    let decimals = usize::try_from(exponent - exponent_of(step * (1.0 + NOISE))).unwrap_or(0);
    let first = (range.min / step - NOISE).ceil();
    let count = ((range.max / step + NOISE).floor() - first).clamp(0.0, 100.0) as usize;
    let marks = (0..=count)
        .map(|nth| {
            let value = (first + nth as f64) * step;
            let label = if value == 0.0 { "0".into() } else { decimal(value / ten_to(exponent), decimals) };
            (value, label)
        })
        .collect();
    Ticks { marks, exponent }
}

/// A number with so many decimals and a true minus sign, but no "minus zero".
pub(super) fn decimal(value: f64, decimals: usize) -> String {
    let digits = format!("{:.decimals$}", value.abs());
    let is_zero = digits.bytes().all(|byte| matches!(byte, b'0' | b'.'));
    if value < 0.0 && !is_zero { format!("\u{2212}{digits}") } else { digits }
}

/// `10⁻⁶` for -6.
pub(super) fn power_of_ten(exponent: i32) -> String {
    let raised = |character| match character {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32(u32::from('⁰') + u32::from(digit) - u32::from('0')).unwrap_or(digit),
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

/// The power of ten that is `value`'s first digit's place.
pub(super) fn exponent_of(value: f64) -> i32 {
    libm::floor(libm::log10(value)) as i32
}

/// Ten to that power.
pub(super) fn ten_to(exponent: i32) -> f64 {
    libm::pow(10.0, f64::from(exponent))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(min: f64, max: f64) -> (Vec<String>, i32) {
        let ticks = ticks(Range { min, max }, nice_step(max - min, 6.0));
        (ticks.marks.into_iter().map(|(_, label)| label).collect(), ticks.exponent)
    }

    #[test]
    fn ticks_step_by_one_two_or_five() {
        assert_eq!(labels(0.0, 10.0).0, ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(labels(-0.3, 0.3).0, ["−0.3", "−0.2", "−0.1", "0", "0.1", "0.2", "0.3"]);
        assert_eq!(labels(0.9, 9.1).0, ["2", "4", "6", "8"]);
        assert_eq!(labels(0.0, 260.0).0, ["0", "50", "100", "150", "200", "250"]);
    }

    #[test]
    fn large_and_small_numbers_share_one_power_of_ten() {
        assert_eq!(labels(0.0, 1e45), (["0", "0.2", "0.4", "0.6", "0.8", "1.0"].map(String::from).to_vec(), 45));
        assert_eq!(labels(0.0, 4e-5), (["0", "10", "20", "30", "40"].map(String::from).to_vec(), -6));
        assert_eq!(power_of_ten(-15) + &power_of_ten(240), "10⁻¹⁵10²⁴⁰");
    }

    #[test]
    fn every_range_has_width() {
        for values in [vec![0.0], vec![5.0, 5.0], vec![-1e45], vec![1e300, -1e300], vec![1e-310, 2e-310]] {
            let range = Range::of(values.iter().copied()).expect("finite");
            assert!(range.min < range.max, "{values:?} gave {range:?}");
            assert!((1..20).contains(&ticks(range, nice_step(range.span(), 6.0)).marks.len()), "{values:?}");
        }
        assert_eq!(Range::of([f64::NAN, f64::INFINITY, -1e301].into_iter()), None);
    }
}
