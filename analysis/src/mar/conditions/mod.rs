//! Two or more conditions, say renderers, seen by the same observers: do their MAR lines differ, and by how much?
//!
//! Three answers beside each other. *Likelihood ratios* (no priors) of sharing m, omega0, width or all three against one
//! value per condition, with the lapse rate shared; over several observers they are summed, every observer with their own
//! lines, so that they ask whether anybody differs and not whether the population does. *Contrasts* of each observer: the
//! posterior of the ratio and the difference against the first condition, from a joint fit of each condition with its own
//! lapse rate. *Paired contrasts* of the population: a hierarchical fit in which an observer's ln m, ln omega0 and ln width in two
//! conditions are the observer's own mean −½ and +½ of the observer's own difference, both normal over observers.

mod paired;
mod shared;

pub use paired::PairedContrast;
pub use shared::{Parameter, SharedTest};

use super::data::{Data, FitError};
use super::hierarchical::{HierarchicalConfig, HierarchicalError, ObserverTrials, estimate};
use super::{Estimate, MarFit, MarFitConfig, MarPriors, fit_mar};
use experiments::mar::MarModel;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// One condition and who saw it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// Its name, unique among those compared.
    pub name: String,
    /// Observers by id; the same id in two conditions is the same observer.
    pub observers: Vec<ObserverTrials>,
}

/// How conditions are compared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConditionsConfig {
    /// Guess rate, population priors, seed and chains; [`HierarchicalConfig::seed`] also seeds the single fits.
    pub hierarchical: HierarchicalConfig,
    /// SD of the normal prior of the population's mean difference of ln m, ln omega0 and ln width, around 0.
    pub difference_spread: [f64; 3],
    /// Scales of the half-t priors of the SDs of these differences between observers.
    pub difference_sd_scale: [f64; 3],
}

impl Default for ConditionsConfig {
    /// Differences up to a factor of 7 either way (SD 1 of the logarithm), SDs between observers half-t of scale 0.2.
    fn default() -> Self {
        Self { hierarchical: HierarchicalConfig::default(), difference_spread: [1.0; 3], difference_sd_scale: [0.2; 3] }
    }
}

/// Why conditions were not compared.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ConditionsError {
    /// Nothing to compare.
    #[error("comparing needs at least 2 conditions, found {found}")]
    TooFew {
        /// Conditions given.
        found: usize,
    },
    /// The same name twice.
    #[error("condition {name} is given twice")]
    Repeated {
        /// The name.
        name: String,
    },
    /// A condition without observers, or an observer twice in it, or trials or configuration at fault.
    #[error("condition {name}: {source}")]
    Condition {
        /// Which.
        name: String,
        /// What.
        source: HierarchicalError,
    },
    /// The configuration is impossible.
    #[error("comparing conditions: {field} must be {expected}, found {found}")]
    BadConfig {
        /// The field at fault.
        field: &'static str,
        /// What would have been accepted.
        expected: &'static str,
        /// What was there.
        found: f64,
    },
}

/// A parameter in one condition against another: posterior medians and 95 % intervals.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Condition over reference.
    pub ratio: Estimate,
    /// Condition less reference, in the parameter's own unit.
    pub difference: Estimate,
    /// Posterior probability that the condition's value is the larger.
    pub probability_larger: f64,
}

/// One observer's lines in two conditions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contrast {
    /// The condition.
    pub condition: String,
    /// What it is held against: the first condition.
    pub reference: String,
    /// MAR slopes.
    pub m: Change,
    /// MARs at the fovea.
    pub omega0: Change,
    /// Widths.
    pub width: Change,
}

/// What one observer's conditions say.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObserverComparison {
    /// Who.
    pub id: String,
    /// Conditions that this observer saw, in the order given.
    pub conditions: Vec<String>,
    /// Shared against separate parameters: all, m, omega0, width. Empty if the observer saw one condition only.
    pub tests: Vec<SharedTest>,
    /// Against the first condition, where the observer saw it.
    pub contrasts: Vec<Contrast>,
}

/// Conditions compared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConditionComparison {
    /// Observers that appear in any condition, in order of appearance.
    pub observers: Vec<ObserverComparison>,
    /// The likelihood ratios summed over observers; empty if nobody saw two conditions.
    pub tests: Vec<SharedTest>,
    /// The population's change from the first condition to each other; empty with one observer.
    pub paired: Vec<PairedContrast>,
    /// What a reader should know beside the numbers.
    pub warnings: Vec<String>,
    /// The configuration.
    pub config: ConditionsConfig,
}

