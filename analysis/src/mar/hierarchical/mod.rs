//! The joint fit of several observers: each has their own MAR line, and all come from one population.
//!
//! ln m, ln omega0 and ln width of an observer are normal in the population, *independently of each other* (no population
//! correlations are estimated); each observer's lapse rate has the *fixed* prior Beta(a, b) of the configuration, whose
//! shapes are not estimated. Observers with little data are drawn towards the group and observers with much data are not;
//! the group's numbers carry both what single observers leave open and how much observers differ. Fits of one observer are
//! in the parent module; Markov chains and their diagnosis in the files beside this one.
//!
//! # Small groups
//!
//! With few observers the SD between them is hardly known, and the interval of a group mean must be wide like Student's t.
//! The SDs' priors are half-t with few degrees of freedom (Gelman 2006), which neither forbid SDs near 0 nor large ones;
//! the chains integrate over them. Coverage with 4 and 12 observers is in `CALIBRATION.md`. With one observer the group's
//! interval is as wide as these priors make it, and a warning says so.

mod config;
mod diagnostics;
pub(super) mod sampler;

pub(super) use config::check;
pub use config::{HierarchicalConfig, HierarchicalError, PopulationPriors};
pub use diagnostics::Diagnostics;
pub(super) use diagnostics::r_hat_and_ess;

use super::data::Data;
use super::posterior::Posterior;
use super::{Estimate, MarTrial, Unpooled};
use crate::numerics::{quantile_of_sorted, sorted_finite};
use config::single_config;
use experiments::mar::MarModel;
use nalgebra::{SVector, Vector4};
use rayon::prelude::*;
use sampler::{Chain, Length, Observer, Population};
use serde::{Deserialize, Serialize};

/// One observer's trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObserverTrials {
    /// Who; unique in a group.
    pub id: String,
    /// The answers.
    pub trials: Vec<MarTrial>,
    /// What this observer's display could show, as in [`super::MarFitConfig::finest_mar`]; empty: no limit is known.
    pub finest_mar: Vec<(f64, f64)>,
}

/// What the group says of one parameter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GroupEstimate {
    /// The population median, in the parameter's own unit (half of all observers are below).
    pub median: Estimate,
    /// SD between observers, of the natural logarithm.
    pub sd_ln: Estimate,
    /// A new observer of this population: median and 95 % prediction interval.
    pub new_observer: Estimate,
}

/// One observer's parameter, alone and in the group.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Shrunken {
    /// From the observer's own trials, under the wide priors of a single fit.
    pub alone: Estimate,
    /// In the group.
    pub pooled: Estimate,
    /// The group's share of the pooled estimate, 0–1: the posterior mean of s²/(s² + SD²), s² the variance with which the
    /// observer's own trials give the logarithm. 0: the group adds nothing; 1: the observer's trials say nothing.
    pub shrinkage: f64,
}

/// One observer within a hierarchical fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObserverEstimate {
    /// Who.
    pub id: String,
    /// All trials given.
    pub trials: usize,
    /// Trials at or below what the display could show, left out of the likelihood.
    pub trials_not_shown: usize,
    /// MAR slope.
    pub m: Shrunken,
    /// MAR at the fovea, degrees per cycle.
    pub omega0: Shrunken,
    /// Width of the psychometric function in ln omega.
    pub width: Shrunken,
    /// Lapse rate, in the group's fit.
    pub lapse: Estimate,
}

/// One posterior draw of the population.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PopulationDraw {
    /// Population median of m.
    pub m: f64,
    /// Population median of omega0, degrees per cycle.
    pub omega0_deg: f64,
    /// Population median of the width.
    pub width: f64,
    /// SDs between observers of ln m, ln omega0, ln width.
    pub sd_ln: [f64; 3],
}

/// A fitted population of observers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HierarchicalFit {
    /// MAR slope.
    pub m: GroupEstimate,
    /// MAR at the fovea, degrees per cycle.
    pub omega0: GroupEstimate,
    /// Width of the psychometric function in ln omega.
    pub width: GroupEstimate,
    /// The observers, as given.
    pub observers: Vec<ObserverEstimate>,
    /// What a reader should know beside the numbers.
    pub warnings: Vec<String>,
    /// Whether the chains agree.
    pub diagnostics: Diagnostics,
    /// Draws of the population, for bands and derived quantities.
    pub posterior: Vec<PopulationDraw>,
    /// The configuration that made this fit.
    pub config: HierarchicalConfig,
}

impl HierarchicalFit {
    /// The line of the population's median observer at an eccentricity: median and 95 % interval, degrees per cycle.
    #[must_use]
    pub fn line_at(&self, eccentricity_deg: f64) -> Estimate {
        estimate(self.posterior.iter().map(|draw| draw.m * eccentricity_deg + draw.omega0_deg))
    }
}

/// Draws kept with a result.
const KEPT_DRAWS: usize = 1000;

