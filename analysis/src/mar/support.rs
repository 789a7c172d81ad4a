//! Whether the data carry the fit, said in plain words.
//!
//! A posterior exists for any data, because the priors are proper. These rules say when it is the priors that speak.

use super::MarFit;
use serde::{Deserialize, Serialize};

/// Whether a fit may be reported as a result.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "verdict")]
pub enum Support {
    /// The data determine the line.
    Supported,
    /// They do not; the numbers stand with their wide intervals, and this is why they are not a result.
    Unsupported {
        /// One sentence per reason.
        reasons: Vec<String>,
    },
}

impl Support {
    /// True for [`Support::Supported`].
    #[must_use]
    pub fn is_supported(&self) -> bool {
        matches!(self, Self::Supported)
    }

    /// The reasons against the fit; empty when it is supported.
    #[must_use]
    pub fn reasons(&self) -> &[String] {
        match self {
            Self::Supported => &[],
            Self::Unsupported { reasons } => reasons,
        }
    }
}

/// Fewest trials in the likelihood.
const FEWEST_TRIALS: usize = 30;
/// A posterior wider than this share of its prior has learned little.
const PRIOR_SHARE: f64 = 0.75;
/// Least gain in log likelihood over answers that ignore the level.
const LEAST_GAIN: f64 = 3.0;

/// Judge a fit that is complete but for its support and warnings.
pub(super) fn support(fit: &MarFit) -> Support {
    let mut reasons = Vec::new();
    let shown: Vec<_> = fit.cells.iter().filter(|cell| cell.shown).collect();
    let trials: usize = shown.iter().map(|cell| cell.n as usize).sum();
    if trials < FEWEST_TRIALS {
        reasons.push(format!(
            "Only {trials} trials could be used; a line with its width and lapse rate needs at least {FEWEST_TRIALS}."
        ));
    }
    let mut eccentricities: Vec<f64> = shown.iter().map(|cell| cell.eccentricity_deg).collect();
    eccentricities.dedup();
    if eccentricities.len() < 2 {
        reasons.push(format!(
            "Answers come from {} eccentricity: slope and intercept cannot be told apart.",
            if eccentricities.is_empty() { "no" } else { "one" }
        ));
    }

    let guess = fit.config.guess;
    let shares = pooled_shares(fit);
    let best = shares.iter().copied().fold(0.0, f64::max);
    let worst = shares.iter().copied().fold(1.0, f64::min);
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    if trials > 0 && best < guess + 0.5 * (1.0 - guess) {
        reasons.push(format!(
            "No level was clearly seen: the best group of levels was answered correctly in {}, where guessing gives {}.",
            percent(best),
            percent(guess)
        ));
    }
    if trials > 0 && worst > guess + 0.8 * (1.0 - guess) {
        reasons.push(format!(
            "No level was hard: even the worst group of levels was answered correctly in {}, so the thresholds lie below \
             the levels that were shown.",
            percent(worst)
        ));
    }
    if trials >= FEWEST_TRIALS && gain_over_constant(fit) < LEAST_GAIN {
        reasons.push(
            "The answers do not depend on level and eccentricity more than chance would make them: a constant share \
             correct describes them as well."
                .to_owned(),
        );
    }

    let priors = &fit.config.priors;
    for (name, sd, prior_sd) in [
        ("slope m", fit.moments.ln_m.sd, priors.m.sd_ln),
        ("intercept omega0", fit.moments.ln_omega0.sd, priors.omega0.sd_ln),
    ] {
        if sd > PRIOR_SHARE * prior_sd {
            reasons.push(format!(
                "The {name} is hardly known better after the data than before (its logarithm's standard deviation is \
                 {sd:.2}, the prior's {prior_sd:.2})."
            ));
        }
    }
    let measured = fit.thresholds.iter().filter(|threshold| !threshold.limited).count();
    if eccentricities.len() >= 2 && measured < 2 {
        reasons.push(format!(
            "{} of {} thresholds could be measured; the others lie below what the display could show.",
            if measured == 0 { "None".to_owned() } else { "Only one".to_owned() },
            fit.thresholds.len()
        ));
    }
    if reasons.is_empty() { Support::Supported } else { Support::Unsupported { reasons } }
}

/// What a reader should know even of a supported fit.
pub(super) fn warnings(fit: &MarFit) -> Vec<String> {
    let mut warnings = Vec::new();
    if fit.display_limited {
        warnings.push(
            "omega0 is finer than anything that the display could show: it is extrapolated from larger eccentricities \
             and holds only if the line does."
                .to_owned(),
        );
    }
    let limited: Vec<String> = fit
        .thresholds
        .iter()
        .filter(|threshold| threshold.limited)
        .map(|threshold| format!("{}°", threshold.eccentricity_deg))
        .collect();
    if !limited.is_empty() {
        warnings.push(format!(
            "At {} the threshold lies below the finest detail that the display could show; the number given is an upper \
             limit.",
            limited.join(", ")
        ));
    }
    if fit.trials_not_shown > 0 {
        warnings.push(format!(
            "{} of {} trials asked for detail at or below the display's limit; nothing changed on the screen, and they \
             are left out.",
            fit.trials_not_shown, fit.trials
        ));
    }
    if fit.goodness.p < 0.01 {
        warnings.push(format!(
            "The model describes the answers poorly (p = {:.3}): look at the curves before using the numbers.",
            fit.goodness.p
        ));
    }
    if fit.lapse.estimate > 0.1 {
        warnings.push(format!(
            "The lapse rate is {:.0} %: the observer often answered without regard to the picture.",
            100.0 * fit.lapse.estimate
        ));
    }
    if fit.ess < 300.0 {
        warnings.push(format!(
            "The posterior was hard to integrate (effective sample size {:.0}); interval ends are rough.",
            fit.ess
        ));
    }
    warnings
}

/// Share correct in groups of neighbouring levels of about ten trials, over all eccentricities.
fn pooled_shares(fit: &MarFit) -> Vec<f64> {
    let mut shares = Vec::new();
    let (mut n, mut k, mut last_e) = (0u32, 0u32, f64::NAN);
    for cell in fit.cells.iter().filter(|cell| cell.shown) {
        if cell.eccentricity_deg != last_e || n >= super::goodness::POOL {
            // A short remainder is too few to judge by.
            if n >= super::goodness::POOL / 2 {
                shares.push(f64::from(k) / f64::from(n));
            }
            (n, k) = (0, 0);
        }
        last_e = cell.eccentricity_deg;
        n += cell.n;
        k += cell.k;
    }
    if n >= super::goodness::POOL / 2 || shares.is_empty() && n > 0 {
        shares.push(f64::from(k) / f64::from(n));
    }
    shares
}

/// Log likelihood at the mode over that of one share correct for all trials.
fn gain_over_constant(fit: &MarFit) -> f64 {
    let ln = |x: f64| x.max(f64::MIN_POSITIVE).ln();
    let (mut n, mut k, mut model) = (0.0, 0.0, 0.0);
    for cell in fit.cells.iter().filter(|cell| cell.shown) {
        let p = fit.map.probability_correct(cell.eccentricity_deg, cell.mar_deg, fit.config.guess);
        let (right, all) = (f64::from(cell.k), f64::from(cell.n));
        n += all;
        k += right;
        model += right * ln(p) + (all - right) * ln(1.0 - p);
    }
    if n == 0.0 {
        return 0.0;
    }
    let constant = k * ln(k / n) + (n - k) * ln(1.0 - k / n);
    model - constant
}
