//! The normal distribution's tails to the last digits, and their logarithms beyond the smallest number.
//!
//! statrs 0.19's `erfc` is off by up to 8e-11 relative and jumps by as much between its pieces, which shows in an
//! integral that is wanted to 1e-12. These are the rational approximations of Cody (1969, Mathematics of Computation 23).

use super::Tails;
use crate::numerics::LN_SQRT_TAU;
use std::f64::consts::FRAC_1_SQRT_2;

/// erf(x) = x · P(x²)/Q(x²) for |x| ≤ 0.46875; highest powers first.
const NEAR: [[f64; 5]; 2] = [
    [
        1.857_777_061_846_031_5e-1,
        3.161_123_743_870_565_6,
        1.138_641_541_510_501_6e2,
        3.774_852_376_853_02e2,
        3.209_377_589_138_469_5e3,
    ],
    [1.0, 2.360_129_095_234_412e1, 2.440_246_379_344_441_7e2, 1.282_616_526_077_372_3e3, 2.844_236_833_439_171e3],
];

/// exp(x²) erfc(x) = P(x)/Q(x) for 0.46875 ≤ x ≤ 4; highest powers first.
const MIDDLE: [[f64; 9]; 2] = [
    [
        2.153_115_354_744_038_5e-8,
        5.641_884_969_886_7e-1,
        8.883_149_794_388_376,
        6.611_919_063_714_163e1,
        2.986_351_381_974_001e2,
        8.819_522_212_417_69e2,
        1.712_047_612_634_070_6e3,
        2.051_078_377_826_071_5e3,
        1.230_339_354_797_997_2e3,
    ],
    [
        1.0,
        1.574_492_611_070_983_5e1,
        1.176_939_508_913_125e2,
        5.371_811_018_620_099e2,
        1.621_389_574_566_690_2e3,
        3.290_799_235_733_46e3,
        4.362_619_090_143_247e3,
        3.439_367_674_143_721_6e3,
        1.230_339_354_803_749_4e3,
    ],
];

/// exp(x²) erfc(x) = (1/√π − P(1/x²)/(x² Q(1/x²)))/x beyond 4; highest powers first.
const FAR: [[f64; 6]; 2] = [
    [
        1.631_538_713_730_209_8e-2,
        3.053_266_349_612_323_4e-1,
        3.603_448_999_498_044_4e-1,
        1.257_817_261_112_292_5e-1,
        1.608_378_514_874_228e-2,
        6.587_491_615_298_378e-4,
    ],
    [
        1.0,
        2.568_520_192_289_822,
        1.872_952_849_923_460_4,
        5.279_051_029_514_284e-1,
        6.051_834_131_244_132e-2,
        2.335_204_976_268_691_8e-3,
    ],
];

fn ratio<const N: usize>(polynomials: &[[f64; N]; 2], x: f64) -> f64 {
    let [p, q] = polynomials.each_ref().map(|terms| terms.iter().fold(0.0, |sum, term| sum * x + term));
    p / q
}

/// exp(x²) erfc(x) for x ≥ 0.46875.
fn scaled_erfc(x: f64) -> f64 {
    if x <= 4.0 {
        return ratio(&MIDDLE, x);
    }
    let w = 1.0 / (x * x);
    (0.5 * std::f64::consts::FRAC_2_SQRT_PI - w * ratio(&FAR, w)) / x
}

/// P(Z ≤ z) and P(Z > z).
pub(in super::super) fn normal_tails(z: f64) -> Tails {
    let x = z.abs() * FRAC_1_SQRT_2;
    if x <= 0.468_75 {
        let half = 0.5 * z * FRAC_1_SQRT_2 * ratio(&NEAR, x * x);
        return Tails { lower: 0.5 + half, upper: 0.5 - half };
    }
    let upper = 0.5 * scaled_erfc(x) * (-0.5 * z * z).exp();
    let tails = Tails { lower: 1.0 - upper, upper };
    if z > 0.0 { tails } else { tails.swapped() }
}

/// ln P(Z ≤ z), finite even where the probability is not a number any more.
pub(super) fn ln_normal_cdf(z: f64) -> f64 {
    if z > -1.0 {
        return normal_tails(z).lower.ln();
    }
    (0.5 * scaled_erfc(-z * FRAC_1_SQRT_2)).ln() - 0.5 * z * z
}

/// The z that is exceeded with probability `upper`, 0 < `upper` < 1.
pub(in super::super) fn normal_quantile_above(upper: f64) -> f64 {
    let mut z = -crate::numerics::normal_quantile(upper);
    // The start is good to ten digits; Newton's method in the smaller tail doubles them.
    for _ in 0..2 {
        let tails = normal_tails(z);
        let density = (-0.5 * z * z - LN_SQRT_TAU).exp();
        let error = if upper < 0.5 { tails.upper - upper } else { (1.0 - upper) - tails.lower };
        z += error / density;
    }
    z
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ½ erfc(z/√2) by mpmath 1.4.1 with 40 digits.
    #[test]
    fn tails_are_exact_to_the_last_digits() {
        for (z, upper) in [
            (0.0, 0.5),
            (0.001, 0.499_601_057_786_088_93),
            (0.3, 0.382_088_577_811_047_4),
            (0.66, 0.254_626_914_671_336_14),
            (0.67, 0.251_428_895_095_310_1),
            (1.0, 0.158_655_253_931_457_05),
            (1.5, 0.066_807_201_268_858_07),
            (2.2, 0.013_903_447_513_498_604),
            (3.7, 0.000_107_799_733_477_388_26),
            (5.0, 2.866_515_718_791_939e-07),
            (5.65, 8.022_391_850_663_497e-09),
            (5.66, 7.568_649_751_997_714e-09),
            (8.0, 6.220_960_574_271_784e-16),
            (12.5, 3.732_564_298_877_713e-36),
            (20.0, 2.753_624_118_606_233_7e-89),
            (30.0, 4.906_713_927_148_187e-198),
            (37.0, 5.725_571_222_524_577e-300),
        ] {
            let (ours, mirrored) = (normal_tails(z), normal_tails(-z));
            assert!((ours.upper / upper - 1.0).abs() < 3e-16 * (4.0 + z * z), "{z}: {} against {upper}", ours.upper);
            assert_eq!(ours.upper, mirrored.lower);
            assert!((ln_normal_cdf(-z) - f64::ln(upper)).abs() < 1e-15 * (1.0 + z * z));
        }
        // ln Φ(−100) by mpmath.
        assert!((ln_normal_cdf(-100.0) / -5_005.524_208_694_205 - 1.0).abs() < 1e-15);
    }

    #[test]
    fn quantiles_invert_both_tails() {
        for upper in [1e-300, 1e-20, 1e-3, 0.025, 0.3, 0.5, 0.7, 0.975, 1.0 - 1e-12] {
            let tails = normal_tails(normal_quantile_above(upper));
            let error = if upper < 0.5 { tails.upper / upper - 1.0 } else { tails.lower / (1.0 - upper) - 1.0 };
            assert!(error.abs() < 1e-12, "{upper}: {tails:?}");
        }
        assert!((normal_quantile_above(0.025) - 1.959_963_984_540_054).abs() < 1e-15);
    }
}
