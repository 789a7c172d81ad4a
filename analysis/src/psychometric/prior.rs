//! Prior distributions of the parameters of a psychometric function.
//!
//! The standard ones are psignifit's (Schütt et al. 2016, §2.3), which follow the levels of the experiment; any may be
//! replaced. Densities are known up to a constant, which a posterior does not need.

use super::PsychometricError;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// The prior of one parameter. Thresholds and widths are in the axis's coordinate: ln level on a logarithmic axis.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Prior {
    /// psignifit's. Threshold: flat over the range R of levels, falling as a raised cosine over R/2 on either side. Width:
    /// rising from the smallest step s between levels to 2 s, flat to R, falling to 3 R. Rates and η: Beta(1, 10).
    #[default]
    Standard,
    /// Rises from `from` to `flat_from` and falls from `flat_to` to `to`, each as half a cosine.
    RaisedCosine {
        /// Zero below.
        from: f64,
        /// Flat from here.
        flat_from: f64,
        /// Flat up to here.
        flat_to: f64,
        /// Zero above.
        to: f64,
    },
    /// Flat.
    Uniform {
        /// Lowest value.
        low: f64,
        /// Highest value.
        high: f64,
    },
    /// Normal.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation.
        sd: f64,
    },
    /// Normal in the natural logarithm of a positive parameter.
    LogNormal {
        /// Median of the parameter.
        median: f64,
        /// Standard deviation of its logarithm.
        sd_ln: f64,
    },
    /// Beta, between 0 and 1.
    Beta {
        /// First shape parameter.
        a: f64,
        /// Second shape parameter.
        b: f64,
    },
}

/// The priors of all parameters; those of fixed ones are not used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Priors {
    /// Of the threshold.
    pub threshold: Prior,
    /// Of the width.
    pub width: Prior,
    /// Of the lapse rate.
    pub lapse: Prior,
    /// Of a free guess rate.
    pub guess: Prior,
    /// Of η.
    pub overdispersion: Prior,
}

impl Priors {
    /// psignifit's.
    pub const STANDARD: Self = Self {
        threshold: Prior::Standard,
        width: Prior::Standard,
        lapse: Prior::Standard,
        guess: Prior::Standard,
        overdispersion: Prior::Standard,
    };
}

impl Default for Priors {
    fn default() -> Self {
        Self::STANDARD
    }
}

/// λ and a free γ are cut here; Beta(1, 10) has 0.1 % of its mass beyond.
const LARGEST_RATE: f64 = 0.5;
/// η is cut here, before its beta-binomial becomes a coin that falls once for the whole row.
const LARGEST_OVERDISPERSION: f64 = 0.99;
/// A normal prior is cut so many standard deviations from its mean.
const NORMAL_REACH: f64 = 6.0;

impl Priors {
    /// The standard ones written out for an axis whose levels span `range` with smallest step `step`.
    pub(super) fn resolved(&self, range: [f64; 2], step: f64) -> Self {
        let spread = range[1] - range[0];
        // Two levels have one step, as long as their range.
        let step = step.min(0.5 * spread);
        let or = |prior: Prior, standard: Prior| if prior == Prior::Standard { standard } else { prior };
        let rate = Prior::Beta { a: 1.0, b: 10.0 };
        Self {
            threshold: or(
                self.threshold,
                Prior::RaisedCosine {
                    from: range[0] - 0.5 * spread,
                    flat_from: range[0],
                    flat_to: range[1],
                    to: range[1] + 0.5 * spread,
                },
            ),
            width: or(
                self.width,
                Prior::RaisedCosine { from: step, flat_from: 2.0 * step, flat_to: spread, to: 3.0 * spread },
            ),
            lapse: or(self.lapse, rate),
            guess: or(self.guess, rate),
            overdispersion: or(self.overdispersion, rate),
        }
    }

    /// Whether threshold or width follow the levels.
    pub(super) fn need_range(&self) -> bool {
        self.threshold == Prior::Standard || self.width == Prior::Standard
    }
}

