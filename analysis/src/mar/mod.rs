//! The joint fit of the MAR line: m, omega0, width and lapse over all eccentricities at once.
//!
//! Every trial, at whatever eccentricity, enters one binomial likelihood with the model of [`experiments::mar::MarModel`]
//! and weak, proper, serialised priors; the posterior is integrated, not only maximised, so that every number carries an
//! interval. Thresholds of single eccentricities come from a second model that does not assume a line. The adaptive
//! designs that gather the trials live in `experiments`; the pictures of a fit in [`crate::figures`].
//!
//! Beside the fit of one observer: [`hierarchical`] fits groups, [`conditions`] compares conditions, [`linearity`] asks whether
//! the line is one, and [`two_stage`] is the older way, thresholds first and a line after.
//!
//! # What the display could not show
//!
//! A display shows no detail finer than two of its pixels, `finest_mar`. Two consequences:
//!
//! - A trial that asked for a limit at or below `finest_mar` removed nothing that had been on the screen, whatever the
//!   observer's acuity. Its answer is a guess with probability γ under every parameter value, a constant in the
//!   likelihood; so it is left out and counted in [`MarFit::trials_not_shown`]. Read as an ordinary trial, its failures
//!   would pull the threshold up to the display's limit.
//! - Above `finest_mar` the binomial likelihood itself censors. An observer whose threshold is below the limit answers
//!   correctly at every level that was shown; then Φ ≈ 1 in every cell, the likelihood is flat in the threshold from some
//!   value downwards, and what remains is the statement "not above about the limit", which is what a left-censored
//!   observation says. No imputed value enters.
//!
//! Such thresholds are returned as limits ([`Threshold::limited`]), and an intercept below everything that the display
//! could show is flagged as extrapolated ([`MarFit::display_limited`]).

pub mod conditions;
mod data;
mod elementary;
mod goodness;
pub mod hierarchical;
pub mod linearity;
mod maximum;
mod maximum_likelihood;
mod posterior;
mod sampler;
mod support;
mod thresholds;
pub mod two_stage;

use experiments::mar::MarModel;
use serde::{Deserialize, Serialize};

pub use data::{Cell, FitError};
pub use goodness::Goodness;
pub use maximum_likelihood::{LARGEST_LAPSE, ModelSize};
pub use support::Support;
pub use thresholds::Threshold;

use crate::numerics::weighted_quantiles;

/// One answered trial of a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MarTrial {
    /// Eccentricity of the changed ring, degrees (0–180).
    pub eccentricity_deg: f64,
    /// The detail limit that was shown, omega, degrees per cycle; greater than 0.
    pub mar_deg: f64,
    /// Whether the observer pointed at the changed interval.
    pub correct: bool,
}

/// A normal distribution of the natural logarithm of a positive parameter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LogNormal {
    /// The median of the parameter itself, in its own unit.
    pub median: f64,
    /// Standard deviation of its natural logarithm.
    pub sd_ln: f64,
}

/// The priors of a MAR fit: proper, weak, and written out with every result.
///
/// The medians sit where the literature does (Guenter 2012: m = 0.0220–0.0275, omega0 = 1/48°), and `sd_ln = 1.5` lets each
/// of m and omega0 range over a factor of 19 either way with 95 % probability. Lapses follow psignifit's Beta(1, 10)
/// (Schütt et al. 2016), cut at 1 − γ where the function would turn upside down.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MarPriors {
    /// Prior of the slope m.
    pub m: LogNormal,
    /// Prior of omega0, degrees per cycle.
    pub omega0: LogNormal,
    /// Prior of the width, in ln omega.
    pub width: LogNormal,
    /// Shape parameters (a, b) of the lapse rate's beta distribution; a ≥ 1, so that its density is bounded.
    pub lapse_beta: [f64; 2],
}

impl Default for MarPriors {
    fn default() -> Self {
        Self {
            m: LogNormal { median: 0.025, sd_ln: 1.5 },
            omega0: LogNormal { median: 1.0 / 48.0, sd_ln: 1.5 },
            width: LogNormal { median: 0.8, sd_ln: 0.8 },
            lapse_beta: [1.0, 10.0],
        }
    }
}

/// How a MAR fit is made; the same configuration and trials give the same numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MarFitConfig {
    /// Probability of a correct answer by guessing: ½ for two alternatives.
    pub guess: f64,
    /// Priors of the four parameters.
    pub priors: MarPriors,
    /// (eccentricity in degrees, finest MAR in degrees per cycle that the display could show there), for each tested
    /// eccentricity. Between entries it is interpolated; outside them the nearest holds. Empty: no limit is known.
    pub finest_mar: Vec<(f64, f64)>,
    /// Seed of the quasi-random shift and of the goodness-of-fit simulation.
    pub seed: u64,
    /// Posterior evaluations of an ordinary fit, at least 256; a hard posterior may take up to six times as many.
    pub draws: usize,
}

