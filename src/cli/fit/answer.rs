//! What `fit` answers: its JSON document and its tables.

use super::table::Group;
use crate::error::LabError;
use analysis::mar::Estimate;
use analysis::psychometric::{
    Comparison, Direction, Guess, Lapse, Overdispersion, PsychometricConfig, PsychometricError, PsychometricFit,
    PsychometricPosterior, Scale, Sigmoid, goodness_of_fit, likelihood_fit,
};
use analysis::report::results::{FunctionFit, functions_section};
use analysis::report::{Section, page};
use indicatif::ProgressBar;
use rayon::prelude::*;
use serde::Serialize;
use std::fmt::Write as _;

/// Five numbers or intervals by parameter.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct ByParameter<T> {
    threshold: T,
    width: T,
    lapse: T,
    guess: T,
    overdispersion: T,
}

/// What follows at a share of right answers; nothing where the function does not reach it.
#[derive(Debug, Clone, Serialize)]
struct AtShare {
    share: f64,
    level: Option<Estimate>,
    slope: Option<Estimate>,
}

/// The maximum-likelihood side of a fit.
#[derive(Debug, Clone, Serialize)]
struct LikelihoodAnswer {
    estimate: ByParameter<f64>,
    ci95: ByParameter<[Option<f64>; 2]>,
    ln_likelihood: f64,
    aic: f64,
    bic: f64,
    deviance: f64,
    deviance_p: Option<f64>,
}

/// One fitted function.
#[derive(Debug, Clone, Serialize)]
pub(super) struct FitAnswer {
    group: Option<String>,
    map: ByParameter<f64>,
    mean: ByParameter<f64>,
    median: ByParameter<f64>,
    ci95: ByParameter<[f64; 2]>,
    deviance: f64,
    deviance_p: Option<f64>,
    n_trials: u64,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    at: Vec<AtShare>,
    supported: bool,
    reasons: Vec<String>,
    warnings: Vec<String>,
    likelihood: LikelihoodAnswer,
    #[serde(flatten)]
    how: How,
    #[serde(skip)]
    posterior: PsychometricPosterior,
}

/// How a function was fitted and to what.
#[derive(Debug, Clone, Serialize)]
struct How {
    config: PsychometricConfig,
    priors: analysis::psychometric::Priors,
    simulations: usize,
    seed: u64,
    counts: Vec<analysis::psychometric::Count>,
}

/// The whole document.
#[derive(Debug, Serialize)]
pub(super) struct Document {
    fits: Vec<FitAnswer>,
    #[serde(skip_serializing_if = "Option::is_none")]
    comparison: Option<Comparison>,
    program: String,
}

/// What is asked of every fit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Options<'a> {
    pub(super) at: &'a [f64],
    pub(super) simulations: usize,
    pub(super) seed: u64,
}

/// A group's name; nothing if the table has no groups.
pub(super) fn name(group: &Group) -> Option<String> {
    (!group.values.is_empty()).then(|| group.values.join(" / "))
}

/// Fits all groups side by side, in their own order.
pub(super) fn fit_all(
    groups: &[Group],
    config: impl Fn(&Group) -> PsychometricConfig + Sync,
    options: &Options<'_>,
    bar: &ProgressBar,
) -> Vec<Result<FitAnswer, PsychometricError>> {
    groups
        .par_iter()
        .map(|group| {
            let answer = fit(group, &config(group), options);
            bar.inc(1);
            answer
        })
        .collect()
}

fn fit(group: &Group, config: &PsychometricConfig, options: &Options<'_>) -> Result<FitAnswer, PsychometricError> {
    let posterior = PsychometricPosterior::new(&group.counts, config)?;
    let fit = posterior.fit();
    let likelihood = likelihood_fit(&group.counts, config)?;
    let deviance_p = if options.simulations > 0 {
        Some(goodness_of_fit(&group.counts, config, options.simulations, options.seed)?.p)
    } else {
        None
    };
    let of = |f: &analysis::psychometric::Psychometric| ByParameter {
        threshold: f.threshold,
        width: f.width,
        lapse: f.lapse,
        guess: f.guess,
        overdispersion: f.overdispersion,
    };
    let at = options.at.iter().map(|&share| AtShare {
        share,
        level: posterior.threshold_at(share),
        slope: posterior.slope_at(share),
    });
    let ends = |profile: analysis::psychometric::Profile| [profile.low, profile.high];
    Ok(FitAnswer {
        group: name(group),
        map: of(&fit.map),
        mean: of(&posterior.mean()),
        median: estimates(&fit, |estimate| estimate.estimate),
        ci95: estimates(&fit, |estimate| estimate.ci95),
        deviance: fit.deviance.unwrap_or(f64::NAN),
        deviance_p,
        n_trials: fit.n_trials(),
        at: at.collect(),
        supported: fit.support.is_supported(),
        reasons: fit.support.reasons().to_vec(),
        warnings: fit.warnings.clone(),
        likelihood: LikelihoodAnswer {
            estimate: of(&likelihood.estimate),
            ci95: ByParameter {
                threshold: ends(likelihood.threshold),
                width: ends(likelihood.width),
                lapse: ends(likelihood.lapse),
                guess: ends(likelihood.guess),
                overdispersion: ends(likelihood.overdispersion),
            },
            ln_likelihood: likelihood.ln_likelihood,
            aic: likelihood.aic,
            bic: likelihood.bic,
            deviance: likelihood.deviance,
            deviance_p,
        },
        how: How {
            config: fit.config,
            priors: fit.priors,
            simulations: options.simulations,
            seed: options.seed,
            counts: fit.counts,
        },
        posterior,
    })
}

