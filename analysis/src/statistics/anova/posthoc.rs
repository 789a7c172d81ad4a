//! Which levels of a factor differ: all pairs, by paired t tests on each subject's means over the other factors.

use super::{AnovaError, Table};
use crate::statistics::multiple::{Adjustment, adjust};
use crate::statistics::t_tests::{TTest, paired};
use crate::statistics::{Alternative, TestError, check_confidence};
use serde::{Deserialize, Serialize};

/// Two levels of a factor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// The level that the difference is taken from.
    pub first: String,
    /// The level that is subtracted.
    pub second: String,
    /// Its two-sided test, raw p; nothing where all subjects show exactly the same difference.
    pub test: Option<TTest>,
    /// p adjusted for all pairs.
    pub p_adjusted: Option<f64>,
}

/// All pairs of a factor's levels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pairwise {
    /// The factor.
    pub factor: String,
    /// How p was adjusted; the family is all pairs, with those that have no test counted as p = 1.
    pub adjustment: Adjustment,
    /// First with second, first with third …, second with third …
    pub comparisons: Vec<Comparison>,
}

/// Compares all levels of `factor` two by two.
///
/// # Errors
///
/// An unknown factor, a confidence outside (0, 1), differences too large to be squared.
pub fn pairwise(table: &Table, factor: &str, adjustment: Adjustment, confidence: f64) -> Result<Pairwise, AnovaError> {
    check_confidence(confidence)?;
    let margins = table.margins(factor)?;
    let names = table.factors().iter().find(|known| known.name == factor).map_or(&[][..], |known| &known.levels[..]);
    let mut comparisons = Vec::new();
    for (i, first) in names.iter().enumerate() {
        for (j, second) in names.iter().enumerate().skip(i + 1) {
            let test = match paired(&margins[i], &margins[j], Alternative::TwoSided, confidence) {
                Err(TestError::NoVariance { .. }) => None,
                other => Some(other?),
            };
            comparisons.push(Comparison { first: first.clone(), second: second.clone(), test, p_adjusted: None });
        }
    }
    let raw: Vec<f64> =
        comparisons.iter().map(|comparison| comparison.test.as_ref().map_or(1.0, |test| test.p)).collect();
    for (comparison, p) in comparisons.iter_mut().zip(adjust(&raw, adjustment)?) {
        comparison.p_adjusted = comparison.test.is_some().then_some(p);
    }
    Ok(Pairwise { factor: factor.to_owned(), adjustment, comparisons })
}