/// One observer's part in one condition.
struct Seen<'a> {
    /// Index of the condition.
    condition: usize,
    given: &'a ObserverTrials,
    data: Data,
}

/// Compare conditions; the first is the reference.
///
/// # Errors
/// [`ConditionsError`]: fewer than two conditions, names or ids twice, trials or a configuration out of range.
///
/// ```
/// use analysis::mar::{MarTrial, conditions::{Condition, ConditionsConfig, compare_conditions}, hierarchical::ObserverTrials};
/// let condition = |name: &str, m: f64| Condition {
///     name: name.to_owned(),
///     observers: vec![ObserverTrials {
///         id: "P01".to_owned(),
///         trials: (0..480)
///             .map(|i| {
///                 let eccentricity_deg = f64::from(5 * (i % 4));
///                 let mar_deg = (m * eccentricity_deg + 0.021) * 0.4 * 1.3f64.powi(i / 4 % 8);
///                 MarTrial { eccentricity_deg, mar_deg, correct: i / 4 % 8 >= 4 || i / 32 % 2 == 0 }
///             })
///             .collect(),
///         finest_mar: Vec::new(),
///     }],
/// };
/// let comparison =
///     compare_conditions(&[condition("reference", 0.022), condition("layers", 0.033)], &ConditionsConfig::default())?;
/// let ratio = comparison.observers[0].contrasts[0].m.ratio;
/// assert!(ratio.ci95[0] < 1.5 && 1.5 < ratio.ci95[1] && ratio.ci95[0] > 1.0);
/// # Ok::<(), analysis::mar::conditions::ConditionsError>(())
/// ```
pub fn compare_conditions(
    conditions: &[Condition],
    config: &ConditionsConfig,
) -> Result<ConditionComparison, ConditionsError> {
    check(conditions, config)?;
    let seen = by_observer(conditions, config)?;
    let guess = config.hierarchical.guess;

    let observers: Vec<ObserverComparison> = seen
        .par_iter()
        .enumerate()
        .map(|(index, (id, parts))| {
            let groups: Vec<&Data> = parts.iter().map(|part| &part.data).collect();
            let tests = if parts.len() > 1 { shared::shared_tests(&groups, guess) } else { Vec::new() };
            let seed = config.hierarchical.seed.wrapping_add(index as u64);
            let contrasts = contrasts(conditions, parts, config, seed).map_err(|(condition, source)| {
                named(conditions, condition, HierarchicalError::Observer { id: id.clone(), source })
            })?;
            Ok(ObserverComparison {
                id: id.clone(),
                conditions: parts.iter().map(|part| conditions[part.condition].name.clone()).collect(),
                tests,
                contrasts,
            })
        })
        .collect::<Result<_, ConditionsError>>()?;

    let trials = seen
        .iter()
        .filter(|(_, parts)| parts.len() > 1)
        .flat_map(|(_, parts)| parts)
        .map(|part| part.given.trials.len() - part.data.not_shown)
        .sum();
    let own: Vec<Vec<SharedTest>> = observers.iter().map(|o| o.tests.clone()).filter(|t| !t.is_empty()).collect();
    // Observers of unequal numbers of conditions are summed all the same: each adds its own df.
    let tests = shared::summed(&own, trials);
    let paired: Vec<PairedContrast> = if seen.len() > 1 {
        (1..conditions.len()).filter_map(|index| paired::paired(conditions, index, &seen, config)).collect()
    } else {
        Vec::new()
    };
    let mut warnings = Vec::new();
    if paired.is_empty() {
        warnings.push("One observer: the contrasts are this observer's and say nothing of others.".to_owned());
    }
    for contrast in &paired {
        if contrast.observers_in_both < 2 {
            warnings.push(format!(
                "Fewer than two observers saw both {} and {}: their difference mixes conditions with observers.",
                contrast.reference, contrast.condition
            ));
        }
    }
    Ok(ConditionComparison { observers, tests, paired, warnings, config: config.clone() })
}

fn named(conditions: &[Condition], index: usize, source: HierarchicalError) -> ConditionsError {
    let name = conditions.get(index).map(|condition| condition.name.clone()).unwrap_or_default();
    ConditionsError::Condition { name, source }
}