impl Prior {
    /// ln of the density, without its constant; −∞ outside its support.
    #[must_use]
    pub fn ln_density(&self, x: f64) -> f64 {
        match *self {
            Self::Standard => 0.0,
            Self::RaisedCosine { from, flat_from, flat_to, to } => {
                let density: f64 = if x <= from || x >= to {
                    0.0
                } else if x < flat_from {
                    0.5 - 0.5 * (PI * (x - from) / (flat_from - from)).cos()
                } else if x <= flat_to {
                    1.0
                } else {
                    0.5 + 0.5 * (PI * (x - flat_to) / (to - flat_to)).cos()
                };
                density.ln()
            }
            Self::Uniform { low, high } => {
                if (low..=high).contains(&x) {
                    0.0
                } else {
                    f64::NEG_INFINITY
                }
            }
            Self::Normal { mean, sd } => -0.5 * ((x - mean) / sd).powi(2),
            Self::LogNormal { median, sd_ln } if x > 0.0 => -0.5 * ((x / median).ln() / sd_ln).powi(2) - x.ln(),
            Self::LogNormal { .. } => f64::NEG_INFINITY,
            Self::Beta { a, b } => {
                // 0 · ln 0 is 0: Beta(1, b) is finite at zero.
                let term = |power: f64, ln: f64| if power == 0.0 { 0.0 } else { power * ln };
                if (0.0..=1.0).contains(&x) {
                    term(a - 1.0, x.ln()) + term(b - 1.0, (-x).ln_1p())
                } else {
                    f64::NEG_INFINITY
                }
            }
        }
    }

    /// Where the density is looked at.
    pub(super) fn support(&self) -> [f64; 2] {
        match *self {
            Self::Standard => [f64::NEG_INFINITY, f64::INFINITY],
            Self::RaisedCosine { from, to, .. } => [from, to],
            Self::Uniform { low, high } => [low, high],
            Self::Normal { mean, sd } => [mean - NORMAL_REACH * sd, mean + NORMAL_REACH * sd],
            Self::LogNormal { median, sd_ln } => {
                [median * (-NORMAL_REACH * sd_ln).exp(), median * (NORMAL_REACH * sd_ln).exp()]
            }
            Self::Beta { .. } => [0.0, 1.0],
        }
    }

    /// The same for a rate.
    pub(super) fn rate_support(&self) -> [f64; 2] {
        let [low, high] = self.support();
        [low.max(0.0), high.min(LARGEST_RATE)]
    }

    /// The same for η.
    pub(super) fn overdispersion_support(&self) -> [f64; 2] {
        let [low, high] = self.support();
        [low.max(0.0), high.min(LARGEST_OVERDISPERSION)]
    }

    /// The same for a width, which must be above zero.
    pub(super) fn width_support(&self) -> [f64; 2] {
        let [low, high] = self.support();
        [low.max(1e-6 * high), high]
    }

    /// Whether it is a distribution, and one of `what`.
    pub(super) fn check(&self, what: &'static str) -> Result<(), PsychometricError> {
        let sound = match *self {
            Self::Standard => true,
            Self::RaisedCosine { from, flat_from, flat_to, to } => {
                [from, flat_from, flat_to, to].windows(2).all(|pair| pair[0] <= pair[1])
                    && from < to
                    && from.is_finite()
                    && to.is_finite()
            }
            Self::Uniform { low, high } => low < high && low.is_finite() && high.is_finite(),
            Self::Normal { mean, sd } => mean.is_finite() && sd > 0.0 && sd.is_finite(),
            Self::LogNormal { median, sd_ln } => median > 0.0 && median.is_finite() && sd_ln > 0.0 && sd_ln.is_finite(),
            Self::Beta { a, b } => a >= 1.0 && b >= 1.0 && a.is_finite() && b.is_finite(),
        };
        let [low, high] = match what {
            "width" => self.width_support(),
            "lapse" | "guess" => self.rate_support(),
            "overdispersion" => self.overdispersion_support(),
            _ => self.support(),
        };
        if sound && low < high { Ok(()) } else { Err(PsychometricError::BadPrior { what, found: *self }) }
    }
}
