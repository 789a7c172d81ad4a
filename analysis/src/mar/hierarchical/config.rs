//! How a group is fitted, what can be wrong with it, and the checks.

use super::super::data::{self, FitError};
use super::super::{LogNormal, MarFitConfig, MarPriors};
use super::ObserverTrials;
use serde::{Deserialize, Serialize};

/// Priors of a population of observers, written out with every result.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PopulationPriors {
    /// Prior of the population median of m, and of a single observer's m in the unpooled fits.
    pub m: LogNormal,
    /// The same for omega0, degrees per cycle.
    pub omega0: LogNormal,
    /// The same for the width.
    pub width: LogNormal,
    /// Scales of the half-t priors of the SDs between observers of ln m, ln omega0 and ln width.
    pub sd_scale: [f64; 3],
    /// Degrees of freedom of these half-t priors, at least 1.
    pub sd_df: f64,
    /// Shape parameters of every observer's lapse rate's beta distribution; fixed, not estimated.
    pub lapse_beta: [f64; 2],
}

impl Default for PopulationPriors {
    /// The medians and shapes of [`MarPriors`]; half-t SDs of scale 0.5 with 4 degrees of freedom: half of their mass is below
    /// a factor of 1.45 between observers, and 5 % above a factor of 4. With a scale of 0.3 the intervals of groups of
    /// four, whose SD was 0.25, were too narrow (`CALIBRATION.md`).
    fn default() -> Self {
        let MarPriors { m, omega0, width, lapse_beta } = MarPriors::default();
        Self { m, omega0, width, sd_scale: [0.5; 3], sd_df: 4.0, lapse_beta }
    }
}

/// How a hierarchical fit is made; the same configuration and trials give the same numbers at any number of threads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HierarchicalConfig {
    /// Probability of a correct answer by guessing.
    pub guess: f64,
    /// Priors of the population.
    pub priors: PopulationPriors,
    /// Seed of the chains and of the unpooled fits.
    pub seed: u64,
    /// Markov chains, 2 to 64.
    pub chains: usize,
    /// Iterations of each chain that adapt and are thrown away, at least 50.
    pub warmup: usize,
    /// Iterations of each chain that are kept, at least 100. Chains that do not settle are run once more, four times as long.
    pub draws: usize,
}

impl Default for HierarchicalConfig {
    fn default() -> Self {
        Self { guess: 0.5, priors: PopulationPriors::default(), seed: 0, chains: 4, warmup: 400, draws: 1000 }
    }
}

/// Why there is no hierarchical fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HierarchicalError {
    /// Nothing to fit.
    #[error("no observers: a group needs at least one")]
    NoObservers,
    /// The same id twice.
    #[error("observer {id} is given twice; put the trials of all sittings into one")]
    Repeated {
        /// The id.
        id: String,
    },
    /// An observer's trials are at fault.
    #[error("observer {id}: {source}")]
    Observer {
        /// Who.
        id: String,
        /// What.
        source: FitError,
    },
    /// The configuration is impossible.
    #[error("hierarchical fit: {field} must be {expected}, found {found}")]
    BadConfig {
        /// The field at fault.
        field: &'static str,
        /// What would have been accepted.
        expected: &'static str,
        /// What was there.
        found: f64,
    },
}

/// The configuration of an observer's own fit.
pub(super) fn single_config(config: &HierarchicalConfig, finest_mar: &[(f64, f64)], index: u64) -> MarFitConfig {
    let PopulationPriors { m, omega0, width, lapse_beta, .. } = config.priors;
    MarFitConfig {
        guess: config.guess,
        priors: MarPriors { m, omega0, width, lapse_beta },
        finest_mar: finest_mar.to_vec(),
        seed: config.seed.wrapping_add(index),
        draws: 2048,
    }
}

pub(in super::super) fn check(
    observers: &[ObserverTrials],
    config: &HierarchicalConfig,
) -> Result<(), HierarchicalError> {
    if observers.is_empty() {
        return Err(HierarchicalError::NoObservers);
    }
    for (index, observer) in observers.iter().enumerate() {
        if observers[..index].iter().any(|before| before.id == observer.id) {
            return Err(HierarchicalError::Repeated { id: observer.id.clone() });
        }
    }
    check_lengths(config.chains, config.warmup, config.draws)?;
    check_sd_priors(&config.priors.sd_scale, config.priors.sd_df)?;
    // What the single fits share is checked once, so that the configuration and not an observer is named.
    data::check_config(&single_config(config, &[], 0)).map_err(|error| match error {
        FitError::BadConfig { field, expected, found } => HierarchicalError::BadConfig { field, expected, found },
        source => HierarchicalError::Observer { id: String::new(), source },
    })
}

fn check_lengths(chains: usize, warmup: usize, draws: usize) -> Result<(), HierarchicalError> {
    let bad =
        |field, expected, found: usize| Err(HierarchicalError::BadConfig { field, expected, found: found as f64 });
    if !(2..=64).contains(&chains) {
        return bad("chains", "from 2 to 64", chains);
    }
    if !(50..=1_000_000).contains(&warmup) {
        return bad("warmup", "from 50 to 1 million", warmup);
    }
    if !(100..=1_000_000).contains(&draws) {
        return bad("draws", "from 100 to 1 million", draws);
    }
    Ok(())
}

fn check_sd_priors(scales: &[f64], df: f64) -> Result<(), HierarchicalError> {
    for &scale in scales {
        if !(1e-4..=10.0).contains(&scale) {
            let (field, expected) = ("priors.sd_scale", "scales from 1e-4 to 10");
            return Err(HierarchicalError::BadConfig { field, expected, found: scale });
        }
    }
    if !(1.0..=1e6).contains(&df) {
        let (field, expected) = ("priors.sd_df", "degrees of freedom from 1 to 1e6");
        return Err(HierarchicalError::BadConfig { field, expected, found: df });
    }
    Ok(())
}
