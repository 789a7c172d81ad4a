//! One psychometric function on one variable: the share of right answers by level, and its threshold with an interval.
//!
//! `ψ(x) = γ + (1 − γ − λ) Φ(3.2897 (x − threshold)/width)`, on a linear or a logarithmic axis, rising or falling with the
//! level. The threshold is where Φ is one half; the width spans 5 % to 95 % of Φ. Priors and parametrisation are those of
//! psignifit (Schütt, Harmeling, Macke and Wichmann 2016) without its overdispersion: answers are binomial. The joint fit
//! of a line over eccentricities is [`crate::mar`].

mod grid;
mod posterior;

use crate::mar::{Estimate, Support};
use crate::numerics::normal_cdf_pair;
use posterior::Posterior;
use serde::{Deserialize, Serialize};

/// Φ⁻¹(0.95) − Φ⁻¹(0.05): a width in standard deviations.
const WIDTH_IN_SD: f64 = 3.289_707_253_902_944_4;

/// Twice the gain in log likelihood over a constant share that a fit must have: the 95 % point of χ² with two degrees of
/// freedom, for threshold and width.
const CHI_SQUARE_2_95: f64 = 5.991_464_547_107_979;

/// The answers at one level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Count {
    /// The level, in its parameter's unit.
    pub level: f64,
    /// Answers.
    pub n: u32,
    /// Right ones.
    pub k: u32,
}

/// On which axis the function is a cumulative Gaussian.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// The level itself.
    Linear,
    /// Its natural logarithm; levels must be above zero.
    Logarithmic,
}

impl Scale {
    /// The axis on which levels are spaced more evenly: logarithmic if their ratios vary less than their differences.
    #[must_use]
    pub fn of_levels(levels: &[f64]) -> Self {
        let mut sorted = crate::numerics::sorted_finite(levels.iter().copied());
        sorted.dedup();
        if sorted.len() < 3 || sorted[0] <= 0.0 {
            return Self::Linear;
        }
        let unevenness = |steps: &[f64]| {
            let mean = steps.iter().sum::<f64>() / steps.len() as f64;
            (steps.iter().map(|step| (step - mean).powi(2)).sum::<f64>() / steps.len() as f64).sqrt() / mean
        };
        let differences: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let ratios: Vec<f64> = sorted.windows(2).map(|pair| (pair[1] / pair[0]).ln()).collect();
        if unevenness(&ratios) + 1e-9 < unevenness(&differences) { Self::Logarithmic } else { Self::Linear }
    }

    pub(crate) fn coordinate(self, level: f64) -> f64 {
        match self {
            Self::Linear => level,
            Self::Logarithmic => level.ln(),
        }
    }

    pub(crate) fn level(self, coordinate: f64) -> f64 {
        match self {
            Self::Linear => coordinate,
            Self::Logarithmic => coordinate.exp(),
        }
    }
}

/// Whether right answers become more or less frequent as the level grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// More frequent: a larger level is easier to tell from the reference.
    Rises,
    /// Less frequent, as with Guenter's quality index, of which a larger one is finer.
    Falls,
}

impl Direction {
    /// The direction that the answers themselves take: the sign of their covariance with the level; rising if there is
    /// none.
    #[must_use]
    pub fn of_counts(counts: &[Count]) -> Self {
        let total: f64 = counts.iter().map(|count| f64::from(count.n)).sum();
        let mean = counts.iter().map(|count| f64::from(count.n) * count.level).sum::<f64>() / total;
        let share = counts.iter().map(|count| f64::from(count.k)).sum::<f64>() / total;
        let covariance: f64 =
            counts.iter().map(|count| (count.level - mean) * (f64::from(count.k) - share * f64::from(count.n))).sum();
        if covariance < 0.0 { Self::Falls } else { Self::Rises }
    }

    pub(crate) fn sign(self) -> f64 {
        match self {
            Self::Rises => 1.0,
            Self::Falls => -1.0,
        }
    }
}

/// How often an answer is right without anything having been seen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Guess {
    /// This often: ½ for two alternatives; 0 … below 1.
    Fixed(f64),
    /// Unknown: the false alarms of an observer who may also say "the same". Prior Beta(1, 10), cut at ½.
    Free,
}

/// How a function is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PsychometricConfig {
    /// The axis.
    pub scale: Scale,
    /// The direction.
    pub direction: Direction,
    /// The guess rate.
    pub guess: Guess,
}

/// The parameters of one function.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Psychometric {
    /// The level at which Φ is ½.
    pub threshold: f64,
    /// From 5 % to 95 % of Φ, in units of the level, or of its natural logarithm on a logarithmic axis.
    pub width: f64,
    /// Lapse rate λ.
    pub lapse: f64,
    /// Guess rate γ.
    pub guess: f64,
}

