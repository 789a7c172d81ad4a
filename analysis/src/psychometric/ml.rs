//! Maximum likelihood: the function that makes the answers most probable, with profile-likelihood intervals.
//!
//! No prior enters; each parameter only has the widest values that make sense for the levels (threshold two ranges outside
//! them, width from a thousandth of a step to thirty ranges, rates to ½), and an interval that reaches such an end is open
//! there.

use super::config::{Guess, Lapse, Overdispersion};
use super::data::{Checked, checked, merged};
use super::deviance::deviance;
use super::maximum::maximise;
use super::posterior::{Posterior, point_of};
use super::{Count, Prior, Priors, Psychometric, PsychometricConfig, PsychometricError};
use serde::{Deserialize, Serialize};
use statrs::function::gamma::ln_gamma;

/// The 95 % point of χ² with one degree of freedom.
const CHI_SQUARE_1_95: f64 = 3.841_458_820_694_124;

/// A 95 % interval from the profile likelihood; an end is nothing where the likelihood never falls far enough.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// Lower end.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
}

/// A maximum-likelihood fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LikelihoodFit {
    /// The function with the largest likelihood.
    pub estimate: Psychometric,
    /// Its log likelihood, binomial coefficients included.
    pub ln_likelihood: f64,
    /// Its deviance.
    pub deviance: f64,
    /// Free parameters.
    pub parameters: usize,
    /// Akaike's criterion, 2 · parameters − 2 ln L.
    pub aic: f64,
    /// Schwarz's criterion, parameters · ln(answers) − 2 ln L.
    pub bic: f64,
    /// Profile interval of the threshold.
    pub threshold: Profile,
    /// Of the width.
    pub width: Profile,
    /// Of the lapse rate.
    pub lapse: Profile,
    /// Of the guess rate.
    pub guess: Profile,
    /// Of η.
    pub overdispersion: Profile,
    /// How it was fitted; priors are not used.
    pub config: PsychometricConfig,
    /// The data, ascending in level.
    pub counts: Vec<Count>,
}

/// Fits one function by maximum likelihood.
///
/// # Errors
/// When fewer than two levels have answers, or a count or a rate is impossible.
///
/// ```
/// use analysis::psychometric::{Count, PsychometricConfig, likelihood_fit};
/// let counts = [(1.0, 11), (2.0, 13), (3.0, 17), (4.0, 19)].map(|(level, k)| Count { level, n: 20, k });
/// let fit = likelihood_fit(&counts, &PsychometricConfig::TWO_ALTERNATIVES)?;
/// assert!(fit.threshold.low < Some(fit.estimate.threshold));
/// # Ok::<(), analysis::psychometric::PsychometricError>(())
/// ```
pub fn likelihood_fit(counts: &[Count], config: &PsychometricConfig) -> Result<LikelihoodFit, PsychometricError> {
    let surface = Surface::new(counts, config)?;
    let (at, value) = surface.highest();
    let estimate = surface.function(&at);
    let ln_likelihood = value + ln_coefficients(&surface.data.counts);
    let parameters = surface.bounds.iter().filter(|[low, high]| low < high).count();
    let answers: f64 = surface.data.counts.iter().map(|count| f64::from(count.n)).sum();
    let interval = |index: usize, value_of: &dyn Fn(f64) -> f64| surface.profile(index, &at, value, value_of);
    let identity = |x: f64| x;
    let lapse = interval(2, &identity);
    Ok(LikelihoodFit {
        estimate,
        ln_likelihood,
        deviance: deviance(&surface.data.counts, &estimate, config),
        parameters,
        aic: 2.0 * parameters as f64 - 2.0 * ln_likelihood,
        bic: parameters as f64 * answers.max(1.0).ln() - 2.0 * ln_likelihood,
        threshold: interval(0, &|x| config.scale.level(x)),
        width: interval(1, &f64::exp),
        lapse,
        guess: if surface.posterior.tied() { lapse } else { interval(3, &identity) },
        overdispersion: interval(4, &identity),
        config: *config,
        counts: surface.data.counts.clone(),
    })
}

/// Σ ln of the binomial coefficients.
fn ln_coefficients(counts: &[Count]) -> f64 {
    counts
        .iter()
        .map(|count| {
            let [n, k] = [count.n, count.k].map(f64::from);
            ln_gamma(n + 1.0) - ln_gamma(k + 1.0) - ln_gamma(n - k + 1.0)
        })
        .sum()
}

