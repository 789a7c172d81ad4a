//! Friedman's (1937) test of several conditions seen by the same subjects.

use super::{doubled_ranks, tie_sum};
use crate::statistics::distributions::{chi_square, f_tails};
use crate::statistics::{TestError, check_finite};
use serde::{Deserialize, Serialize};

/// A Friedman test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Friedman {
    /// Subjects.
    pub n: usize,
    /// Conditions.
    pub conditions: usize,
    /// Mean rank of every condition, 1 to `conditions`.
    pub mean_ranks: Vec<f64>,
    /// Friedman's statistic, corrected for ties.
    pub chi_square: f64,
    /// `conditions` − 1.
    pub df: usize,
    /// p by χ².
    pub p: f64,
    /// Kendall's coefficient of concordance W, 0–1: χ² / (n df).
    pub kendall_w: f64,
    /// The F approximation of Iman and Davenport (1980), which keeps its level better with few subjects; nothing where
    /// all subjects agree entirely.
    pub iman_davenport: Option<ImanDavenport>,
}

/// The F approximation of a Friedman test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ImanDavenport {
    /// (n − 1) χ² / (n df − χ²).
    pub f: f64,
    /// Degrees of freedom: df and (n − 1) df.
    pub df: [usize; 2],
    /// p value.
    pub p: f64,
}

/// Tests whether some condition is ranked higher than others; `rows[subject][condition]`.
///
/// # Errors
///
/// Fewer than two subjects or conditions, rows of different length, values that are not finite, rows none of which varies.
pub fn friedman(rows: &[Vec<f64>]) -> Result<Friedman, TestError> {
    let n = rows.len();
    if n < 2 {
        return Err(TestError::TooFew { what: "the subjects", n, least: 2 });
    }
    let k = rows[0].len();
    if k < 2 {
        return Err(TestError::TooFew { what: "the conditions", n: k, least: 2 });
    }
    let (mut sums, mut ties) = (vec![0u64; k], 0.0);
    for (row, values) in rows.iter().enumerate() {
        if values.len() != k {
            return Err(TestError::Ragged { row, expected: k, found: values.len() });
        }
        check_finite("a subject's conditions", values)?;
        let ranks = doubled_ranks(values);
        ties += tie_sum(&ranks);
        sums.iter_mut().zip(&ranks).for_each(|(sum, rank)| *sum += u64::from(*rank));
    }
    let (subjects, conditions) = (n as f64, k as f64);
    // 1 − Σ(t³ − t)/(n k (k² − 1)): the share of the ranks' variance that ties leave.
    let left = 1.0 - ties / (subjects * conditions * (conditions * conditions - 1.0));
    if left <= 0.0 {
        return Err(TestError::NoVariance { what: "the conditions, within every subject," });
    }
    let mean = subjects * (conditions + 1.0) / 2.0;
    let squares: f64 = sums.iter().map(|sum| (*sum as f64 / 2.0 - mean).powi(2)).sum();
    let chi = 12.0 * squares / (subjects * conditions * (conditions + 1.0)) / left;
    let df = k - 1;
    let most = subjects * df as f64;
    let chi = chi.min(most);
    let iman_davenport = (most - chi > 1e-9 * most).then(|| {
        let f = (subjects - 1.0) * chi / (most - chi);
        ImanDavenport { f, df: [df, (n - 1) * df], p: f_tails(f, df as f64, ((n - 1) * df) as f64).upper }
    });
    Ok(Friedman {
        n,
        conditions: k,
        mean_ranks: sums.iter().map(|sum| *sum as f64 / 2.0 / subjects).collect(),
        chi_square: chi,
        df,
        p: chi_square(chi, df as f64).map_or(1.0, |tails| tails.upper),
        kendall_w: chi / most,
        iman_davenport,
    })
}
