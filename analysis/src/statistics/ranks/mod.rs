//! Tests on ranks: Wilcoxon's signed ranks, Mann and Whitney's two samples, Friedman's rows.
//!
//! Exact distributions are those of the ranks as they are, ties and all (each sign, or each division into two groups, being
//! as probable as any other), so that ties alone are no reason for an approximation.

mod friedman;
mod mann_whitney;
mod signed;

pub use friedman::{Friedman, ImanDavenport, friedman};
pub use mann_whitney::{MannWhitney, mann_whitney};
pub use signed::{SignedRank, Zeros, wilcoxon};

use super::Alternative;
use super::distributions::normal_tails;
use serde::{Deserialize, Serialize};

/// How a p value is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Exact for up to 50 values, normal beyond.
    #[default]
    Auto,
    /// From the exact distribution.
    Exact,
    /// From the normal approximation, with correction for ties and, if `continuity`, by half a unit for continuity.
    Normal {
        /// Whether to correct for continuity.
        continuity: bool,
    },
}

impl Method {
    /// Values up to which [`Method::Auto`] is exact.
    const AUTO: usize = 50;

    fn settled(self, n: usize) -> Self {
        match self {
            Self::Auto if n <= Self::AUTO => Self::Exact,
            Self::Auto => Self::Normal { continuity: true },
            chosen => chosen,
        }
    }
}

/// Twice the rank of every value, ties sharing their mean: whole numbers.
fn doubled_ranks(values: &[f64]) -> Vec<u32> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0; values.len()];
    let mut start = 0;
    while start < order.len() {
        let mut end = start;
        while end < order.len() && values[order[end]] == values[order[start]] {
            end += 1;
        }
        // Ranks start + 1 … end.
        order[start..end].iter().for_each(|&at| ranks[at] = (start + 1 + end) as u32);
        start = end;
    }
    ranks
}

/// Σ (t³ − t) over groups of t tied ranks.
fn tie_sum(ranks: &[u32]) -> f64 {
    let mut sorted = ranks.to_vec();
    sorted.sort_unstable();
    sorted.chunk_by(|a, b| a == b).map(|group| (group.len() as f64).powi(3) - group.len() as f64).sum()
}

/// p of a statistic by the normal approximation; `half` is the correction for continuity, 0 for none.
fn normal_p(statistic: f64, mean: f64, sd: f64, half: f64, alternative: Alternative) -> (f64, f64) {
    let off = statistic - mean;
    let corrected = match alternative {
        Alternative::TwoSided => off.signum() * (off.abs() - half).max(0.0),
        Alternative::Greater => off - half,
        Alternative::Less => off + half,
    };
    let z = corrected / sd;
    let p = match alternative {
        Alternative::TwoSided => (2.0 * normal_tails(z.abs()).upper).min(1.0),
        Alternative::Greater => normal_tails(z).upper,
        Alternative::Less => normal_tails(z).lower,
    };
    (z, p)
}

/// p of a statistic by its exact distribution: `weights[s]` is that of the statistic `s`.
fn exact_p(weights: &[f64], statistic: usize, alternative: Alternative) -> f64 {
    let all: f64 = weights.iter().sum();
    let at_most = weights[..=statistic].iter().sum::<f64>() / all;
    let at_least = weights[statistic..].iter().sum::<f64>() / all;
    match alternative {
        Alternative::TwoSided => (2.0 * at_most.min(at_least)).min(1.0),
        Alternative::Greater => at_least,
        Alternative::Less => at_most,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ties_share_their_mean_rank() {
        assert_eq!(doubled_ranks(&[3.0, 1.0, 3.0, -2.0, 3.0]), [8, 4, 8, 2, 8]);
        assert_eq!(tie_sum(&[8, 4, 8, 2, 8]), 24.0);
        assert_eq!(doubled_ranks(&[0.0, -0.0]), [3, 3]);
    }
}