fn estimates<T>(fit: &PsychometricFit, of: impl Fn(&Estimate) -> T) -> ByParameter<T> {
    ByParameter {
        threshold: of(&fit.threshold),
        width: of(&fit.width),
        lapse: of(&fit.lapse),
        guess: of(&fit.guess),
        overdispersion: of(&fit.overdispersion),
    }
}

impl FitAnswer {
    /// How it was fitted.
    pub(super) fn config(&self) -> &PsychometricConfig {
        &self.how.config
    }

    /// How it was fitted, as a paper would say it.
    fn methods(&self, functions: usize) -> String {
        let config = self.config();
        let shape = match config.sigmoid {
            Sigmoid::CumulativeGauss => "cumulative Gaussian".to_owned(),
            Sigmoid::Logistic => "logistic".to_owned(),
            Sigmoid::Gumbel => "Gumbel".to_owned(),
            Sigmoid::ReversedGumbel => "reversed Gumbel".to_owned(),
            Sigmoid::Weibull => "Weibull".to_owned(),
            Sigmoid::HyperbolicSecant => "hyperbolic secant".to_owned(),
            Sigmoid::StudentT { df } => format!("cumulative Student t (df = {df})"),
        };
        let axis = if config.scale == Scale::Linear { "level" } else { "logarithm of the level" };
        let guess = match config.guess {
            Guess::Fixed(guess) => format!("the guess rate was fixed at {}", short(guess)),
            Guess::Free => "the guess rate was free".to_owned(),
            Guess::EqualToLapse => "guess and lapse rate were equal".to_owned(),
        };
        let lapse = match config.lapse {
            Lapse::Free => "the lapse rate was free".to_owned(),
            Lapse::Fixed(lapse) => format!("the lapse rate was fixed at {}", short(lapse)),
        };
        let counts = match config.overdispersion {
            Overdispersion::Free => "beta-binomial with free overdispersion",
            Overdispersion::None => "binomial",
        };
        let plural = if functions == 1 { "A psychometric function was" } else { "Psychometric functions were" };
        format!(
            "{plural} fitted to {} answers{}: a {shape} of the {axis}, ψ = γ + (1 − γ − λ) S((x − threshold)/width), with the \
             threshold where S is one half and the width from 5 % to 95 % of S; {guess}, {lapse}, and counts were {counts}. \
             Priors were those of Schütt, Harmeling, Macke and Wichmann (2016). The posterior was integrated on an adaptive \
             grid; medians with 95 % credible intervals are given. The deviance’s p is from {} data sets simulated from the \
             maximum-likelihood function and fitted again.",
            self.n_trials,
            if functions == 1 { "" } else { " of the first group, and alike to the others" },
            self.how.simulations
        )
    }

