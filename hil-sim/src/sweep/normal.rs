//! The quantiles of the normal distribution.

/// Below which a standard normal variable lies with this probability, between
/// 0 and 1: a rational approximation after P. J. Acklam, good to 1e-9, and one
/// step of Halley's method on top of it, which leaves rounding.
pub fn quantile(probability: f64) -> f64 {
    let probability = probability.clamp(f64::MIN_POSITIVE, 1.0 - f64::EPSILON);
    let x = approximate(probability);
    let error = 0.5 * libm::erfc(-x / std::f64::consts::SQRT_2) - probability;
    let step = error * (2.0 * std::f64::consts::PI).sqrt() * libm::exp(x * x / 2.0);
    let better = x - step / (1.0 + x * step / 2.0);
    if better.is_finite() { better } else { x }
}

/// Where the tails begin.
const TAIL: f64 = 0.024_25;

const A: [f64; 6] = [
    -3.969_683_028_665_376e1,
    2.209_460_984_245_205e2,
    -2.759_285_104_469_687e2,
    1.383_577_518_672_69e2,
    -3.066_479_806_614_716e1,
    2.506_628_277_459_239,
];
const B: [f64; 6] = [
    -5.447_609_879_822_406e1,
    1.615_858_368_580_409e2,
    -1.556_989_798_598_866e2,
    6.680_131_188_771_972e1,
    -1.328_068_155_288_572e1,
    1.0,
];
const C: [f64; 6] = [
    -7.784_894_002_430_293e-3,
    -3.223_964_580_411_365e-1,
    -2.400_758_277_161_838,
    -2.549_732_539_343_734,
    4.374_664_141_464_968,
    2.938_163_982_698_783,
];
const D: [f64; 5] =
    [7.784_695_709_041_462e-3, 3.224_671_290_700_398e-1, 2.445_134_137_142_996, 3.754_408_661_907_416, 1.0];

fn approximate(probability: f64) -> f64 {
    if probability < TAIL {
        tail(probability)
    } else if probability > 1.0 - TAIL {
        -tail(1.0 - probability)
    } else {
        let q = probability - 0.5;
        q * polynomial(&A, q * q) / polynomial(&B, q * q)
    }
}

fn tail(probability: f64) -> f64 {
    let q = (-2.0 * libm::log(probability)).sqrt();
    polynomial(&C, q) / polynomial(&D, q)
}

/// Highest power first.
fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_tables() {
        for (probability, expected) in [
            (0.5, 0.0),
            (0.975, 1.959_963_984_540_054),
            (0.841_344_746_068_542_9, 1.0),
            (0.001, -3.090_232_306_167_813_5),
            (1e-9, -5.997_807_015_007_687),
        ] {
            assert!((quantile(probability) - expected).abs() < 1e-9, "{probability}: {}", quantile(probability));
        }
    }

    #[test]
    fn the_distribution_leads_back_to_the_probability() {
        for nth in 1..1000 {
            let probability = f64::from(nth) / 1000.0;
            let back = 0.5 * libm::erfc(-quantile(probability) / std::f64::consts::SQRT_2);
            assert!((back - probability).abs() < 1e-14, "{probability}");
        }
        assert!(quantile(0.0).is_finite() && quantile(1.0).is_finite());
    }
}