impl Default for MarFitConfig {
    fn default() -> Self {
        Self { guess: 0.5, priors: MarPriors::default(), finest_mar: Vec::new(), seed: 0, draws: 4096 }
    }
}

impl MarFitConfig {
    /// The finest MAR that the display could show at an eccentricity, where it is known.
    #[must_use]
    pub fn finest_mar_at(&self, eccentricity_deg: f64) -> Option<f64> {
        data::interpolate(&self.finest_mar, eccentricity_deg)
    }
}

/// A number with its 95 % credible interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Posterior median.
    pub estimate: f64,
    /// The 2.5 % and 97.5 % posterior quantiles.
    pub ci95: [f64; 2],
}

/// Mean and standard deviation of the posterior in the coordinates in which it is nearly normal.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Moments {
    /// Posterior mean.
    pub mean: f64,
    /// Posterior standard deviation.
    pub sd: f64,
}

/// Posterior moments of a MAR fit; logarithms are natural.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PosteriorMoments {
    /// Of ln m.
    pub ln_m: Moments,
    /// Of ln omega0.
    pub ln_omega0: Moments,
    /// Of ln width.
    pub ln_width: Moments,
    /// Of the lapse rate itself.
    pub lapse: Moments,
}

/// A fitted MAR line with everything needed to judge it: data, configuration, intervals, support.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MarFit {
    /// MAR slope, degrees per cycle gained per degree of eccentricity.
    pub m: Estimate,
    /// MAR at the fovea, degrees per cycle.
    pub omega0: Estimate,
    /// Width of the psychometric function in ln omega, from 5 % to 95 % of its rise.
    pub width: Estimate,
    /// Lapse rate.
    pub lapse: Estimate,
    /// The estimated omega0 lies below the finest MAR that the display could show: the intercept is extrapolated.
    pub display_limited: bool,
    /// One threshold per tested eccentricity, ascending, without the assumption of a line.
    pub thresholds: Vec<Threshold>,
    /// How well the line and the psychometric function describe the answers.
    pub goodness: Goodness,
    /// Whether the data carry the fit.
    pub support: Support,
    /// What a reader should know beside the numbers, in plain sentences.
    pub warnings: Vec<String>,
    /// All trials given, shown or not.
    pub trials: usize,
    /// Trials at or below what the display could show, left out of the likelihood.
    pub trials_not_shown: usize,
    /// Mode of the posterior density over (ln m, ln omega0, ln width, lapse).
    pub map: MarModel,
    /// Posterior moments.
    pub moments: PosteriorMoments,
    /// Effective sample size of the importance sample behind the intervals.
    pub ess: f64,
    /// Posterior evaluations made.
    pub evaluations: usize,
    /// Equally weighted draws from the posterior, for bands and derived quantities.
    pub posterior: Vec<MarModel>,
    /// The trials as counts per (eccentricity, omega), ascending.
    pub cells: Vec<Cell>,
    /// The configuration that made this fit.
    pub config: MarFitConfig,
}

impl MarFit {
    /// The fitted line at an eccentricity: posterior median and 95 % interval of `m e + omega0`, degrees per cycle.
    #[must_use]
    pub fn line_at(&self, eccentricity_deg: f64) -> Estimate {
        self.derived(|model| model.threshold_deg(eccentricity_deg))
    }

    /// The probability of a correct answer at an eccentricity and omega: posterior median and 95 % interval.
    #[must_use]
    pub fn probability_correct_at(&self, eccentricity_deg: f64, mar_deg: f64) -> Estimate {
        self.derived(|model| model.probability_correct(eccentricity_deg, mar_deg, self.config.guess))
    }

    /// Posterior median and 95 % interval of any quantity of the model.
    #[must_use]
    pub fn derived(&self, quantity: impl Fn(&MarModel) -> f64) -> Estimate {
        let values = crate::numerics::sorted_finite(self.posterior.iter().map(quantity));
        let at = |q| crate::numerics::quantile_of_sorted(&values, q).unwrap_or(f64::NAN);
        Estimate { estimate: at(0.5), ci95: [at(0.025), at(0.975)] }
    }
}

/// How many equally weighted posterior draws a fit keeps.
const KEPT_DRAWS: usize = 1000;