impl Psychometric {
    /// The probability of a right answer at a level.
    #[must_use]
    pub fn probability(&self, level: f64, scale: Scale, direction: Direction) -> f64 {
        let distance = scale.coordinate(level) - scale.coordinate(self.threshold);
        let (seen, _) = normal_cdf_pair(direction.sign() * WIDTH_IN_SD * distance / self.width);
        self.guess + (1.0 - self.guess - self.lapse) * seen
    }
}

/// A fitted function.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PsychometricFit {
    /// The threshold: posterior median and 95 % interval.
    pub threshold: Estimate,
    /// The width.
    pub width: Estimate,
    /// The lapse rate.
    pub lapse: Estimate,
    /// The guess rate; a fixed one is its own interval.
    pub guess: Estimate,
    /// The mode of the posterior density.
    pub map: Psychometric,
    /// How it was fitted.
    pub config: PsychometricConfig,
    /// The data, ascending in level.
    pub counts: Vec<Count>,
    /// Whether the data carry the fit.
    pub support: Support,
}

impl PsychometricFit {
    /// The probability of a right answer at a level, by the mode.
    #[must_use]
    pub fn probability(&self, level: f64) -> f64 {
        self.map.probability(level, self.config.scale, self.config.direction)
    }
}

/// Why there is no fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PsychometricError {
    /// Threshold, width and lapses cannot be told apart.
    #[error("answers at {levels} level(s), and a function needs at least 3")]
    FewLevels {
        /// Levels with answers.
        levels: usize,
    },
    /// A count is impossible.
    #[error(
        "level {level}: expected a finite level{positive} with at most as many right answers as answers, found {k} of {n}"
    )]
    BadCount {
        /// The level.
        level: f64,
        /// `, above zero` on a logarithmic axis.
        positive: &'static str,
        /// Right answers.
        k: u32,
        /// Answers.
        n: u32,
    },
    /// The guess rate is impossible.
    #[error("the guess rate must lie from 0 to below 1, found {found}")]
    BadGuess {
        /// The rate.
        found: f64,
    },
}

/// Fits one psychometric function to counts; equal levels are taken together.
///
/// The posterior is integrated on a grid over (threshold, ln width, λ, and γ where it is free) that closes in on where the
/// posterior is. Priors (psignifit's standard ones, in the axis's coordinate): threshold flat over the range R of levels,
/// falling to 0 as a raised cosine over R/2 on either side; width rising from the smallest step s to 2 s, flat up to R and
/// falling to 0 at 3 R, both as raised cosines; λ and a free γ Beta(1, 10), cut at ½.
///
/// # Errors
/// When fewer than three levels have answers, or a count or the guess rate is impossible.
///
/// ```
/// use analysis::psychometric::{Count, Direction, Guess, PsychometricConfig, Scale, fit_psychometric};
/// let counts: Vec<Count> = [19, 22, 27, 32, 37, 39, 39]
///     .iter()
///     .zip(1..)
///     .map(|(&k, level)| Count { level: f64::from(level), n: 40, k })
///     .collect();
/// let config =
///     PsychometricConfig { scale: Scale::Linear, direction: Direction::Rises, guess: Guess::Fixed(0.5) };
/// let fit = fit_psychometric(&counts, &config)?;
/// assert!((fit.map.threshold - 3.5482).abs() < 1e-3);
/// # Ok::<(), analysis::psychometric::PsychometricError>(())
/// ```
pub fn fit_psychometric(counts: &[Count], config: &PsychometricConfig) -> Result<PsychometricFit, PsychometricError> {
    let counts = checked(counts, config)?;
    let posterior = Posterior::new(&counts, config);
    let integrated = grid::integrate(&posterior);

    let sign = config.direction.sign();
    let level = |x: f64| config.scale.level(sign * x);
    let [low, middle, high] = integrated.threshold;
    let ends = if sign > 0.0 { [low, high] } else { [high, low] };
    let estimate = |[low, middle, high]: [f64; 3]| Estimate { estimate: middle, ci95: [low, high] };
    let map = integrated.mode;
    let mut fit = PsychometricFit {
        threshold: Estimate { estimate: level(middle), ci95: ends.map(level) },
        width: estimate(integrated.width),
        lapse: estimate(integrated.lapse),
        guess: estimate(integrated.guess),
        map: Psychometric { threshold: level(map.threshold), ..map },
        config: *config,
        counts,
        support: Support::Supported,
    };
    fit.support = support(&fit, &posterior);
    Ok(fit)
}

