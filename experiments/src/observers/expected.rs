//! What the observers answer on average, in closed form: for planning a study without simulating it.
//!
//! Two looks at pictures whose visibilities are F₁ and F₂ differ by δ₁ − δ₂ with two units of variance, so their difference
//! in SDs of the comparison is normal around (δ₁ − δ₂)/√2. With δ from ½ + ½F = Φ(δ/√2), an unbiased observer without
//! lapses is right with exactly ½ + ½F in a forced choice against the reference. Lapses add a random answer in a share 2λ
//! of the trials: (1 − 2λ)(½ + ½F) + λ = ½ + (½ − λ)F, which is the MAR model's ψ = γ + (1 − γ − λ)F at γ = ½.

use super::options::Options;
use crate::mar::standard_normal_cdf;
use statrs::function::erf::erf_inv;
use std::f64::consts::SQRT_2;

/// Visibility beyond which δ no longer grows: δ is 10 there.
const LARGEST_VISIBILITY: f64 = 1.0 - 1e-12;

/// δ: how far apart test and reference are, in SDs of one look, when the test's visibility is `visibility` (F, 0–1).
///
/// ½ + ½F = Φ(δ/√2) is F = erf(δ/2).
#[must_use]
pub fn delta_from_visibility(visibility: f64) -> f64 {
    2.0 * erf_inv(visibility.clamp(0.0, LARGEST_VISIBILITY))
}

/// F: the inverse of [`delta_from_visibility`].
#[must_use]
pub fn visibility_from_delta(delta: f64) -> f64 {
    2.0 * standard_normal_cdf(delta / SQRT_2) - 1.0
}

/// Shares of the three answers of a comparison between reference and test; they add up to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// The reference was called better.
    pub reference: f64,
    /// Both were called the same.
    pub same: f64,
    /// The test was called better.
    pub test: f64,
}

impl Options {
    /// The probability of naming the right one of reference and test in a forced choice, when the test's visibility is F
    /// and either comes first equally often.
    #[must_use]
    pub fn probability_correct(&self, visibility: f64) -> f64 {
        let d = delta_from_visibility(visibility) / SQRT_2;
        let attentive = 0.5 * (standard_normal_cdf(d + self.bias) + standard_normal_cdf(d - self.bias));
        (1.0 - 2.0 * self.lapse) * attentive + self.lapse
    }

    /// The shares of "reference better", "same" and "test better" when the test's visibility is F and either comes first
    /// equally often. A lapse takes any of the three.
    #[must_use]
    pub fn comparison_shares(&self, visibility: f64) -> Shares {
        self.shares_of_difference(delta_from_visibility(visibility))
    }

    /// The probability that the reference is called better; see [`Options::comparison_shares`].
    #[must_use]
    pub fn probability_reference_better(&self, visibility: f64) -> f64 {
        self.comparison_shares(visibility).reference
    }

    /// The shares of a ramp's answers, as (named rightly, called the same, named wrongly), when its two ends have these
    /// visibilities. A ramp's answer has no side, so that bias has no part in it.
    #[must_use]
    pub fn direction_shares(&self, coarse: f64, fine: f64) -> [f64; 3] {
        let difference = delta_from_visibility(coarse) - delta_from_visibility(fine);
        let shares = Self { bias: 0.0, ..*self }.shares_of_difference(difference);
        [shares.reference, shares.same, shares.test]
    }

    /// The visibility at which the reference is called better with this probability, if there is one: where a protocol's
    /// threshold really lies for this observer.
    #[must_use]
    pub fn visibility_at_reference_better(&self, probability: f64) -> Option<f64> {
        bisect(|f| self.probability_reference_better(f), probability)
    }

    fn shares_of_difference(&self, delta: f64) -> Shares {
        let d = delta / SQRT_2;
        let [mut reference, mut test] = [0.0, 0.0];
        for bias in [self.bias, -self.bias] {
            reference += 0.5 * standard_normal_cdf(d + bias - self.zone);
            test += 0.5 * standard_normal_cdf(-d - bias - self.zone);
        }
        let (attentive, random) = (1.0 - 2.0 * self.lapse, 2.0 * self.lapse / 3.0);
        let [reference, test] = [reference, test].map(|share| attentive * share + random);
        Shares { reference, same: 1.0 - reference - test, test }
    }
}

/// Where a function that rises over 0–1 reaches `goal`; nothing if it does not.
fn bisect(f: impl Fn(f64) -> f64, goal: f64) -> Option<f64> {
    let (mut low, mut high) = (0.0, 1.0);
    if !(f(low)..=f(high)).contains(&goal) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if f(middle) < goal { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delta_and_visibility_are_each_others_inverse() {
        for f in [0.0, 1e-6, 0.1, 0.5, 0.9, 0.999_999] {
            assert!((visibility_from_delta(delta_from_visibility(f)) - f).abs() < 1e-9, "{f}");
            // The definition: ½ + ½F = Φ(δ/√2).
            let phi = standard_normal_cdf(delta_from_visibility(f) / SQRT_2);
            assert!((phi - (0.5 + 0.5 * f)).abs() < 1e-9, "{f}");
        }
        assert!(delta_from_visibility(1.0).is_finite() && delta_from_visibility(1.0) > 9.0);
        assert!((delta_from_visibility(0.5) - crate::observers::options::DEFAULT_CRITERION).abs() < 1e-9);
    }

    #[test]
    fn a_forced_choice_without_bias_is_the_mar_models_psi() {
        for (f, lapse) in [(0.0, 0.0), (0.3, 0.02), (0.5, 0.1), (1.0, 0.05)] {
            let options = Options { lapse, ..Options::default() };
            assert!((options.probability_correct(f) - (0.5 + (0.5 - lapse) * f)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_zone_of_zero_is_a_forced_choice_and_the_default_zone_halves_equal_pictures() {
        let forced = Options { zone: 0.0, lapse: 0.0, bias: 0.4, ..Options::default() };
        for f in [0.0, 0.2, 0.7] {
            assert!((forced.probability_reference_better(f) - forced.probability_correct(f)).abs() < 1e-12);
        }
        let shares = Options { lapse: 0.0, ..Options::default() }.comparison_shares(0.0);
        assert!((shares.same - 0.5).abs() < 1e-12 && (shares.reference - shares.test).abs() < 1e-12);
        // At F = ½ the mean lies on the zone's edge.
        let at_threshold = Options { lapse: 0.0, ..Options::default() }.probability_reference_better(0.5);
        assert!((at_threshold - 0.5).abs() < 1e-9);
        assert!(
            (Options { lapse: 0.0, ..Options::default() }.visibility_at_reference_better(0.5).expect("rises") - 0.5)
                .abs()
                < 1e-9
        );
        assert_eq!(Options::default().visibility_at_reference_better(0.01), None);
    }
}
