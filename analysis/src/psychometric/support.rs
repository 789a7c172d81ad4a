//! Whether data carry a psychometric fit.

use super::{Count, Overdispersion, PsychometricFit};
use crate::mar::Support;

/// Twice the gain in log likelihood over a constant share that a fit must have: the 95 % point of χ² with two degrees of
/// freedom, for threshold and width.
const CHI_SQUARE_2_95: f64 = 5.991_464_547_107_979;

/// What speaks against reading the fit as a result.
pub(super) fn support(fit: &PsychometricFit) -> Support {
    let mut reasons = Vec::new();
    let counts = &fit.counts;
    if counts.is_empty() {
        reasons.push("There are no answers: every number is the prior's.".to_owned());
        return Support::Unsupported { reasons };
    }
    let gain = 2.0 * (ln_likelihood_of(counts, |level| fit.probability(level)) - constant(counts));
    if gain.is_nan() || gain < CHI_SQUARE_2_95 {
        reasons.push("The answers do not depend on the level by more than chance would make them.".to_owned());
    }
    let (first, last) = (counts[0].level, counts[counts.len() - 1].level);
    if !(first..=last).contains(&fit.threshold.estimate) {
        reasons.push("The threshold lies outside the levels that were shown: it is extrapolated.".to_owned());
    }
    let mut levels: Vec<f64> = counts.iter().map(|count| count.level).collect();
    levels.dedup();
    if levels.len() < 3 {
        reasons.push("Fewer than three levels were shown: the width is mostly the prior's.".to_owned());
    }
    if reasons.is_empty() { Support::Supported } else { Support::Unsupported { reasons } }
}

/// What a reader should know beside the numbers.
pub(super) fn warnings(fit: &PsychometricFit) -> Vec<String> {
    let mut warnings = Vec::new();
    let blocks = fit.counts.iter().any(|count| count.n > 1);
    if fit.config.overdispersion == Overdispersion::Free && !blocks {
        warnings.push(
            "Every row is one answer, which cannot tell overdispersion: its posterior is its prior. Rows of several \
             answers can."
                .to_owned(),
        );
    }
    if fit.overdispersion.estimate > 0.2 {
        warnings.push(
            "Answers vary more than independent ones would (overdispersion above 0.2): the observer's criterion or attention \
             may have drifted, or the shape may be wrong."
                .to_owned(),
        );
    }
    if fit.lapse.estimate > 0.1 {
        warnings.push(format!("The lapse rate is {:.0} %.", 100.0 * fit.lapse.estimate));
    }
    warnings
}

/// The log likelihood of any function of the level, answers independent.
fn ln_likelihood_of(counts: &[Count], probability: impl Fn(f64) -> f64) -> f64 {
    let term = |count: u32, p: f64| if count > 0 { f64::from(count) * p.ln() } else { 0.0 };
    counts
        .iter()
        .map(|count| {
            let p = probability(count.level);
            term(count.k, p) + term(count.n - count.k, 1.0 - p)
        })
        .sum()
}

/// The largest log likelihood of answers that do not depend on the level.
fn constant(counts: &[Count]) -> f64 {
    let n: f64 = counts.iter().map(|count| f64::from(count.n)).sum();
    let right: f64 = counts.iter().map(|count| f64::from(count.k)).sum();
    let term = |count: f64| if count > 0.0 { count * (count / n).ln() } else { 0.0 };
    term(right) + term(n - right)
}
