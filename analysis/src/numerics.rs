//! Small numerical helpers that several modules share: the normal distribution in both tails, quantiles, moments.
//!
//! Nothing here knows about eyes or displays.

use statrs::function::erf::{erfc, erfc_inv};
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// ln √(2π).
pub(crate) const LN_SQRT_TAU: f64 = 0.918_938_533_204_672_8;

/// Φ(t) and 1 − Φ(t), each to a relative 1e-10 in its own tail; [`crate::statistics`] has the normal distribution to full
/// precision.
pub(crate) fn normal_cdf_pair(t: f64) -> (f64, f64) {
    let tail = 0.5 * erfc(t.abs() * FRAC_1_SQRT_2);
    if t >= 0.0 { (1.0 - tail, tail) } else { (tail, 1.0 - tail) }
}

/// φ(t), the standard normal density.
pub(crate) fn normal_pdf(t: f64) -> f64 {
    (-0.5 * t * t - LN_SQRT_TAU).exp()
}

/// Φ⁻¹(p) for p strictly between 0 and 1.
pub(crate) fn normal_quantile(p: f64) -> f64 {
    -SQRT_2 * erfc_inv(2.0 * p)
}

/// ln(exp(a) + exp(b)) without overflow.
pub(crate) fn ln_add_exp(a: f64, b: f64) -> f64 {
    let (high, low) = if a >= b { (a, b) } else { (b, a) };
    if low == f64::NEG_INFINITY { high } else { high + (low - high).exp().ln_1p() }
}

/// ln Σ exp(xᵢ); −∞ for no terms.
pub(crate) fn ln_sum_exp(values: &[f64]) -> f64 {
    let top = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if top == f64::NEG_INFINITY {
        return top;
    }
    top + values.iter().map(|v| (v - top).exp()).sum::<f64>().ln()
}

/// The `q` quantile (0–1) of sorted values, linear between order statistics (Hyndman and Fan's type 7).
///
/// `None` for no values.
pub(crate) fn quantile_of_sorted(sorted: &[f64], q: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let position = q.clamp(0.0, 1.0) * last as f64;
    let below = position.floor() as usize;
    let above = (below + 1).min(last);
    let share = position - below as f64;
    Some(sorted[below] + (sorted[above] - sorted[below]) * share)
}

/// The finite values, sorted ascending.
pub(crate) fn sorted_finite(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// Quantiles at each of `probabilities` of values with weights that sum to one.
///
/// The cumulative weight is read at the middle of each value's own share and interpolated linearly between values.
pub(crate) fn weighted_quantiles<const N: usize>(values: &[f64], weights: &[f64], probabilities: [f64; N]) -> [f64; N] {
    let mut order: Vec<u32> = (0..values.len() as u32).collect();
    order.sort_unstable_by(|&a, &b| values[a as usize].total_cmp(&values[b as usize]));
    let mut result = [f64::NAN; N];
    let mut next = 0;
    let mut before = 0.0;
    let mut previous: Option<(f64, f64)> = None;
    for &index in &order {
        let (value, weight) = (values[index as usize], weights[index as usize]);
        let middle = before + 0.5 * weight;
        before += weight;
        while next < N && probabilities[next] <= middle {
            result[next] = match previous {
                Some((v, c)) if middle > c => v + (value - v) * (probabilities[next] - c) / (middle - c),
                _ => value,
            };
            next += 1;
        }
        previous = Some((value, middle));
    }
    if let Some((value, _)) = previous {
        result[next..].fill(value);
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_normal_tails_keep_their_precision() {
        // Closed forms from Abramowitz and Stegun, table 26.1: Q(5) = 2.8665157e-7.
        let (lower, upper) = normal_cdf_pair(5.0);
        assert!((upper / 2.866_515_718_791_939e-7 - 1.0).abs() < 1e-9);
        assert!((lower + upper - 1.0).abs() < 1e-15);
        assert!((normal_cdf_pair(-5.0).0 / upper - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_normal_quantile_inverts_the_cdf() {
        for p in [1e-9, 1e-4, 0.025, 0.3, 0.5, 0.9, 0.975, 1.0 - 1e-6] {
            assert!((normal_cdf_pair(normal_quantile(p)).0 / p - 1.0).abs() < 1e-9, "p = {p}");
        }
    }

    #[test]
    fn weighted_quantiles_of_equal_weights_are_plain_ones() {
        let values: Vec<f64> = (0..1001).map(|i| f64::from((i * 37) % 1001)).collect();
        let weights = vec![1.0 / 1001.0; 1001];
        let [low, middle, high] = weighted_quantiles(&values, &weights, [0.025, 0.5, 0.975]);
        assert!((low - 25.0).abs() < 1.0 && (middle - 500.0).abs() < 1e-6 && (high - 975.0).abs() < 1.0);
    }

    #[test]
    fn sums_of_exponentials_do_not_overflow() {
        assert!((ln_add_exp(1000.0, 1000.0) - 1000.0 - 2f64.ln()).abs() < 1e-12);
        assert_eq!(ln_add_exp(f64::NEG_INFINITY, 3.0), 3.0);
        assert_eq!(ln_sum_exp(&[]), f64::NEG_INFINITY);
    }
}
