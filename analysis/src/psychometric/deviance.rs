//! How far a function is from the shares of right answers themselves, and whether chance would explain it.

use super::ml::{Surface, by_level, simulated};
use super::{Count, Psychometric, PsychometricConfig, PsychometricError};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Deviance with its simulated p.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GoodnessOfFit {
    /// Deviance of the maximum-likelihood function.
    pub deviance: f64,
    /// Share of simulated data sets, answered by that function and fitted again, whose deviance is at least as large; the
    /// data themselves are counted among them.
    pub p: f64,
    /// Simulated data sets.
    pub simulations: usize,
    /// The signed square root of each level's part, ascending in level: positive where more were right than fitted.
    pub residuals: Vec<(f64, f64)>,
    /// The seed of the simulation.
    pub seed: u64,
}

/// The deviance of a function: `2 Σ k ln(k/nψ) + (n − k) ln((n − k)/(n − nψ))` over levels (Wichmann and Hill 2001, Eq. 7).
///
/// Rows of the same level are taken together. Infinite if an answer was given that the function rules out.
#[must_use]
pub fn deviance(counts: &[Count], function: &Psychometric, config: &PsychometricConfig) -> f64 {
    residuals(counts, function, config).iter().map(|(_, residual)| residual * residual).sum()
}

fn residuals(counts: &[Count], function: &Psychometric, config: &PsychometricConfig) -> Vec<(f64, f64)> {
    by_level(counts)
        .iter()
        .map(|count| {
            let p = function.probability(count.level, config);
            let [n, k] = [count.n, count.k].map(f64::from);
            let term = |count: f64, expected: f64| if count > 0.0 { count * (count / expected).ln() } else { 0.0 };
            let part = 2.0 * (term(k, n * p) + term(n - k, n * (1.0 - p)));
            (count.level, part.max(0.0).sqrt().copysign(k - n * p))
        })
        .collect()
}

/// Deviance of the maximum-likelihood function, with a p from `simulations` data sets.
///
/// Few answers a level make the χ² approximation wrong, which is why it is simulated (Wichmann and Hill 2001, §3). Data
/// sets are simulated in parallel, each with its own stream of the seed, so that the result does not depend on threads.
///
/// # Errors
/// As [`super::likelihood_fit`].
pub fn goodness_of_fit(
    counts: &[Count],
    config: &PsychometricConfig,
    simulations: usize,
    seed: u64,
) -> Result<GoodnessOfFit, PsychometricError> {
    let surface = Surface::new(counts, config)?;
    let (top, _) = surface.highest();
    let function = surface.function(&top);
    let observed = deviance(&surface.data.counts, &function, config);
    let larger = (0..simulations as u64)
        .into_par_iter()
        .filter(|&index| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(index);
            let answers = simulated(&surface.data.counts, &function, config, &mut rng);
            // The same levels as before: it can be fitted as they could.
            let Ok(again) = Surface::new(&answers, config) else { return false };
            // The answers come from the function at the top, beside which theirs must be.
            let (best, _) = again.climb(&top);
            deviance(&answers, &again.function(&best), config) >= observed
        })
        .count();
    Ok(GoodnessOfFit {
        deviance: observed,
        p: (larger + 1) as f64 / (simulations + 1) as f64,
        simulations,
        residuals: residuals(&surface.data.counts, &function, config),
        seed,
    })
}
