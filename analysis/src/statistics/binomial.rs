//! Counts of successes: the exact test against a probability, and intervals of their share.
//!
//! One implementation for the whole crate; [`crate::shares`] puts its 95 % intervals beside every share it shows.

use super::distributions::{Tails, beta_quantile, binomial, ln_binomial_probability, normal_quantile_above};
use super::{Alternative, TestError, check_confidence};
use serde::{Deserialize, Serialize};

/// Two probabilities this close, relatively, count as the same when a two-sided test collects what is no more probable
/// than what was seen (R and scipy do so too).
const SAME: f64 = 1e-7;

/// An exact binomial test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BinomialTest {
    /// Successes.
    pub k: u64,
    /// Trials.
    pub n: u64,
    /// The probability that is tested, 0–1.
    pub null: f64,
    /// What the p value is against.
    pub alternative: Alternative,
    /// k/n.
    pub share: f64,
    /// p value.
    pub p: f64,
}

/// Tests `k` successes of `n` trials against the probability `null`.
///
/// Two-sided by the method of small p values: the probability of everything that is no more probable than `k`.
///
/// # Errors
///
/// No trials, `k` > `n`, `null` outside 0–1.
///
/// ```
/// use analysis::statistics::{Alternative, binomial::binomial_test};
/// let test = binomial_test(31, 40, 0.5, Alternative::TwoSided)?;
/// assert!((test.p - 0.000_679_548_3).abs() < 1e-10);
/// # Ok::<(), analysis::statistics::TestError>(())
/// ```
pub fn binomial_test(k: u64, n: u64, null: f64, alternative: Alternative) -> Result<BinomialTest, TestError> {
    check_counts(k, n)?;
    if !(0.0..=1.0).contains(&null) {
        return Err(TestError::Probability { what: "the tested probability".to_owned(), value: null });
    }
    // P(K ≤ k) and P(K ≥ k).
    let at_most = |k: u64| binomial(k, n, null).map_or(1.0, |tails| tails.lower);
    let at_least = |k: u64| if k == 0 { 1.0 } else { binomial(k - 1, n, null).map_or(1.0, |tails| tails.upper) };
    let p = match alternative {
        Alternative::Less => at_most(k),
        Alternative::Greater => at_least(k),
        Alternative::TwoSided => two_sided(k, n, null, at_most, at_least),
    };
    Ok(BinomialTest { k, n, null, alternative, share: k as f64 / n as f64, p })
}

fn two_sided(k: u64, n: u64, null: f64, at_most: impl Fn(u64) -> f64, at_least: impl Fn(u64) -> f64) -> f64 {
    let expected = n as f64 * null;
    if k as f64 == expected {
        return 1.0;
    }
    if null == 0.0 || null == 1.0 {
        // Anything but the only possible count.
        return 0.0;
    }
    let ln_limit = ln_binomial_probability(k, n, null) + SAME.ln_1p();
    let counts = |other: u64| ln_binomial_probability(other, n, null) <= ln_limit;
    // Probabilities fall away from the expected count on either side, so that the other tail's edge can be bisected.
    let p = if (k as f64) < expected {
        let edge = first(expected.ceil() as u64, n + 1, counts);
        at_most(k) + if edge > n { 0.0 } else { at_least(edge) }
    } else {
        let last = expected.floor() as u64;
        // Counted from the far end: how many of 0 … last belong.
        let belong = first(0, last + 1, |other| !counts(other));
        at_least(k) + if belong == 0 { 0.0 } else { at_most(belong - 1) }
    };
    p.min(1.0)
}

/// The first of `from..to` at which a condition that stays true once it is so holds; `to` if none.
fn first(from: u64, to: u64, holds: impl Fn(u64) -> bool) -> u64 {
    let (mut from, mut to) = (from, to);
    while from < to {
        let middle = from + (to - from) / 2;
        if holds(middle) { to = middle } else { from = middle + 1 }
    }
    from
}

/// The interval of Wilson (1927) for a share, without correction for continuity; `confidence` between 0 and 1.
///
/// # Errors
///
/// No trials, `k` > `n`, a confidence outside (0, 1).
pub fn wilson(k: u64, n: u64, confidence: f64) -> Result<[f64; 2], TestError> {
    check_counts(k, n)?;
    check_confidence(confidence)?;
    let (share, trials, z) = (k as f64 / n as f64, n as f64, normal_quantile_above(0.5 * (1.0 - confidence)));
    let z2 = z * z;
    let centre = (share + z2 / (2.0 * trials)) / (1.0 + z2 / trials);
    let half = z / (1.0 + z2 / trials) * (share * (1.0 - share) / trials + z2 / (4.0 * trials * trials)).sqrt();
    // None and all end at the ends exactly; rounding would leave them a hair inside.
    Ok([if k == 0 { 0.0 } else { (centre - half).max(0.0) }, if k == n { 1.0 } else { (centre + half).min(1.0) }])
}