fn check(conditions: &[Condition], config: &ConditionsConfig) -> Result<(), ConditionsError> {
    if conditions.len() < 2 {
        return Err(ConditionsError::TooFew { found: conditions.len() });
    }
    for (index, condition) in conditions.iter().enumerate() {
        if conditions[..index].iter().any(|before| before.name == condition.name) {
            return Err(ConditionsError::Repeated { name: condition.name.clone() });
        }
        super::hierarchical::check(&condition.observers, &config.hierarchical)
            .map_err(|source| named(conditions, index, source))?;
    }
    for (field, values, range) in [
        ("difference_spread", &config.difference_spread, 1e-3..=20.0),
        ("difference_sd_scale", &config.difference_sd_scale, 1e-4..=10.0),
    ] {
        for &found in values {
            if !range.contains(&found) {
                return Err(ConditionsError::BadConfig { field, expected: "above 0 and at most 10", found });
            }
        }
    }
    Ok(())
}

/// (id, what they saw in the order of conditions), in order of appearance.
type ByObserver<'a> = Vec<(String, Vec<Seen<'a>>)>;

fn by_observer<'a>(conditions: &'a [Condition], config: &ConditionsConfig) -> Result<ByObserver<'a>, ConditionsError> {
    let mut seen: ByObserver<'a> = Vec::new();
    for (index, condition) in conditions.iter().enumerate() {
        for given in &condition.observers {
            let single = single_config(config, given, 0);
            let data = Data::new(&given.trials, &single).map_err(|source| {
                named(conditions, index, HierarchicalError::Observer { id: given.id.clone(), source })
            })?;
            let part = Seen { condition: index, given, data };
            match seen.iter_mut().find(|(id, _)| *id == given.id) {
                Some((_, parts)) => parts.push(part),
                None => seen.push((given.id.clone(), vec![part])),
            }
        }
    }
    Ok(seen)
}

fn single_config(config: &ConditionsConfig, given: &ObserverTrials, seed: u64) -> MarFitConfig {
    let priors = &config.hierarchical.priors;
    MarFitConfig {
        guess: config.hierarchical.guess,
        priors: MarPriors { m: priors.m, omega0: priors.omega0, width: priors.width, lapse_beta: priors.lapse_beta },
        finest_mar: given.finest_mar.clone(),
        seed,
        ..MarFitConfig::default()
    }
}

/// One observer's conditions against the first, if the observer saw it.
fn contrasts(
    conditions: &[Condition],
    parts: &[Seen<'_>],
    config: &ConditionsConfig,
    seed: u64,
) -> Result<Vec<Contrast>, (usize, FitError)> {
    if parts.first().is_none_or(|part| part.condition != 0) {
        return Ok(Vec::new());
    }
    let fits: Vec<MarFit> = parts
        .iter()
        .map(|part| {
            fit_mar(
                &part.given.trials,
                &single_config(config, part.given, seed.wrapping_mul(31) + part.condition as u64),
            )
            .map_err(|error| (part.condition, error))
        })
        .collect::<Result<_, _>>()?;
    let Some((reference, others)) = fits.split_first() else { return Ok(Vec::new()) };
    Ok(others
        .iter()
        .zip(&parts[1..])
        .map(|(fit, part)| Contrast {
            condition: conditions[part.condition].name.clone(),
            reference: conditions[0].name.clone(),
            m: change(fit, reference, seed, |p| p.m),
            omega0: change(fit, reference, seed, |p| p.omega0_deg),
            width: change(fit, reference, seed, |p| p.width),
        })
        .collect())
}

/// How often each posterior draw is paired with one of the other fit.
const PAIRINGS: usize = 16;

/// The two posteriors are independent; their draws are paired at random, several times, since they come in the order of
/// the integration's rounds.
fn change(fit: &MarFit, reference: &MarFit, seed: u64, value: fn(&MarModel) -> f64) -> Change {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x0c04_d171);
    let mut pairs = Vec::with_capacity(fit.posterior.len() * PAIRINGS);
    let mut order: Vec<usize> = (0..reference.posterior.len()).collect();
    for _ in 0..PAIRINGS {
        for i in (1..order.len()).rev() {
            order.swap(i, rng.random_range(0..=i));
        }
        pairs.extend(fit.posterior.iter().zip(&order).map(|(a, &b)| (value(a), value(&reference.posterior[b]))));
    }
    change_of_pairs(&pairs)
}

fn change_of_pairs(pairs: &[(f64, f64)]) -> Change {
    let larger = pairs.iter().filter(|(a, b)| a > b).count();
    Change {
        ratio: estimate(pairs.iter().map(|(a, b)| (a.ln() - b.ln()).exp())),
        difference: estimate(pairs.iter().map(|(a, b)| a - b)),
        probability_larger: larger as f64 / pairs.len().max(1) as f64,
    }
}
