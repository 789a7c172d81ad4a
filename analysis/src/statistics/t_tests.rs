//! t tests of one sample, of pairs and of two samples with unequal variances (Welch 1947), with intervals and effect
//! sizes.
//!
//! Student's test of two samples with a common variance is deliberately absent: Welch's costs nothing where it would
//! have held.

use super::distributions::{student_t, student_t_quantile, two_sided_t};
use super::effect_size::{EffectSize, Standardizer};
use super::{Alternative, TestError, check_confidence, check_finite, is_rounding, mean, squares};
use serde::{Deserialize, Serialize};

/// What was compared with what.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "design")]
pub enum Design {
    /// One sample's mean with a value.
    OneSample {
        /// The value.
        value: f64,
        /// Values.
        n: usize,
    },
    /// Two values of every subject.
    Paired {
        /// Pairs.
        n: usize,
    },
    /// Two independent samples.
    Welch {
        /// Values in each.
        n: [usize; 2],
    },
}

/// A t test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TTest {
    /// What was compared.
    pub design: Design,
    /// What the p value is against.
    pub alternative: Alternative,
    /// The difference over its standard error.
    pub t: f64,
    /// Degrees of freedom; a fraction for Welch's test.
    pub df: f64,
    /// p value.
    pub p: f64,
    /// Mean of the first minus mean of the second (or minus the value), in the data's unit.
    pub difference: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Its interval, two-sided whatever the alternative.
    pub ci: [f64; 2],
    /// Confidence of all intervals, 0–1.
    pub confidence: f64,
    /// Standardised differences.
    pub effect_sizes: Vec<EffectSize>,
}

impl TTest {
    /// The standardised difference with this divisor.
    #[must_use]
    pub fn effect_size(&self, standardizer: Standardizer) -> Option<&EffectSize> {
        self.effect_sizes.iter().find(|effect| effect.standardizer == standardizer)
    }
}

/// One sample's mean against `value`.
///
/// # Errors
///
/// Fewer than two values, values that are not finite or do not vary, a confidence outside (0, 1).
pub fn one_sample(values: &[f64], value: f64, alternative: Alternative, confidence: f64) -> Result<TTest, TestError> {
    check_finite("the value to compare with", &[value])?;
    check("the sample", values)?;
    check_confidence(confidence)?;
    let differences: Vec<f64> = values.iter().map(|x| x - value).collect();
    check_variance("the values", sd(&differences), &[values])?;
    let design = Design::OneSample { value, n: values.len() };
    Ok(TTest { design, ..of_differences(&differences, alternative, confidence) })
}

/// Pairs: `first[i]` and `second[i]` are of the same subject.
///
/// Effect sizes: [`Standardizer::Differences`] and, if either side varies, [`Standardizer::Average`].
///
/// # Errors
///
/// Samples of different length, fewer than two pairs, values that are not finite, differences that do not vary, a
/// confidence outside (0, 1).
///
/// ```
/// use analysis::statistics::{Alternative, t_tests::paired};
/// let test = paired(&[0.021, 0.025, 0.019, 0.024], &[0.020, 0.022, 0.018, 0.020], Alternative::TwoSided, 0.95)?;
/// assert!((test.t - 3.0).abs() < 1e-9 && test.df == 3.0);
/// # Ok::<(), analysis::statistics::TestError>(())
/// ```
pub fn paired(first: &[f64], second: &[f64], alternative: Alternative, confidence: f64) -> Result<TTest, TestError> {
    if first.len() != second.len() {
        return Err(TestError::UnequalLengths { first: first.len(), second: second.len() });
    }
    check("the first sample", first)?;
    check("the second sample", second)?;
    check_confidence(confidence)?;
    let differences: Vec<f64> = first.iter().zip(second).map(|(a, b)| a - b).collect();
    check_variance("the differences", sd(&differences), &[first, second])?;
    let mut test = of_differences(&differences, alternative, confidence);
    test.design = Design::Paired { n: first.len() };
    let average = (0.5 * (sd(first).powi(2) + sd(second).powi(2))).sqrt();
    let of_differences = test.effect_sizes.first().copied();
    if let Some(effect) = of_differences.filter(|_| average > 0.0) {
        test.effect_sizes.push(effect.over(Standardizer::Average, sd(&differences) / average, test.df));
    }
    Ok(test)
}

