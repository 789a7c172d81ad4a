//! Bootstrap intervals of a maximum-likelihood fit: what the estimates would have been with other answers.

use super::ml::{Surface, resampled, simulated};
use super::{Count, Psychometric, PsychometricConfig, PsychometricError};
use crate::numerics::{quantile_of_sorted, sorted_finite};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Where the other answers come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Resampling {
    /// From the fitted function.
    Parametric,
    /// From the shares of right answers at each level.
    NonParametric,
}

/// How a bootstrap is made.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BootstrapConfig {
    /// Where answers come from.
    pub resampling: Resampling,
    /// Data sets.
    pub samples: usize,
    /// Seed; each data set has its own stream of it.
    pub seed: u64,
}

impl Default for BootstrapConfig {
    fn default() -> Self {
        Self { resampling: Resampling::Parametric, samples: 2000, seed: 0 }
    }
}

/// The estimates from other answers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Bootstrap {
    /// The estimate from the data.
    pub estimate: Psychometric,
    /// The estimate from each simulated data set.
    pub samples: Vec<Psychometric>,
    /// How the bootstrap was made.
    pub config: BootstrapConfig,
    /// How functions were fitted.
    pub fit: PsychometricConfig,
    /// The data, ascending in level.
    pub counts: Vec<Count>,
}

impl Bootstrap {
    /// The percentile interval of a quantity at a confidence such as 0.95; data sets in which it is undefined are left out.
    /// Nothing if it is undefined in more than a tenth of them.
    #[must_use]
    pub fn interval(&self, quantity: impl Fn(&Psychometric) -> Option<f64>, confidence: f64) -> Option<[f64; 2]> {
        let values = sorted_finite(self.samples.iter().filter_map(quantity));
        if values.len() * 10 < self.samples.len() * 9 {
            return None;
        }
        let tail = 0.5 * (1.0 - confidence);
        Some([quantile_of_sorted(&values, tail)?, quantile_of_sorted(&values, 1.0 - tail)?])
    }

    /// The standard error of a quantity, as the standard deviation over data sets.
    #[must_use]
    pub fn standard_error(&self, quantity: impl Fn(&Psychometric) -> Option<f64>) -> Option<f64> {
        let values = sorted_finite(self.samples.iter().filter_map(quantity));
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        (values.len() > 1).then(|| (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt())
    }
}

/// Fits the data, then simulated data sets at the same levels with the same numbers of answers.
///
/// # Errors
/// As [`super::likelihood_fit`].
pub fn bootstrap(
    counts: &[Count],
    fit: &PsychometricConfig,
    config: &BootstrapConfig,
) -> Result<Bootstrap, PsychometricError> {
    let surface = Surface::new(counts, fit)?;
    let (top, _) = surface.highest();
    let estimate = surface.function(&top);
    let samples = (0..config.samples as u64)
        .into_par_iter()
        .map(|index| {
            let mut rng = ChaCha8Rng::seed_from_u64(config.seed);
            rng.set_stream(index);
            let answers = match config.resampling {
                Resampling::Parametric => simulated(&surface.data.counts, &estimate, fit, &mut rng),
                Resampling::NonParametric => resampled(&surface.data.counts, &mut rng),
            };
            let again = Surface::new(&answers, fit)?;
            Ok(again.function(&again.climb(&top).0))
        })
        .collect::<Result<Vec<_>, PsychometricError>>()?;
    Ok(Bootstrap { estimate, samples, config: *config, fit: *fit, counts: surface.data.counts })
}
