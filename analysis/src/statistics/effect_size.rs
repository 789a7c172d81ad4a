//! Standardised mean differences with intervals from the noncentral t distribution.
//!
//! What the difference is divided by makes a different number of it, so that each names its divisor. The interval of a
//! difference over its own standard deviation is exact under the test's model; where the divisor is another, it is the
//! same interval carried over by the ratio of the divisors, which is approximate and says so.

use super::distributions::{hedges_factor, noncentrality_limits_of_t};
use serde::{Deserialize, Serialize};

/// What a mean difference is divided by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Standardizer {
    /// d_z: the standard deviation of the differences (or of the one sample). Exact interval.
    Differences,
    /// d_av: the root mean square of both standard deviations (Cumming 2012, ch. 11; Bonett 2008). Approximate interval
    /// (Algina & Keselman 2003, Educational and Psychological Measurement 63, for pairs).
    Average,
    /// d_s: the pooled standard deviation of two independent samples. Exact interval if their variances are equal.
    Pooled,
}

/// A standardised mean difference.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EffectSize {
    /// What it is divided by.
    pub standardizer: Standardizer,
    /// Cohen's d.
    pub d: f64,
    /// Interval of d's population value at the test's confidence.
    pub ci: [f64; 2],
    /// Hedges' g: d without its bias, by the exact factor (Hedges 1981, eq. 6e); nothing where the factor is not defined
    /// (one degree of freedom).
    pub g: Option<f64>,
    /// d's interval times the same factor.
    pub g_ci: Option<[f64; 2]>,
}

impl EffectSize {
    /// From a t with `df` degrees of freedom: d = t · `d_per_t`. `factor_df` are those of the divisor's variance.
    pub(super) fn new(
        standardizer: Standardizer,
        t: f64,
        df: f64,
        d_per_t: f64,
        factor_df: f64,
        confidence: f64,
    ) -> Option<Self> {
        let limits = noncentrality_limits_of_t(t, df, confidence)?;
        Some(Self::scaled(standardizer, t * d_per_t, limits.map(|delta| delta * d_per_t), factor_df))
    }

    /// The same difference over another standard deviation, `ratio` times smaller.
    pub(super) fn over(&self, standardizer: Standardizer, ratio: f64, factor_df: f64) -> Self {
        Self::scaled(standardizer, self.d * ratio, self.ci.map(|end| end * ratio), factor_df)
    }

    fn scaled(standardizer: Standardizer, d: f64, ci: [f64; 2], factor_df: f64) -> Self {
        let factor = (factor_df > 1.0).then(|| hedges_factor(factor_df));
        Self { standardizer, d, ci, g: factor.map(|j| j * d), g_ci: factor.map(|j| ci.map(|end| j * end)) }
    }
}