/// The counts by ascending level, equal levels together, levels without answers left out.
fn checked(counts: &[Count], config: &PsychometricConfig) -> Result<Vec<Count>, PsychometricError> {
    if let Guess::Fixed(found) = config.guess
        && !(0.0..1.0).contains(&found)
    {
        return Err(PsychometricError::BadGuess { found });
    }
    let logarithmic = config.scale == Scale::Logarithmic;
    let mut sorted: Vec<Count> = Vec::with_capacity(counts.len());
    for &Count { level, n, k } in counts {
        if !level.is_finite() || k > n || (logarithmic && level <= 0.0) {
            let positive = if logarithmic { ", above zero," } else { "" };
            return Err(PsychometricError::BadCount { level, positive, k, n });
        }
        if n > 0 {
            sorted.push(Count { level, n, k });
        }
    }
    sorted.sort_by(|a, b| a.level.total_cmp(&b.level));
    sorted.dedup_by(|next, kept| {
        let same = next.level == kept.level;
        if same {
            kept.n += next.n;
            kept.k += next.k;
        }
        same
    });
    if sorted.len() < 3 {
        return Err(PsychometricError::FewLevels { levels: sorted.len() });
    }
    Ok(sorted)
}

/// What speaks against reading the fit as a result.
fn support(fit: &PsychometricFit, posterior: &Posterior) -> Support {
    let mut reasons = Vec::new();
    let gain = 2.0 * (posterior.ln_likelihood_of(&fit.counts, |level| fit.probability(level)) - constant(&fit.counts));
    if gain < CHI_SQUARE_2_95 {
        reasons.push("The answers do not depend on the level by more than chance would make them.".to_owned());
    }
    let (first, last) = (fit.counts[0].level, fit.counts[fit.counts.len() - 1].level);
    if !(first..=last).contains(&fit.threshold.estimate) {
        reasons.push("The threshold lies outside the levels that were shown: it is extrapolated.".to_owned());
    }
    if reasons.is_empty() { Support::Supported } else { Support::Unsupported { reasons } }
}

/// The largest log likelihood of answers that do not depend on the level.
fn constant(counts: &[Count]) -> f64 {
    let n: u32 = counts.iter().map(|count| count.n).sum();
    let k: u32 = counts.iter().map(|count| count.k).sum();
    let (right, wrong, n) = (f64::from(k), f64::from(n - k), f64::from(n));
    let term = |count: f64| if count > 0.0 { count * (count / n).ln() } else { 0.0 };
    term(right) + term(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_follows_the_spacing_of_the_levels() {
        assert_eq!(Scale::of_levels(&[8.0, 10.0, 12.0, 14.0, 22.0, 20.0, 18.0, 16.0]), Scale::Linear);
        assert_eq!(Scale::of_levels(&[0.1, 0.2, 0.4, 0.8]), Scale::Logarithmic);
        assert_eq!(Scale::of_levels(&[0.0, 1.0, 4.0]), Scale::Linear);
        assert_eq!(Scale::of_levels(&[1.0, 9.0]), Scale::Linear);
    }

    #[test]
    fn the_width_spans_five_to_ninety_five_per_cent() {
        let function = Psychometric { threshold: 4.0, width: 2.0, lapse: 0.0, guess: 0.0 };
        for (level, expected) in [(3.0, 0.05), (4.0, 0.5), (5.0, 0.95)] {
            assert!((function.probability(level, Scale::Linear, Direction::Rises) - expected).abs() < 1e-9);
            let falling = function.probability(level, Scale::Linear, Direction::Falls);
            assert!((falling - (1.0 - expected)).abs() < 1e-9);
        }
        let octave = Psychometric { width: 2.0 * 2f64.ln(), ..function };
        assert!((octave.probability(8.0, Scale::Logarithmic, Direction::Rises) - 0.95).abs() < 1e-9);
    }

    #[test]
    fn impossible_counts_are_named() {
        let config =
            PsychometricConfig { scale: Scale::Logarithmic, direction: Direction::Rises, guess: Guess::Fixed(0.5) };
        let count = |level, n, k| Count { level, n, k };
        let few = fit_psychometric(&[count(1.0, 4, 2), count(1.0, 4, 2), count(2.0, 4, 4), count(3.0, 0, 0)], &config);
        assert_eq!(few, Err(PsychometricError::FewLevels { levels: 2 }));
        for bad in [count(0.0, 4, 2), count(f64::NAN, 4, 2), count(1.0, 4, 5)] {
            let found = fit_psychometric(&[bad, count(2.0, 4, 4), count(3.0, 4, 4)], &config);
            assert!(matches!(found, Err(PsychometricError::BadCount { .. })), "{found:?}");
        }
        let all = [count(1.0, 4, 2), count(2.0, 4, 4), count(3.0, 4, 4)];
        let guess = PsychometricConfig { guess: Guess::Fixed(1.0), ..config };
        assert_eq!(fit_psychometric(&all, &guess), Err(PsychometricError::BadGuess { found: 1.0 }));
    }

    #[test]
    fn the_direction_is_the_sign_of_the_covariance() {
        let counts = |ks: [u32; 3]| [0, 1, 2].map(|i| Count { level: f64::from(i), n: 10, k: ks[i as usize] });
        assert_eq!(Direction::of_counts(&counts([9, 5, 1])), Direction::Falls);
        assert_eq!(Direction::of_counts(&counts([1, 5, 9])), Direction::Rises);
        assert_eq!(Direction::of_counts(&counts([5, 5, 5])), Direction::Rises);
    }
}