/// Two independent samples whose variances may differ.
///
/// Effect sizes: [`Standardizer::Average`], whose interval takes Welch's degrees of freedom and whose bias those of the
/// mean variance (Delacre et al. 2021), and [`Standardizer::Pooled`].
///
/// # Errors
///
/// Fewer than two values in a sample, values that are not finite, samples neither of which varies, a confidence outside
/// (0, 1).
pub fn welch(first: &[f64], second: &[f64], alternative: Alternative, confidence: f64) -> Result<TTest, TestError> {
    check("the first sample", first)?;
    check("the second sample", second)?;
    check_confidence(confidence)?;
    let [(n1, s1), (n2, s2)] = [first, second].map(|x| (x.len() as f64, sd(x)));
    check_variance("both samples", s1 + s2, &[first, second])?;
    let [of_first, of_second] = [s1 * s1 / n1, s2 * s2 / n2];
    let standard_error = (of_first + of_second).sqrt();
    // Shares of the error's variance: squares of variances would underflow for small units.
    let share = of_first / (of_first + of_second);
    let df = 1.0 / (share * share / (n1 - 1.0) + (1.0 - share) * (1.0 - share) / (n2 - 1.0));
    let difference = mean(first) - mean(second);
    let design = Design::Welch { n: [first.len(), second.len()] };
    let mut test = test(design, difference, standard_error, df, alternative, confidence);

    let average = (0.5 * (s1 * s1 + s2 * s2)).sqrt();
    let share = s1 * s1 / (s1 * s1 + s2 * s2);
    let average_df = 1.0 / (share * share / (n1 - 1.0) + (1.0 - share) * (1.0 - share) / (n2 - 1.0));
    let pooled_df = n1 + n2 - 2.0;
    let pooled = (((n1 - 1.0) * s1 * s1 + (n2 - 1.0) * s2 * s2) / pooled_df).sqrt();
    let root = (1.0 / n1 + 1.0 / n2).sqrt();
    test.effect_sizes.extend(EffectSize::new(
        Standardizer::Average,
        test.t,
        df,
        standard_error / average,
        average_df,
        confidence,
    ));
    // Its own t has the pooled standard error.
    test.effect_sizes.extend(EffectSize::new(
        Standardizer::Pooled,
        difference / (pooled * root),
        pooled_df,
        root,
        pooled_df,
        confidence,
    ));
    Ok(test)
}

fn check(what: &'static str, values: &[f64]) -> Result<(), TestError> {
    if values.len() < 2 {
        return Err(TestError::TooFew { what, n: values.len(), least: 2 });
    }
    check_finite(what, values)
}

/// Whether there is a variance that is neither rounding nor too large for a number.
fn check_variance(what: &'static str, sd: f64, samples: &[&[f64]]) -> Result<(), TestError> {
    if !(sd * sd).is_finite() {
        return Err(TestError::TooLarge { what });
    }
    if samples.iter().all(|sample| is_rounding(sd, sample)) || sd * sd < f64::MIN_POSITIVE {
        return Err(TestError::NoVariance { what });
    }
    Ok(())
}

fn sd(values: &[f64]) -> f64 {
    (squares(values) / (values.len() - 1) as f64).sqrt()
}

fn of_differences(differences: &[f64], alternative: Alternative, confidence: f64) -> TTest {
    let n = differences.len() as f64;
    let standard_error = sd(differences) / n.sqrt();
    let design = Design::Paired { n: differences.len() };
    let mut test = test(design, mean(differences), standard_error, n - 1.0, alternative, confidence);
    let d_per_t = 1.0 / n.sqrt();
    test.effect_sizes.extend(EffectSize::new(Standardizer::Differences, test.t, n - 1.0, d_per_t, n - 1.0, confidence));
    test
}

fn test(
    design: Design,
    difference: f64,
    standard_error: f64,
    df: f64,
    alternative: Alternative,
    confidence: f64,
) -> TTest {
    let t = difference / standard_error;
    let tails = student_t(t, df);
    let p = match alternative {
        Alternative::TwoSided => two_sided_t(t, df),
        Alternative::Greater => tails.map_or(1.0, |tails| tails.upper),
        Alternative::Less => tails.map_or(1.0, |tails| tails.lower),
    };
    // A confidence so high that its quantile is no number leaves the widest interval there is.
    let half =
        student_t_quantile(0.5 * (1.0 - confidence), df).map_or(f64::MAX, |t| (t * standard_error).min(f64::MAX));
    let ci = [(difference - half).max(f64::MIN), (difference + half).min(f64::MAX)];
    TTest { design, alternative, t, df, p, difference, standard_error, ci, confidence, effect_sizes: Vec::new() }
}