/// Fit a population of observers.
///
/// # Errors
/// [`HierarchicalError`]: no observers, an id twice, trials or a configuration that are out of range.
///
/// ```
/// use analysis::mar::{MarTrial, hierarchical::{HierarchicalConfig, ObserverTrials, fit_hierarchical}};
/// let observers: Vec<ObserverTrials> = (0..3)
///     .map(|who| ObserverTrials {
///         id: format!("P{who:02}"),
///         trials: (0..120)
///             .map(|i| {
///                 let eccentricity_deg = f64::from(5 + 5 * (i % 3));
///                 let mar_deg = (0.022 * eccentricity_deg + 0.021) * 0.4 * 1.3f64.powi(i / 3 % 8);
///                 MarTrial { eccentricity_deg, mar_deg, correct: i / 3 % 8 >= 3 + who % 2 || i / 24 % 2 == 0 }
///             })
///             .collect(),
///         finest_mar: Vec::new(),
///     })
///     .collect();
/// let fit = fit_hierarchical(&observers, &HierarchicalConfig { draws: 200, ..HierarchicalConfig::default() })?;
/// assert!(fit.m.new_observer.ci95[1] > fit.m.median.ci95[1]);
/// # Ok::<(), analysis::mar::hierarchical::HierarchicalError>(())
/// ```
pub fn fit_hierarchical(
    observers: &[ObserverTrials],
    config: &HierarchicalConfig,
) -> Result<HierarchicalFit, HierarchicalError> {
    check(observers, config)?;
    let alone = alone(observers, config)?;

    // The chains' targets: the same likelihood, with the population in place of the priors.
    let single = single_config(config, &[], 0);
    let targets: Vec<Observer<'_>> =
        alone.iter().map(|(data, _)| Observer { conditions: vec![(Posterior::new(data, &single), 0.0)] }).collect();
    let starts: Vec<Vector4<f64>> = alone.iter().map(|(_, unpooled)| unpooled.start).collect();
    let priors = [config.priors.m, config.priors.omega0, config.priors.width];
    let population = Population {
        center: Vector4::from_fn(|axis, _| priors.get(axis).map_or(0.0, |prior| prior.median.ln())),
        spread: Vector4::from_fn(|axis, _| priors.get(axis).map_or(1.0, |prior| prior.sd_ln)),
        sd_scale: Vector4::from_fn(|axis, _| config.priors.sd_scale.get(axis).copied().unwrap_or(1.0)),
        sd_df: config.priors.sd_df,
    };
    let (chains, diagnostics) = settled_chains(&targets, &population, &starts, config, config.seed);

    let group = |axis: usize| group_estimate(&chains, axis, config.seed);
    let mut fit = HierarchicalFit {
        m: group(0),
        omega0: group(1),
        width: group(2),
        observers: observers
            .iter()
            .zip(&alone)
            .enumerate()
            .map(|(index, (given, (data, unpooled)))| {
                let shrunken = |axis: usize, alone: Estimate, precision: f64| Shrunken {
                    alone,
                    pooled: estimate(draws(&chains).map(|(chain, i)| chain.observers[i][index][axis].exp())),
                    shrinkage: share(
                        draws(&chains).map(|(chain, i)| 1.0 / (1.0 + precision * chain.sd[i][axis].powi(2))),
                    ),
                };
                let target = &targets[index].conditions[0].0;
                ObserverEstimate {
                    id: given.id.clone(),
                    trials: given.trials.len(),
                    trials_not_shown: data.not_shown,
                    m: shrunken(0, unpooled.m, unpooled.precision(0, &single.priors)),
                    omega0: shrunken(1, unpooled.omega0, unpooled.precision(1, &single.priors)),
                    width: shrunken(2, unpooled.width, unpooled.precision(2, &single.priors)),
                    lapse: estimate(draws(&chains).map(|(chain, i)| target.lapse(chain.observers[i][index][3]))),
                }
            })
            .collect(),
        warnings: Vec::new(),
        diagnostics,
        posterior: kept(&chains),
        config: config.clone(),
    };
    fit.warnings = warnings(&fit);
    Ok(fit)
}

/// Chains that have not settled are run again, this much longer.
const LONGER: usize = 4;