    fn text(&self) -> String {
        let config = self.config();
        let mut text = String::new();
        if let Some(group) = &self.group {
            let _ = writeln!(text, "{group}");
        }
        let direction = if config.direction == Direction::Rises { "rises" } else { "falls" };
        let axis = if config.scale == Scale::Linear { "linear" } else { "logarithmic" };
        let _ =
            writeln!(text, "{} answers at {} levels; the function {direction} on a {axis} axis\n", self.n_trials, {
                let mut levels: Vec<f64> = self.how.counts.iter().map(|count| count.level).collect();
                levels.dedup();
                levels.len()
            });
        let _ = writeln!(text, "  {:<15} {:>10} {:>10} {:>10}   95 % interval", "", "mode", "mean", "median");
        let rows = [
            ("threshold", self.map.threshold, self.mean.threshold, self.median.threshold, self.ci95.threshold),
            ("width", self.map.width, self.mean.width, self.median.width, self.ci95.width),
            ("lapse", self.map.lapse, self.mean.lapse, self.median.lapse, self.ci95.lapse),
            ("guess", self.map.guess, self.mean.guess, self.median.guess, self.ci95.guess),
            (
                "overdispersion",
                self.map.overdispersion,
                self.mean.overdispersion,
                self.median.overdispersion,
                self.ci95.overdispersion,
            ),
        ];
        for (name, map, mean, median, [low, high]) in rows {
            let interval = if low == high { "fixed".to_owned() } else { format!("{} – {}", short(low), short(high)) };
            let cells = [map, mean, median].map(|value| format!("{:>10}", short(value)));
            let _ = writeln!(text, "  {name:<15} {}   {interval}", cells.join(" "));
        }
        for at in &self.at {
            let share = format!("{} % right", short(100.0 * at.share));
            let _ = match (at.level, at.slope) {
                (Some(level), Some(slope)) => writeln!(
                    text,
                    "  {share}: level {} [{} – {}], slope {} [{} – {}]",
                    short(level.estimate),
                    short(level.ci95[0]),
                    short(level.ci95[1]),
                    short(slope.estimate),
                    short(slope.ci95[0]),
                    short(slope.ci95[1])
                ),
                _ => writeln!(text, "  {share}: not reached by every function that the data allow"),
            };
        }
        let p = self
            .deviance_p
            .map_or_else(String::new, |p| format!(", simulated p = {} ({} data sets)", short(p), self.how.simulations));
        let likelihood = &self.likelihood;
        let _ = writeln!(text, "\n  deviance {}{p}; AIC {}", short(self.deviance), short(likelihood.aic));
        let end = |end: Option<f64>| end.map_or_else(|| "open".to_owned(), short);
        let _ = writeln!(
            text,
            "  most likely threshold {} [{} – {}], by profile likelihood",
            short(likelihood.estimate.threshold),
            end(likelihood.ci95.threshold[0]),
            end(likelihood.ci95.threshold[1])
        );
        if !self.supported {
            let _ = writeln!(text, "\n  THE DATA DO NOT SUPPORT THIS FIT:");
            for reason in &self.reasons {
                let _ = writeln!(text, "  - {reason}");
            }
        }
        for warning in &self.warnings {
            let _ = writeln!(text, "  note: {warning}");
        }
        text
    }
}

/// Four significant digits, without needless zeros.
fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { value.to_string() };
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-4..9).contains(&magnitude) {
        return format!("{value:.2e}");
    }
    let decimals = usize::try_from(3 - magnitude).unwrap_or(0);
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

impl Document {
    pub(super) fn new(fits: Vec<FitAnswer>, comparison: Option<Comparison>) -> Self {
        Self { fits, comparison, program: format!("parafovea {}", env!("CARGO_PKG_VERSION")) }
    }

    /// Table and curves for a page.
    pub(super) fn section(&self, level_label: &str) -> Section {
        let fits: Vec<FunctionFit<'_>> = self
            .fits
            .iter()
            .map(|fit| FunctionFit {
                name: fit.group.as_deref().unwrap_or_default(),
                posterior: &fit.posterior,
                deviance_p: fit.deviance_p,
            })
            .collect();
        functions_section(&fits, level_label)
    }

    /// The page: how the fits were made in words, the section, and this document.
    pub(super) fn page(&self, file: &str, section: Section) -> Result<String, LabError> {
        let json = serde_json::to_value(self).map_err(|error| LabError::Failed(error.to_string()))?;
        let mut methods = Section::new("Methods");
        if let Some(first) = self.fits.first() {
            methods.prose.push(first.methods(self.fits.len()));
        }
        methods.prose.push(format!("Software: {}.", self.program));
        let title = format!("Psychometric functions of {file}");
        Ok(page(&title, &[section, methods], &json))
    }

    /// The tables for a terminal.
    pub(super) fn text(&self) -> String {
        let mut texts: Vec<String> = self.fits.iter().map(FitAnswer::text).collect();
        if let Some(comparison) = &self.comparison {
            let tested: Vec<String> = comparison
                .together
                .shared
                .iter()
                .filter(|parameter| !comparison.apart.shared.contains(parameter))
                .map(|parameter| format!("{parameter:?}").to_lowercase())
                .collect();
            texts.push(format!(
                "do all groups share {}? likelihood ratio χ²({}) = {}, p = {}; AIC {} shared, {} separate",
                tested.join(" and "),
                comparison.df,
                short(comparison.deviance),
                short(comparison.p),
                short(comparison.together.aic),
                short(comparison.apart.aic)
            ));
        }
        texts.join("\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_keep_their_size() {
        let cases = [
            (3.548_196, "3.548"),
            (0.0, "0"),
            (40.0, "40"),
            (1234.5, "1234"),
            (0.017_519, "0.01752"),
            (1e-9, "1.00e-9"),
        ];
        for (value, expected) in cases {
            assert_eq!(short(value), expected);
        }
    }
}