/// Fit the MAR line to trials: joint posterior over m, omega0, width and lapse, and a threshold per eccentricity.
///
/// The posterior is found by Fisher scoring and integrated by population Monte Carlo (Cappé et al. 2008) on quasi-random
/// points, with the prior as a defensive component, so that importance weights are bounded for any data. All correct, all
/// wrong, one level or one eccentricity give wide intervals and [`Support::Unsupported`], not an error.
///
/// # Errors
/// [`FitError`] when there are no trials, when a trial is not finite or out of range (it is named by its index), or when
/// the configuration is impossible.
///
/// ```
/// use analysis::mar::{MarFitConfig, MarTrial, fit_mar};
/// let trials: Vec<MarTrial> = (0..240)
///     .map(|i| {
///         let eccentricity_deg = f64::from(5 + 5 * (i % 3));
///         let level = i / 3 % 8;
///         let mar_deg = (0.022 * eccentricity_deg + 0.021) * 0.4 * 1.3f64.powi(level);
///         MarTrial { eccentricity_deg, mar_deg, correct: level >= 4 || i / 24 % 2 == 0 }
///     })
///     .collect();
/// let fit = fit_mar(&trials, &MarFitConfig::default())?;
/// assert!(fit.m.ci95[0] < fit.m.estimate && fit.m.estimate < fit.m.ci95[1]);
/// # Ok::<(), analysis::mar::FitError>(())
/// ```
pub fn fit_mar(trials: &[MarTrial], config: &MarFitConfig) -> Result<MarFit, FitError> {
    let data = data::Data::new(trials, config)?;
    let target = posterior::Posterior::new(&data, config);
    let modes = maximum::working_modes(&target);
    let sample = sampler::sample(&target, &modes, config);
    let map = maximum::map(&target, &modes);

    let models: Vec<MarModel> = sample.points.iter().map(|x| target.model(x)).collect();
    let Marginals { m, omega0, width, lapse, moments } = marginals(&models, &sample.weights);
    let finest = config.finest_mar.iter().map(|&(_, omega)| omega).fold(f64::INFINITY, f64::min);
    let kept = sample.resample(KEPT_DRAWS);
    let posterior: Vec<MarModel> = kept.into_iter().map(|index| models[index]).collect();
    let goodness = goodness::goodness(&data, &map, &posterior, config);
    let mut fit = MarFit {
        m,
        omega0,
        width,
        lapse,
        display_limited: finest.is_finite() && omega0.estimate < finest,
        thresholds: thresholds::thresholds(&data, &target, &sample, config),
        goodness,
        support: Support::Supported,
        warnings: Vec::new(),
        trials: trials.len(),
        trials_not_shown: data.not_shown,
        map,
        moments,
        ess: sample.ess(),
        evaluations: sample.points.len(),
        posterior,
        cells: data.cells,
        config: config.clone(),
    };
    fit.support = support::support(&fit);
    fit.warnings = support::warnings(&fit);
    Ok(fit)
}

/// What the four parameters' marginal distributions say.
struct Marginals {
    m: Estimate,
    omega0: Estimate,
    width: Estimate,
    lapse: Estimate,
    moments: PosteriorMoments,
}

fn marginals(models: &[MarModel], weights: &[f64]) -> Marginals {
    let estimate = |value: fn(&MarModel) -> f64| {
        let values: Vec<f64> = models.iter().map(value).collect();
        let [low, middle, high] = weighted_quantiles(&values, weights, [0.025, 0.5, 0.975]);
        Estimate { estimate: middle, ci95: [low, high] }
    };
    let moments = |value: fn(&MarModel) -> f64| {
        let mean: f64 = models.iter().zip(weights).map(|(x, w)| w * value(x)).sum();
        let square: f64 = models.iter().zip(weights).map(|(x, w)| w * (value(x) - mean).powi(2)).sum();
        Moments { mean, sd: square.sqrt() }
    };
    Marginals {
        m: estimate(|p| p.m),
        omega0: estimate(|p| p.omega0_deg),
        width: estimate(|p| p.width),
        lapse: estimate(|p| p.lapse),
        moments: PosteriorMoments {
            ln_m: moments(|p| p.m.ln()),
            ln_omega0: moments(|p| p.omega0_deg.ln()),
            ln_width: moments(|p| p.width.ln()),
            lapse: moments(|p| p.lapse),
        },
    }
}

/// One observer's own fit, as far as a group's fit needs it.
struct Unpooled {
    m: Estimate,
    omega0: Estimate,
    width: Estimate,
    /// Posterior SDs of ln m, ln omega0, ln width.
    sd_ln: [f64; 3],
    /// Posterior mean of (ln m, ln omega0, ln width, working lapse): where chains start.
    start: nalgebra::Vector4<f64>,
}

impl Unpooled {
    /// What the observer's trials alone tell of a logarithm: the posterior's precision less the prior's, not below 0.
    fn precision(&self, axis: usize, priors: &MarPriors) -> f64 {
        let prior = [priors.m, priors.omega0, priors.width][axis].sd_ln.powi(-2);
        (self.sd_ln[axis].max(1e-6).powi(-2) - prior).max(0.0)
    }
}

fn unpooled(data: &data::Data, config: &MarFitConfig) -> Unpooled {
    let target = posterior::Posterior::new(data, config);
    let modes = maximum::working_modes(&target);
    let sample = sampler::sample(&target, &modes, config);
    let models: Vec<MarModel> = sample.points.iter().map(|x| target.model(x)).collect();
    let Marginals { m, omega0, width, moments, .. } = marginals(&models, &sample.weights);
    let moments = [moments.ln_m, moments.ln_omega0, moments.ln_width];
    let start = nalgebra::Vector4::new(moments[0].mean, moments[1].mean, moments[2].mean, sample.moments(3).0);
    Unpooled { m, omega0, width, sd_ln: moments.map(|m| m.sd), start }
}
