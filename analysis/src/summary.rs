//! The JSON document of `parafovea analyze --json`.
//!
//! These are file types, kept apart from the domain's [`crate::mar::MarFit`] so that the fit may change while readers of
//! the document need not. Keys are only ever added.

use crate::mar::{Estimate, Goodness, MarFit, Support};
use serde::{Deserialize, Serialize};

/// The whole document.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Analysis {
    /// One entry per observer, in the order given.
    pub observers: Vec<ObserverSummary>,
}

/// One observer's results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObserverSummary {
    /// The observer's code.
    pub observer: String,
    /// The fitted line.
    pub mar: MarSummary,
    /// Thresholds, ascending in eccentricity.
    pub thresholds: Vec<ThresholdSummary>,
    /// Trials given to the fit.
    pub trials: usize,
    /// Trials left out because the display could not show their level.
    pub trials_not_shown: usize,
    /// Whether the data carry the fit.
    pub support: SupportSummary,
    /// What to know beside the numbers.
    pub warnings: Vec<String>,
    /// Goodness of fit.
    pub goodness: Goodness,
    /// Effective sample size behind the intervals.
    pub ess: f64,
}

/// The fitted line; MAR in degrees per cycle, m in degrees per cycle per degree.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MarSummary {
    /// Slope.
    pub m: Estimate,
    /// MAR at the fovea.
    pub omega0: Estimate,
    /// Width of the psychometric function in ln omega.
    pub width: Estimate,
    /// Lapse rate.
    pub lapse: Estimate,
    /// omega0 lies below what the display could show: it is extrapolated.
    pub display_limited: bool,
}

/// The threshold at one eccentricity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ThresholdSummary {
    /// Eccentricity, degrees.
    pub eccentricity_deg: f64,
    /// Threshold, degrees per cycle; an upper limit where `limited`.
    pub mar_deg: f64,
    /// 95 % interval.
    pub ci95: [f64; 2],
    /// Below what the display could show.
    pub limited: bool,
    /// Trials at this eccentricity.
    pub trials: usize,
}

/// Whether a fit is supported, flat for readers in any language.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SupportSummary {
    /// False when the numbers are not a result.
    pub supported: bool,
    /// Why not, one sentence each.
    pub reasons: Vec<String>,
}

impl From<&Support> for SupportSummary {
    fn from(support: &Support) -> Self {
        Self { supported: support.is_supported(), reasons: support.reasons().to_vec() }
    }
}

impl ObserverSummary {
    /// The entry of one observer.
    #[must_use]
    pub fn new(observer: impl Into<String>, fit: &MarFit) -> Self {
        Self {
            observer: observer.into(),
            mar: MarSummary {
                m: fit.m,
                omega0: fit.omega0,
                width: fit.width,
                lapse: fit.lapse,
                display_limited: fit.display_limited,
            },
            thresholds: fit
                .thresholds
                .iter()
                .map(|t| ThresholdSummary {
                    eccentricity_deg: t.eccentricity_deg,
                    mar_deg: t.mar_deg,
                    ci95: t.ci95,
                    limited: t.limited,
                    trials: t.trials,
                })
                .collect(),
            trials: fit.trials,
            trials_not_shown: fit.trials_not_shown,
            support: SupportSummary::from(&fit.support),
            warnings: fit.warnings.clone(),
            goodness: fit.goodness,
            ess: fit.ess,
        }
    }
}
