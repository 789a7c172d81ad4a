//! How a psychometric function is fitted: shape, axis, rates, overdispersion, priors.

use super::prior::Priors;
use super::{Direction, Scale, Sigmoid};
use serde::{Deserialize, Serialize};

/// How often an answer is right without anything having been seen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Guess {
    /// This often, from 0 to below 1: 1/n for n alternatives ([`Guess::of_alternatives`]).
    Fixed(f64),
    /// Unknown: the false alarms of an observer who may also say "the same", or yes and no.
    Free,
    /// As often as the lapse rate: both asymptotes are equally far from certainty. Their prior counts once.
    EqualToLapse,
}

impl Guess {
    /// One right answer among `n` alternatives, at least two.
    #[must_use]
    pub fn of_alternatives(n: u32) -> Self {
        Self::Fixed(1.0 / f64::from(n.max(2)))
    }
}

/// How often an answer is wrong though everything was seen.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Lapse {
    /// Unknown.
    #[default]
    Free,
    /// This often, from 0 to below 1.
    Fixed(f64),
}

/// Whether answers of one row of counts may hang together more than independent ones would.
///
/// With η above zero the counts are beta-binomial: their variance is that of independent answers times
/// 1 + (n − 1) η² (v = 1/η² − 1; Schütt et al. 2016, §2.2). Rows of the same level are then blocks of their own.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Overdispersion {
    /// Answers are independent: η = 0.
    #[default]
    None,
    /// η is unknown, from 0 to 1.
    Free,
}

/// How a function is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PsychometricConfig {
    /// The shape.
    #[serde(default)]
    pub sigmoid: Sigmoid,
    /// The axis.
    pub scale: Scale,
    /// The direction.
    pub direction: Direction,
    /// The guess rate γ.
    pub guess: Guess,
    /// The lapse rate λ.
    #[serde(default)]
    pub lapse: Lapse,
    /// Overdispersion η.
    #[serde(default)]
    pub overdispersion: Overdispersion,
    /// Priors of what is free.
    #[serde(default)]
    pub priors: Priors,
    /// Lowest and highest level that the experiment could show, for the standard priors; otherwise those of the data. With
    /// a range, one level or no answers at all give an answer too: the prior's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
}

impl PsychometricConfig {
    /// Two alternatives, a cumulative Gaussian that rises on a linear axis, a free lapse rate, independent answers, and
    /// psignifit's priors.
    pub const TWO_ALTERNATIVES: Self = Self {
        sigmoid: Sigmoid::CumulativeGauss,
        scale: Scale::Linear,
        direction: Direction::Rises,
        guess: Guess::Fixed(0.5),
        lapse: Lapse::Free,
        overdispersion: Overdispersion::None,
        priors: Priors::STANDARD,
        range: None,
    };
}

impl Default for PsychometricConfig {
    /// [`PsychometricConfig::TWO_ALTERNATIVES`].
    fn default() -> Self {
        Self::TWO_ALTERNATIVES
    }
}
