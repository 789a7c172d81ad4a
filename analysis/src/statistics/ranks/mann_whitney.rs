//! Mann and Whitney's (1947) test of two independent samples.

use super::{Method, doubled_ranks, exact_p, normal_p, tie_sum};
use crate::statistics::{Alternative, TestError, check_finite};
use serde::{Deserialize, Serialize};

/// Values of both samples up to which the exact distribution is offered.
const MOST_EXACT: usize = 100;

/// A Mann–Whitney test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MannWhitney {
    /// Values in each sample.
    pub n: [usize; 2],
    /// Pairs in which the first sample's value is the greater; ties count ½.
    pub u: f64,
    /// How p was found: [`Method::Exact`] or [`Method::Normal`].
    pub method: Method,
    /// What the p value is against.
    pub alternative: Alternative,
    /// The normal deviate; nothing for an exact p.
    pub z: Option<f64>,
    /// p value.
    pub p: f64,
    /// Share of pairs in which the first is greater, ties ½, 0–1.
    pub common_language: f64,
    /// Rank-biserial correlation, −1 to 1: twice that share less one.
    pub rank_biserial: f64,
}

/// Tests whether values of one sample tend to be greater than the other's.
///
/// # Errors
///
/// An empty sample, values that are not finite, all values the same, an exact p for more than 100 values.
pub fn mann_whitney(
    first: &[f64],
    second: &[f64],
    method: Method,
    alternative: Alternative,
) -> Result<MannWhitney, TestError> {
    for (what, values) in [("the first sample", first), ("the second sample", second)] {
        if values.is_empty() {
            return Err(TestError::TooFew { what, n: 0, least: 1 });
        }
        check_finite(what, values)?;
    }
    let all: Vec<f64> = first.iter().chain(second).copied().collect();
    if all.iter().all(|value| *value == all[0]) {
        return Err(TestError::NoVariance { what: "both samples" });
    }
    let ranks = doubled_ranks(&all);
    let doubled: usize = ranks[..first.len()].iter().map(|rank| *rank as usize).sum();
    let (n1, n2, n) = (first.len() as f64, second.len() as f64, all.len() as f64);
    let u = doubled as f64 / 2.0 - n1 * (n1 + 1.0) / 2.0;

    let method = method.settled(all.len());
    let (z, p) = if let Method::Normal { continuity } = method {
        let variance = n1 * n2 / 12.0 * (n + 1.0 - tie_sum(&ranks) / (n * (n - 1.0)));
        let half = if continuity { 0.5 } else { 0.0 };
        let (z, p) = normal_p(u, n1 * n2 / 2.0, variance.sqrt(), half, alternative);
        (Some(z), p)
    } else {
        if all.len() > MOST_EXACT {
            return Err(TestError::TooManyForExact { n: all.len(), most: MOST_EXACT });
        }
        (None, exact_p(&distribution(&ranks, first.len()), doubled, alternative))
    };
    let common_language = u / (n1 * n2);
    let rank_biserial = 2.0 * common_language - 1.0;
    Ok(MannWhitney { n: [first.len(), second.len()], u, method, alternative, z, p, common_language, rank_biserial })
}

/// How many choices of `chosen` of these ranks have each sum.
fn distribution(ranks: &[u32], chosen: usize) -> Vec<f64> {
    let all: usize = ranks.iter().map(|rank| *rank as usize).sum();
    let width = all + 1;
    let mut ways = vec![0.0; (chosen + 1) * width];
    ways[0] = 1.0;
    let mut reached = 0;
    for (seen, &rank) in ranks.iter().enumerate() {
        let rank = rank as usize;
        reached += rank;
        for count in (1..=chosen.min(seen + 1)).rev() {
            for sum in rank..=reached {
                ways[count * width + sum] += ways[(count - 1) * width + sum - rank];
            }
        }
    }
    ways.split_off(chosen * width)
}