/// The log likelihood of one data set over (threshold, ln width, λ, γ, η), and where to look for its top.
pub(super) struct Surface {
    pub(super) posterior: Posterior,
    pub(super) data: Checked,
    pub(super) bounds: [[f64; 2]; 5],
    pub(super) scales: [f64; 5],
}

impl Surface {
    pub(super) fn new(counts: &[Count], config: &PsychometricConfig) -> Result<Self, PsychometricError> {
        // Without priors, the levels alone say where to look.
        let data = checked(counts, &PsychometricConfig { priors: Priors::STANDARD, ..*config })?;
        let spread = data.range[1] - data.range[0];
        let rate = Prior::Uniform { low: 0.0, high: 1.0 };
        let priors = Priors {
            threshold: Prior::Uniform { low: data.range[0] - 2.0 * spread, high: data.range[1] + 2.0 * spread },
            width: Prior::Uniform { low: 1e-3 * data.step, high: 30.0 * spread },
            lapse: rate,
            guess: rate,
            overdispersion: rate,
        };
        let mut posterior = Posterior::new(&data, config);
        posterior.priors = priors;
        let mut bounds = posterior.bounds();
        bounds[1] = bounds[1].map(f64::ln);
        Ok(Self { posterior, data, bounds, scales: [0.1 * spread, 0.3, 0.02, 0.02, 0.05] })
    }

    pub(super) fn value(&self, x: &[f64]) -> f64 {
        self.posterior.ln_density(&point_of(x))
    }

    /// The highest point, searched from the best places of a coarse grid.
    pub(super) fn highest(&self) -> (Vec<f64>, f64) {
        let spread = self.data.range[1] - self.data.range[0];
        let config = &self.posterior.config;
        let along = |low: f64, high: f64, n: usize| (0..n).map(move |i| low + (high - low) * i as f64 / (n - 1) as f64);
        let lapses = if config.lapse == Lapse::Free { vec![0.0, 0.03, 0.15] } else { vec![self.bounds[2][0]] };
        let guesses = if config.guess == Guess::Free { vec![0.01, 0.1, 0.3] } else { vec![self.bounds[3][0]] };
        let etas = if config.overdispersion == Overdispersion::Free { vec![0.0, 0.2] } else { vec![0.0] };
        let mut starts: Vec<(f64, [f64; 5])> = Vec::new();
        for threshold in along(self.data.range[0] - 0.25 * spread, self.data.range[1] + 0.25 * spread, 13) {
            for ln_width in along((0.3 * self.data.step).ln(), (3.0 * spread).ln(), 8) {
                for &lapse in &lapses {
                    for &guess in &guesses {
                        for &eta in &etas {
                            let x = [threshold, ln_width, lapse, guess, eta];
                            let value = self.value(&x);
                            if value.is_finite() {
                                starts.push((value, x));
                            }
                        }
                    }
                }
            }
        }
        starts.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut tried: Vec<[f64; 5]> = Vec::new();
        let mut best =
            (vec![0.5 * (self.data.range[0] + self.data.range[1]), spread.ln(), 0.0, 0.0, 0.0], f64::NEG_INFINITY);
        for (_, start) in starts {
            // Starts beside each other climb to the same top.
            let beside = |other: &[f64; 5]| {
                (start[0] - other[0]).abs() < 0.15 * spread && (start[1] - other[1]).abs() < 0.7 && start[4] == other[4]
            };
            if tried.iter().any(beside) {
                continue;
            }
            tried.push(start);
            let found = self.climb(&start);
            if found.1 > best.1 {
                best = found;
            }
            if tried.len() == 4 {
                break;
            }
        }
        best
    }

    /// The function at a place of the search.
    pub(super) fn function(&self, x: &[f64]) -> Psychometric {
        self.posterior.function(&point_of(x))
    }

    /// The log likelihood without bounds, for data sets that share parameters.
    pub(super) fn likelihood(&self, x: &[f64]) -> f64 {
        let [threshold, width, lapse, guess, eta] = point_of(x);
        let guess = self.posterior.guess(lapse, guess);
        self.posterior.likelihood.ln_likelihood(threshold, width, lapse, guess, eta)
    }

    /// The top above a start.
    pub(super) fn climb(&self, start: &[f64]) -> (Vec<f64>, f64) {
        maximise(|x| self.value(x), start, &self.bounds, &self.scales)
    }