/// Run the chains, and once more and longer if they do not agree.
pub(super) fn settled_chains<const D: usize>(
    observers: &[Observer<'_>],
    population: &Population<D>,
    starts: &[SVector<f64, D>],
    config: &HierarchicalConfig,
    seed: u64,
) -> (Vec<Chain<D>>, Diagnostics) {
    let run = |times: usize| {
        let length = Length { warmup: config.warmup * times, draws: config.draws * times };
        let chains: Vec<Chain<D>> = (0..config.chains)
            .into_par_iter()
            .map(|index| sampler::run_chain(observers, population, starts, length, seed, index))
            .collect();
        let diagnostics = diagnose(&chains);
        (chains, diagnostics)
    };
    let (chains, diagnostics) = run(1);
    if diagnostics.settled() { (chains, diagnostics) } else { run(LONGER) }
}

/// Each observer's data and own fit, in parallel.
fn alone(
    observers: &[ObserverTrials],
    config: &HierarchicalConfig,
) -> Result<Vec<(Data, Unpooled)>, HierarchicalError> {
    observers
        .par_iter()
        .enumerate()
        .map(|(index, observer)| {
            let single = single_config(config, &observer.finest_mar, index as u64);
            let failed = |source| HierarchicalError::Observer { id: observer.id.clone(), source };
            let data = Data::new(&observer.trials, &single).map_err(failed)?;
            let unpooled = super::unpooled(&data, &single);
            Ok((data, unpooled))
        })
        .collect()
}

/// Median and 95 % interval of draws.
pub(super) fn estimate(values: impl IntoIterator<Item = f64>) -> Estimate {
    let sorted = sorted_finite(values);
    let at = |q| quantile_of_sorted(&sorted, q).unwrap_or(0.0);
    Estimate { estimate: at(0.5), ci95: [at(0.025), at(0.975)] }
}

fn share(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0.0), |(sum, n), value| (sum + value, n + 1.0));
    if n > 0.0 { (sum / n).clamp(0.0, 1.0) } else { 1.0 }
}

/// All (chain, draw) pairs in order.
pub(super) fn draws<const D: usize>(chains: &[Chain<D>]) -> impl Iterator<Item = (&Chain<D>, usize)> {
    chains.iter().flat_map(|chain| (0..chain.mean.len()).map(move |draw| (chain, draw)))
}

pub(super) fn group_estimate<const D: usize>(chains: &[Chain<D>], axis: usize, seed: u64) -> GroupEstimate {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed ^ 0x0be5_e47e);
    rng.set_stream(axis as u64);
    GroupEstimate {
        median: estimate(draws(chains).map(|(chain, i)| chain.mean[i][axis].exp())),
        sd_ln: estimate(draws(chains).map(|(chain, i)| chain.sd[i][axis])),
        new_observer: estimate(draws(chains).map(|(chain, i)| {
            let normal = crate::numerics::normal_quantile(rng.random::<f64>().clamp(1e-12, 1.0 - 1e-12));
            (chain.mean[i][axis] + chain.sd[i][axis] * normal).exp()
        })),
    }
}

fn diagnose<const D: usize>(chains: &[Chain<D>]) -> Diagnostics {
    let (mut max_r_hat, mut least_ess) = (1.0f64, f64::INFINITY);
    for axis in 0..D - 1 {
        let means: Vec<Vec<f64>> = chains.iter().map(|c| c.mean.iter().map(|v| v[axis]).collect()).collect();
        let sds: Vec<Vec<f64>> = chains.iter().map(|c| c.sd.iter().map(|v| v[axis]).collect()).collect();
        for quantity in [means, sds] {
            let (r_hat, ess) = r_hat_and_ess(&quantity);
            max_r_hat = max_r_hat.max(r_hat);
            least_ess = least_ess.min(ess);
        }
    }
    Diagnostics { max_r_hat, least_ess, draws: chains.iter().map(|c| c.mean.len()).sum() }
}

fn kept(chains: &[Chain<4>]) -> Vec<PopulationDraw> {
    let total: usize = chains.iter().map(|chain| chain.mean.len()).sum();
    let every = total.div_ceil(KEPT_DRAWS).max(1);
    draws(chains)
        .step_by(every)
        .map(|(chain, i)| {
            let (mean, sd) = (&chain.mean[i], &chain.sd[i]);
            PopulationDraw {
                m: mean[0].exp(),
                omega0_deg: mean[1].exp(),
                width: mean[2].exp(),
                sd_ln: [sd[0], sd[1], sd[2]],
            }
        })
        .collect()
}

fn warnings(fit: &HierarchicalFit) -> Vec<String> {
    let mut warnings = Vec::new();
    match fit.observers.len() {
        1 => warnings.push(
            "One observer does not say how observers differ: the population's intervals are those of its priors around \
             this observer."
                .to_owned(),
        ),
        n @ 2..=4 => warnings.push(format!(
            "With {n} observers the priors of the differences between observers weigh on the population's intervals."
        )),
        _ => {}
    }
    for observer in &fit.observers {
        if observer.m.shrinkage > 0.9 {
            warnings.push(format!(
                "{}'s slope is the group's ({:.0} %): the trials of this observer say little of it.",
                observer.id,
                100.0 * observer.m.shrinkage
            ));
        }
    }
    if !fit.diagnostics.settled() {
        warnings.push(format!(
            "The chains have not settled (R-hat {:.2}, {:.0} effective draws): raise draws before using the numbers.",
            fit.diagnostics.max_r_hat, fit.diagnostics.least_ess
        ));
    }
    warnings
}

/// The model of a population's median observer with no lapses, for figures.
impl From<&PopulationDraw> for MarModel {
    fn from(draw: &PopulationDraw) -> Self {
        Self { m: draw.m, omega0_deg: draw.omega0_deg, width: draw.width, lapse: 0.0 }
    }
}
