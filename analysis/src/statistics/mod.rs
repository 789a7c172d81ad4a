//! Tests of hypotheses as a reviewer would redo them: analysis of variance for repeated measures, t and rank tests, exact
//! binomial tests, corrections for many tests, each with its effect size and interval.
//!
//! Every function takes plain numbers and answers with a result that holds what it was computed from, or with one error
//! that names what is wrong and where; no answer holds a NaN. What the numbers of a study mean is said elsewhere
//! ([`crate::answers`], [`crate::mar`]); models with random effects are not here.
//!
//! - [`anova`]: any number of within-subject factors, with sphericity and post-hoc comparisons;
//! - [`t_tests`]: one sample, paired, Welch, with standardised differences ([`effect_size`]);
//! - [`ranks`]: Wilcoxon, Mann–Whitney, Friedman;
//! - [`binomial`]: exact test, Clopper–Pearson and Wilson intervals;
//! - [`multiple`]: Bonferroni, Holm, Benjamini–Hochberg;
//! - [`distributions`]: the tail probabilities under all of them.

pub mod anova;
pub mod binomial;
pub mod distributions;
pub mod effect_size;
pub mod multiple;
pub mod ranks;
pub mod t_tests;

use serde::{Deserialize, Serialize};

/// What is held against the hypothesis of no difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Alternative {
    /// A difference either way.
    #[default]
    TwoSided,
    /// The first is greater than the second, or than the value it is held against.
    Greater,
    /// The first is less.
    Less,
}

/// Why a test cannot be done on these numbers.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TestError {
    /// A sample is too short for its variance, or for a rank.
    #[error("{what}: {n} values, but at least {least} are needed")]
    TooFew {
        /// Which sample.
        what: &'static str,
        /// Values there are.
        n: usize,
        /// Values there must be.
        least: usize,
    },
    /// A value is infinite or not a number.
    #[error("{what}: value {} is {value}, which is not a finite number", index + 1)]
    NotFinite {
        /// Which sample.
        what: &'static str,
        /// Where in it, from 0.
        index: usize,
        /// The value.
        value: f64,
    },
    /// Pairs need as many values on either side.
    #[error("paired samples have {first} and {second} values; they must be as many")]
    UnequalLengths {
        /// Values of the first sample.
        first: usize,
        /// Values of the second sample.
        second: usize,
    },
    /// All values are the same, so that there is nothing to measure a difference against.
    #[error("{what} do not vary: there is no error to hold a difference against")]
    NoVariance {
        /// Of what.
        what: &'static str,
    },
    /// Squares that are beyond any number.
    #[error("{what} are too large to be squared; give them in a larger unit")]
    TooLarge {
        /// Of what.
        what: &'static str,
    },
    /// A confidence level outside (0, 1).
    #[error("confidence must lie between 0 and 1, exclusive; it is {0}")]
    Confidence(f64),
    /// A probability outside 0–1.
    #[error("{what} must be a probability, 0 to 1; it is {value}")]
    Probability {
        /// Which.
        what: String,
        /// The value.
        value: f64,
    },
    /// More successes than trials.
    #[error("{k} of {n}: there cannot be more successes than trials")]
    MoreThanAll {
        /// Successes.
        k: u64,
        /// Trials.
        n: u64,
    },
    /// No trials.
    #[error("no trials: nothing can be said about their probability")]
    NoTrials,
    /// Subjects' rows of different length.
    #[error("row {} has {found} values, but the first has {expected}", row + 1)]
    Ragged {
        /// Which row, from 0.
        row: usize,
        /// Values of the first row.
        expected: usize,
        /// Values of this row.
        found: usize,
    },
    /// An exact distribution was asked for that would take too long.
    #[error("the exact distribution is offered up to n = {most}; there are {n}")]
    TooManyForExact {
        /// Values there are.
        n: usize,
        /// Values there may be.
        most: usize,
    },
}

pub(crate) fn check_finite(what: &'static str, values: &[f64]) -> Result<(), TestError> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(TestError::NotFinite { what, index, value: values[index] }),
        None => Ok(()),
    }
}

pub(crate) fn check_confidence(confidence: f64) -> Result<(), TestError> {
    if confidence > 0.0 && confidence < 1.0 { Ok(()) } else { Err(TestError::Confidence(confidence)) }
}

pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Sum of squared deviations from the mean.
pub(crate) fn squares(values: &[f64]) -> f64 {
    let mean = mean(values);
    values.iter().map(|value| (value - mean) * (value - mean)).sum()
}

/// Whether a standard deviation is no more than the rounding of numbers as large as these.
pub(crate) fn is_rounding(sd: f64, values: &[f64]) -> bool {
    let largest = values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    sd <= 8.0 * f64::EPSILON * largest
}