    /// Where the likelihood, at its best over all other parameters, has fallen by half of χ²'s 95 % point.
    fn profile(&self, index: usize, top: &[f64], top_value: f64, value_of: &dyn Fn(f64) -> f64) -> Profile {
        let [low, high] = self.bounds[index];
        if low >= high {
            return Profile { low: Some(value_of(top[index])), high: Some(value_of(top[index])) };
        }
        let ends = [-1.0, 1.0].map(|side| self.profile_end(index, side, top, top_value).map(value_of));
        Profile { low: ends[0], high: ends[1] }
    }

    fn profile_end(&self, index: usize, side: f64, top: &[f64], top_value: f64) -> Option<f64> {
        let end = self.bounds[index][usize::from(side > 0.0)];
        let excess_at = |value: f64, from: &[f64]| -> (f64, Vec<f64>) {
            let mut bounds = self.bounds;
            bounds[index] = [value, value];
            let mut start = from.to_vec();
            start[index] = value;
            let (at, found) = maximise(|x| self.value(x), &start, &bounds, &self.scales);
            let found = if found.is_finite() { found } else { top_value - 1e6 };
            (2.0 * (top_value - found) - CHI_SQUARE_1_95, at)
        };
        // Outwards by growing steps, each from where the last one stood.
        let (mut inner, mut at) = (top[index], top.to_vec());
        let mut step = 0.5 * self.scales[index];
        let (mut inner_excess, mut outer, mut outer_excess);
        inner_excess = -CHI_SQUARE_1_95;
        loop {
            let value = if side > 0.0 { (inner + step).min(end) } else { (inner - step).max(end) };
            let (excess, found) = excess_at(value, &at);
            if excess >= 0.0 {
                (outer, outer_excess) = (value, excess);
                break;
            }
            if value == end {
                // A rate's lower end is zero, which is a value; other ends are only where the search stops.
                return (index >= 2 && side < 0.0).then_some(end);
            }
            (inner, inner_excess, at) = (value, excess, found);
            step *= 1.7;
        }
        // The root between both, by regula falsi with the Illinois rule.
        let mut kept = 0;
        for _ in 0..60 {
            if (outer - inner).abs() < 1e-7 * self.scales[index] {
                break;
            }
            let share = inner_excess / (inner_excess - outer_excess);
            let value = inner + (outer - inner) * share.clamp(0.02, 0.98);
            let (excess, found) = excess_at(value, &at);
            if excess >= 0.0 {
                (outer, outer_excess) = (value, excess);
                if kept == 1 {
                    inner_excess *= 0.5;
                }
                kept = 1;
            } else {
                (inner, inner_excess, at) = (value, excess, found);
                if kept == 2 {
                    outer_excess *= 0.5;
                }
                kept = 2;
            }
            if excess.abs() < 1e-8 {
                return Some(value);
            }
        }
        Some(0.5 * (inner + outer))
    }
}

/// Draws answers from a function at the levels of some counts: a Pólya urn, which is beta-binomial for η above zero.
pub(super) fn simulated(
    counts: &[Count],
    function: &Psychometric,
    config: &PsychometricConfig,
    rng: &mut impl rand::RngExt,
) -> Vec<Count> {
    let eta = function.overdispersion;
    let r = eta * eta / (1.0 - eta * eta);
    counts
        .iter()
        .map(|count| {
            let p = function.probability(count.level, config);
            let mut k = 0;
            for i in 0..count.n {
                let share = (p + r * f64::from(k)) / (1.0 + r * f64::from(i));
                k += u32::from(rng.random::<f64>() < share);
            }
            Count { k, ..*count }
        })
        .collect()
}

/// The shares of right answers themselves, as the most flexible function there is: answers drawn again at each level.
pub(super) fn resampled(counts: &[Count], rng: &mut impl rand::RngExt) -> Vec<Count> {
    counts
        .iter()
        .map(|count| {
            let share = f64::from(count.k) / f64::from(count.n.max(1));
            let k = (0..count.n).filter(|_| rng.random::<f64>() < share).count();
            Count { k: u32::try_from(k).unwrap_or(count.n), ..*count }
        })
        .collect()
}

/// The counts by level, for what is judged level by level.
pub(super) fn by_level(counts: &[Count]) -> Vec<Count> {
    let mut sorted: Vec<Count> = counts.iter().copied().filter(|count| count.n > 0).collect();
    sorted.sort_by(|a, b| a.level.total_cmp(&b.level));
    merged(&sorted)
}