/// The interval of Clopper and Pearson (1934), which never covers less than it says; `confidence` between 0 and 1.
///
/// # Errors
///
/// No trials, `k` > `n`, a confidence outside (0, 1).
///
/// ```
/// use analysis::statistics::binomial::clopper_pearson;
/// let [low, high] = clopper_pearson(0, 10, 0.9)?;
/// assert!(low == 0.0 && (high - (1.0 - 0.05f64.powf(0.1))).abs() < 1e-15);
/// # Ok::<(), analysis::statistics::TestError>(())
/// ```
pub fn clopper_pearson(k: u64, n: u64, confidence: f64) -> Result<[f64; 2], TestError> {
    check_counts(k, n)?;
    check_confidence(confidence)?;
    let outside = 0.5 * (1.0 - confidence);
    let (k, n) = (k as f64, n as f64);
    let below = Tails { lower: outside, upper: 1.0 - outside };
    let above = Tails { lower: 1.0 - outside, upper: outside };
    Ok([
        if k > 0.0 { beta_quantile(k, n - k + 1.0, below).0 } else { 0.0 },
        if k < n { beta_quantile(k + 1.0, n - k, above).0 } else { 1.0 },
    ])
}

fn check_counts(k: u64, n: u64) -> Result<(), TestError> {
    if n == 0 {
        return Err(TestError::NoTrials);
    }
    if k > n {
        return Err(TestError::MoreThanAll { k, n });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What the definition says, term by term.
    fn by_terms(k: u64, n: u64, null: f64) -> f64 {
        let seen = ln_binomial_probability(k, n, null);
        let terms = (0..=n).map(|other| ln_binomial_probability(other, n, null));
        terms.filter(|ln| *ln <= seen + 1e-7).map(f64::exp).sum::<f64>().min(1.0)
    }

    #[test]
    fn bad_counts_and_probabilities_are_named() {
        let test = |k, n, p| binomial_test(k, n, p, Alternative::TwoSided).unwrap_err().to_string();
        assert!(test(3, 2, 0.5).starts_with("3 of 2"));
        assert!(test(0, 0, 0.5).starts_with("no trials"));
        assert!(test(1, 2, f64::NAN).contains("tested probability"));
        assert!(wilson(1, 2, 1.0).unwrap_err().to_string().contains("confidence"));
        assert!(clopper_pearson(1, 2, 0.0).is_err());
    }

    #[test]
    fn certain_nulls_allow_one_count() {
        for (k, null, p) in [(0, 0.0, 1.0), (1, 0.0, 0.0), (5, 1.0, 1.0), (4, 1.0, 0.0)] {
            assert_eq!(binomial_test(k, 5, null, Alternative::TwoSided).unwrap().p, p);
        }
        assert_eq!(binomial_test(1, 5, 0.0, Alternative::Greater).unwrap().p, 0.0);
        assert_eq!(binomial_test(4, 5, 1.0, Alternative::Less).unwrap().p, 0.0);
    }

    #[test]
    fn symmetric_outcomes_are_mirrored() {
        // Without the tolerance, rounding decides whether the mirrored count belongs.
        for n in [10u64, 41, 1000] {
            for k in 0..n / 2 {
                let [low, high] = [k, n - k].map(|k| binomial_test(k, n, 0.5, Alternative::TwoSided).unwrap().p);
                let double = 2.0 * binomial_test(k, n, 0.5, Alternative::Less).unwrap().p;
                assert!((low / high - 1.0).abs() < 1e-11, "{k} of {n}: {low} {high}");
                assert!((low / double.min(1.0) - 1.0).abs() < 1e-11, "{k} of {n}: {low} {double}");
            }
        }
    }

    proptest! {
        #[test]
        fn two_sided_is_the_sum_of_what_is_no_more_probable(n in 1u64..120, share in 0.0..=1.0f64, null in 0.001..0.999f64) {
            let k = (share * n as f64).round() as u64;
            let (ours, terms) = (binomial_test(k, n, null, Alternative::TwoSided).unwrap().p, by_terms(k, n, null));
            prop_assert!((ours / terms - 1.0).abs() < 1e-6, "{} of {} at {}: {} {}", k, n, null, ours, terms);
        }

        #[test]
        fn intervals_hold_the_share_and_grow_with_confidence(n in 1u64..100_000, share in 0.0..=1.0f64) {
            let k = (share * n as f64).round() as u64;
            let seen = k as f64 / n as f64;
            for interval in [wilson, clopper_pearson] {
                let [narrow, wide] = [0.5, 0.999].map(|confidence| interval(k, n, confidence).unwrap());
                prop_assert!(0.0 <= wide[0] && wide[0] <= narrow[0] && narrow[0] <= seen + 1e-12);
                prop_assert!(seen <= narrow[1] + 1e-12 && narrow[1] <= wide[1] && wide[1] <= 1.0);
            }
        }
    }
}
