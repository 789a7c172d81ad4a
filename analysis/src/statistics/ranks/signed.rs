//! Wilcoxon's (1945) signed-rank test of pairs.

use super::{Method, doubled_ranks, exact_p, normal_p, tie_sum};
use crate::statistics::{Alternative, TestError, check_finite};
use serde::{Deserialize, Serialize};

/// Values up to which the exact distribution is offered.
const MOST_EXACT: usize = 1000;

/// What is done with differences of zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Zeros {
    /// They are left out before ranking (Wilcoxon 1945).
    #[default]
    Wilcoxon,
    /// They are ranked, and then left out (Pratt 1959).
    Pratt,
}

/// A signed-rank test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SignedRank {
    /// Pairs.
    pub n: usize,
    /// Differences of zero among them.
    pub zeros: usize,
    /// What was done with those.
    pub zero_method: Zeros,
    /// Sum of the ranks of positive differences.
    pub w_plus: f64,
    /// Sum of the ranks of negative differences.
    pub w_minus: f64,
    /// How p was found: [`Method::Exact`] or [`Method::Normal`].
    pub method: Method,
    /// What the p value is against.
    pub alternative: Alternative,
    /// The normal deviate; nothing for an exact p.
    pub z: Option<f64>,
    /// p value.
    pub p: f64,
    /// Matched-pairs rank-biserial correlation (Kerby 2014): (W₊ − W₋)/(W₊ + W₋), −1 to 1.
    pub rank_biserial: f64,
}

/// Tests whether `first[i] − second[i]` is symmetric around zero.
///
/// # Errors
///
/// Samples of different length, values that are not finite, no difference other than zero, an exact p for more than
/// 1000 pairs.
///
/// ```
/// use analysis::statistics::{Alternative, ranks::{Method, Zeros, wilcoxon}};
/// let (before, after) = ([7.0, 5.0, 6.0, 9.0, 8.0], [4.0, 3.0, 5.0, 5.0, 3.0]);
/// let test = wilcoxon(&before, &after, Zeros::Wilcoxon, Method::Auto, Alternative::TwoSided)?;
/// assert_eq!((test.w_plus, test.p, test.rank_biserial), (15.0, 2.0 / 32.0, 1.0));
/// # Ok::<(), analysis::statistics::TestError>(())
/// ```
pub fn wilcoxon(
    first: &[f64],
    second: &[f64],
    zero_method: Zeros,
    method: Method,
    alternative: Alternative,
) -> Result<SignedRank, TestError> {
    if first.len() != second.len() {
        return Err(TestError::UnequalLengths { first: first.len(), second: second.len() });
    }
    check_finite("the first sample", first)?;
    check_finite("the second sample", second)?;
    let mut differences: Vec<f64> = first.iter().zip(second).map(|(a, b)| a - b).collect();
    check_finite("the differences", &differences)?;
    let zeros = differences.iter().filter(|difference| **difference == 0.0).count();
    if zeros == differences.len() {
        return Err(TestError::NoVariance { what: "the differences" });
    }
    if zero_method == Zeros::Wilcoxon {
        differences.retain(|difference| *difference != 0.0);
    }
    let sizes: Vec<f64> = differences.iter().map(|difference| difference.abs()).collect();
    // Doubled ranks of the differences that are not zero, with their signs.
    let signed: Vec<(u32, bool)> = doubled_ranks(&sizes)
        .into_iter()
        .zip(&differences)
        .filter(|(_, difference)| **difference != 0.0)
        .map(|(rank, difference)| (rank, *difference > 0.0))
        .collect();
    let doubled_plus: usize = signed.iter().filter(|(_, positive)| *positive).map(|(rank, _)| *rank as usize).sum();
    let doubled_all: usize = signed.iter().map(|(rank, _)| *rank as usize).sum();
    let (w_plus, w_minus) = (doubled_plus as f64 / 2.0, (doubled_all - doubled_plus) as f64 / 2.0);

    let ranks: Vec<u32> = signed.iter().map(|(rank, _)| *rank).collect();
    let method = method.settled(ranks.len());
    let (z, p) = if let Method::Normal { continuity } = method {
        // n(n + 1)(2n + 1)/24 − Σ(t³ − t)/48 for ranks 1 … n; for Pratt's, less what the zeros had.
        let cubic = |n: f64| n * (n + 1.0) * (2.0 * n + 1.0) / 24.0;
        let all = differences.len() as f64;
        let untouched = if zero_method == Zeros::Pratt { cubic(zeros as f64) } else { 0.0 };
        let variance = cubic(all) - untouched - tie_sum(&ranks) / 48.0;
        let half = if continuity { 0.5 } else { 0.0 };
        let (z, p) = normal_p(w_plus, doubled_all as f64 / 4.0, variance.sqrt(), half, alternative);
        (Some(z), p)
    } else {
        if ranks.len() > MOST_EXACT {
            return Err(TestError::TooManyForExact { n: ranks.len(), most: MOST_EXACT });
        }
        (None, exact_p(&distribution(&ranks, doubled_all), doubled_plus, alternative))
    };
    Ok(SignedRank {
        n: first.len(),
        zeros,
        zero_method,
        w_plus,
        w_minus,
        method,
        alternative,
        z,
        p,
        rank_biserial: (w_plus - w_minus) / (w_plus + w_minus),
    })
}

/// Probability of every sum of ranks whose signs are tossed.
fn distribution(ranks: &[u32], all: usize) -> Vec<f64> {
    let mut weights = vec![0.0; all + 1];
    weights[0] = 1.0;
    let mut reached = 0;
    for &rank in ranks {
        let rank = rank as usize;
        reached += rank;
        for sum in (0..=reached).rev() {
            let with = if sum >= rank { weights[sum - rank] } else { 0.0 };
            weights[sum] = 0.5 * (weights[sum] + with);
        }
    }
    weights
}
