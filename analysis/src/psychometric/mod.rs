//! One psychometric function on one variable: the share of right answers by level, and its threshold with an interval.
//!
//! `ψ(x) = γ + (1 − γ − λ) S((x − threshold)/width)`, with one of several shapes S, on a linear or a logarithmic axis, rising
//! or falling with the level. The threshold is where S is one half; the width spans 5 % to 95 % of S. Parametrisation, priors
//! and overdispersion are psignifit's (Schütt, Harmeling, Macke and Wichmann 2016), and all of them can be changed.
//!
//! - [`fit_psychometric`] integrates the posterior and sums it up; [`PsychometricPosterior`] gives everything that follows
//!   from it: marginals, thresholds and slopes at any share of right answers, bands, draws;
//! - [`likelihood_fit`] is maximum likelihood with profile intervals, AIC and BIC; [`bootstrap()`] its bootstrap;
//! - [`compare`] tests which parameters several data sets share;
//! - [`goodness_of_fit`] is the deviance with a simulated p.
//!
//! The joint fit of a line over eccentricities is [`crate::mar`].

mod axis;
mod bootstrap;
mod config;
mod data;
mod deviance;
mod function;
mod joint;
mod likelihood;
mod marginal;
mod maximum;
mod ml;
mod posterior;
mod prior;
mod quadrature;
mod sharing;
mod sigmoid;
mod support;

pub use axis::{Direction, Scale};
pub use bootstrap::{Bootstrap, BootstrapConfig, Resampling, bootstrap};
pub use config::{Guess, Lapse, Overdispersion, PsychometricConfig};
pub use data::{Count, PsychometricError};
pub use deviance::{GoodnessOfFit, deviance, goodness_of_fit};
pub use function::Psychometric;
pub use joint::PsychometricPosterior;
pub use marginal::Marginal;
pub use ml::{LikelihoodFit, Profile, likelihood_fit};
pub use prior::{Prior, Priors};
pub use sharing::{Comparison, Hypothesis, Parameter, compare};
pub use sigmoid::Sigmoid;

use crate::mar::{Estimate, Support};
use serde::{Deserialize, Serialize};

/// A fitted function: the summary of its posterior.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PsychometricFit {
    /// The threshold: posterior median and 95 % interval.
    pub threshold: Estimate,
    /// The width.
    pub width: Estimate,
    /// The lapse rate; a fixed rate is its own interval.
    pub lapse: Estimate,
    /// The guess rate.
    pub guess: Estimate,
    /// Overdispersion η.
    #[serde(default = "independent")]
    pub overdispersion: Estimate,
    /// The mode of the posterior density.
    pub map: Psychometric,
    /// Posterior means; on a logarithmic axis the threshold's is that of its logarithm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean: Option<Psychometric>,
    /// The deviance of the mode: how far it is from the shares themselves, as twice a log likelihood ratio.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deviance: Option<f64>,
    /// How it was fitted.
    pub config: PsychometricConfig,
    /// The priors as they were used, the standard ones written out for these levels.
    #[serde(default)]
    pub priors: Priors,
    /// The data, ascending in level.
    pub counts: Vec<Count>,
    /// Whether the data carry the fit.
    pub support: Support,
    /// What a reader should know beside the numbers, in plain sentences.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

fn independent() -> Estimate {
    Estimate { estimate: 0.0, ci95: [0.0, 0.0] }
}

impl PsychometricFit {
    /// The probability of a right answer at a level, by the mode.
    #[must_use]
    pub fn probability(&self, level: f64) -> f64 {
        self.map.probability(level, &self.config)
    }

    /// All answers.
    #[must_use]
    pub fn n_trials(&self) -> u64 {
        self.counts.iter().map(|count| u64::from(count.n)).sum()
    }
}

impl PsychometricPosterior {
    /// The summary.
    #[must_use]
    pub fn fit(&self) -> PsychometricFit {
        let estimate = |[low, middle, high]: [f64; 3]| Estimate { estimate: middle, ci95: [low, high] };
        let scale = self.config().scale;
        let mut fit = PsychometricFit {
            threshold: estimate(self.threshold.interval().map(|x| scale.level(x))),
            width: estimate(self.ln_width.interval().map(f64::exp)),
            lapse: estimate(self.lapse.interval()),
            guess: estimate(self.guess.interval()),
            overdispersion: estimate(self.overdispersion.interval()),
            map: self.map(),
            mean: Some(self.mean()),
            deviance: Some(deviance(self.counts(), &self.map(), self.config())),
            config: *self.config(),
            priors: self.priors(),
            counts: self.counts().to_vec(),
            support: Support::Supported,
            warnings: Vec::new(),
        };
        fit.support = support::support(&fit);
        fit.warnings = support::warnings(&fit);
        fit
    }
}

/// Fits one psychometric function to counts.
///
/// The posterior is integrated on a grid over (threshold, ln width, λ, γ, η), as far as they are free, that closes in on
/// where the posterior is.
///
/// # Errors
/// When fewer than two levels have answers and the configuration gives no range, or a count, a rate or a prior is
/// impossible.
///
/// ```
/// use analysis::psychometric::{Count, PsychometricConfig, fit_psychometric};
/// let counts: Vec<Count> = [19, 22, 27, 32, 37, 39, 39]
///     .iter()
///     .zip(1..)
///     .map(|(&k, level)| Count { level: f64::from(level), n: 40, k })
///     .collect();
/// let fit = fit_psychometric(&counts, &PsychometricConfig::TWO_ALTERNATIVES)?;
/// assert!((fit.map.threshold - 3.5482).abs() < 1e-3);
/// # Ok::<(), analysis::psychometric::PsychometricError>(())
/// ```
pub fn fit_psychometric(counts: &[Count], config: &PsychometricConfig) -> Result<PsychometricFit, PsychometricError> {
    PsychometricPosterior::new(counts, config).map(|posterior| posterior.fit())
}
