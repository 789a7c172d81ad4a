//! One psychometric function: its parameters, and what follows from them at a level or at a share of right answers.

use super::sigmoid::Shape;
use super::{Direction, PsychometricConfig, Scale};
use serde::{Deserialize, Serialize};

/// The parameters of one function.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Psychometric {
    /// The level at which the shape is ½.
    pub threshold: f64,
    /// From 5 % to 95 % of the shape, in units of the level, or of its natural logarithm on a logarithmic axis.
    pub width: f64,
    /// Lapse rate λ.
    pub lapse: f64,
    /// Guess rate γ.
    pub guess: f64,
    /// Overdispersion η; 0 for independent answers.
    #[serde(default)]
    pub overdispersion: f64,
}

/// A shape at a place: turns coordinates into (seen, missed).
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    shape: Shape,
    direction: Direction,
    center: f64,
    /// u per unit of the coordinate.
    steepness: f64,
}

/// The coordinate in which a configuration's shape is a shape of a place and a scale: the axis's, but ln level for a
/// Weibull function on a linear axis.
pub(super) fn coordinate(config: &PsychometricConfig, level: f64) -> f64 {
    if config.sigmoid.is_weibull() { level.ln() } else { config.scale.coordinate(level) }
}

fn level_of(config: &PsychometricConfig, coordinate: f64) -> f64 {
    if config.sigmoid.is_weibull() { coordinate.exp() } else { config.scale.level(coordinate) }
}

impl Placed {
    /// `threshold` and `width` in the axis's coordinate.
    #[inline]
    pub(super) fn new(shape: Shape, config: &PsychometricConfig, threshold: f64, width: f64) -> Self {
        let direction = config.direction;
        if config.sigmoid.is_weibull() && config.scale == Scale::Linear {
            let steepness = Shape::weibull_steepness(threshold, width);
            return Self { shape, direction, center: threshold.ln(), steepness };
        }
        Self { shape, direction, center: threshold, steepness: 1.0 / width }
    }

    #[inline]
    pub(super) fn value(&self, coordinate: f64) -> (f64, f64) {
        self.direction.orient(self.shape.value((coordinate - self.center) * self.steepness))
    }
}

impl Psychometric {
    fn placed(&self, config: &PsychometricConfig) -> Placed {
        let shape = Shape::new(config.sigmoid);
        Placed::new(shape, config, config.scale.coordinate(self.threshold), self.width)
    }

    /// The probability of a right answer at a level: `γ + (1 − γ − λ) S`.
    #[must_use]
    pub fn probability(&self, level: f64, config: &PsychometricConfig) -> f64 {
        let (seen, _) = self.placed(config).value(coordinate(config, level));
        self.guess + (1.0 - self.guess - self.lapse) * seen
    }

    /// The level at which the probability of a right answer is `p`; nothing for a share that no level gives.
    #[must_use]
    pub fn level_at(&self, p: f64, config: &PsychometricConfig) -> Option<f64> {
        self.scaled_at(p, config).map(|u| self.level_of_u(u, config))
    }

    /// The slope, right answers per unit of the level, at the level at which their share is `p`; negative for a function
    /// that falls.
    #[must_use]
    pub fn slope_at(&self, p: f64, config: &PsychometricConfig) -> Option<f64> {
        let u = self.scaled_at(p, config)?;
        let level = self.level_of_u(u, config);
        let per_coordinate = self.placed(config).steepness;
        let logarithmic = config.sigmoid.is_weibull() || config.scale == Scale::Logarithmic;
        let per_level = if logarithmic { per_coordinate / level } else { per_coordinate };
        let sign = if config.direction == Direction::Rises { 1.0 } else { -1.0 };
        Some(sign * (1.0 - self.guess - self.lapse) * config.sigmoid.slope(u) * per_level)
    }

    /// u at a share of right answers.
    fn scaled_at(&self, p: f64, config: &PsychometricConfig) -> Option<f64> {
        let seen = (p - self.guess) / (1.0 - self.guess - self.lapse);
        let shape = if config.direction == Direction::Rises { seen } else { 1.0 - seen };
        (shape > 0.0 && shape < 1.0).then(|| config.sigmoid.inverse(shape))
    }

    fn level_of_u(&self, u: f64, config: &PsychometricConfig) -> f64 {
        let placed = self.placed(config);
        level_of(config, placed.center + u / placed.steepness)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Sigmoid;
    use super::*;

    const FLAWLESS: Psychometric =
        Psychometric { threshold: 4.0, width: 2.0, lapse: 0.0, guess: 0.0, overdispersion: 0.0 };

    #[test]
    fn the_width_spans_five_to_ninety_five_per_cent() {
        let rises = PsychometricConfig::TWO_ALTERNATIVES;
        let falls = PsychometricConfig { direction: Direction::Falls, ..rises };
        for (level, expected) in [(3.0, 0.05), (4.0, 0.5), (5.0, 0.95)] {
            assert!((FLAWLESS.probability(level, &rises) - expected).abs() < 1e-9);
            assert!((FLAWLESS.probability(level, &falls) - (1.0 - expected)).abs() < 1e-9);
        }
        let octave = Psychometric { width: 2.0 * 2f64.ln(), ..FLAWLESS };
        let logarithmic = PsychometricConfig { scale: Scale::Logarithmic, ..rises };
        assert!((octave.probability(8.0, &logarithmic) - 0.95).abs() < 1e-9);
    }

    /// A Weibull function with threshold 2 and β = 3 is 1 − exp(−ln 2 (x/2)³) on both axes.
    #[test]
    fn weibull_is_the_same_curve_on_both_axes() {
        let beta = 3.0;
        let level = |p: f64| 2.0 * (-(1.0 - p).ln() / 2f64.ln()).powf(1.0 / beta);
        let base = PsychometricConfig { sigmoid: Sigmoid::Weibull, ..PsychometricConfig::TWO_ALTERNATIVES };
        let linear = Psychometric { threshold: 2.0, width: level(0.95) - level(0.05), ..FLAWLESS };
        let logarithmic = Psychometric { threshold: 2.0, width: (level(0.95) / level(0.05)).ln(), ..FLAWLESS };
        let log_axis = PsychometricConfig { scale: Scale::Logarithmic, ..base };
        for x in [0.3, 1.0, 2.0, 2.9] {
            let expected = 1.0 - (-2f64.ln() * (x / 2.0f64).powf(beta)).exp();
            assert!((linear.probability(x, &base) - expected).abs() < 1e-10);
            assert!((logarithmic.probability(x, &log_axis) - expected).abs() < 1e-10);
            let falls = PsychometricConfig { direction: Direction::Falls, ..base };
            assert!((linear.probability(x, &falls) - (1.0 - expected)).abs() < 1e-10);
        }
    }

    #[test]
    fn levels_and_slopes_invert_probability() {
        let function = Psychometric { threshold: 4.0, width: 2.0, lapse: 0.03, guess: 0.5, overdispersion: 0.0 };
        for sigmoid in [Sigmoid::CumulativeGauss, Sigmoid::Gumbel, Sigmoid::Weibull, Sigmoid::StudentT { df: 2.0 }] {
            for scale in [Scale::Linear, Scale::Logarithmic] {
                for direction in [Direction::Rises, Direction::Falls] {
                    let config =
                        PsychometricConfig { sigmoid, scale, direction, ..PsychometricConfig::TWO_ALTERNATIVES };
                    for p in [0.55, 0.75, 0.9] {
                        let level = function.level_at(p, &config).unwrap();
                        assert!((function.probability(level, &config) - p).abs() < 1e-9, "{config:?}");
                        let h = 1e-6 * level;
                        let numeric = (function.probability(level + h, &config)
                            - function.probability(level - h, &config))
                            / (2.0 * h);
                        let slope = function.slope_at(p, &config).unwrap();
                        assert!((slope / numeric - 1.0).abs() < 1e-5, "{config:?} at {p}: {slope} {numeric}");
                    }
                    assert_eq!(function.level_at(0.5, &config), None);
                    assert_eq!(function.level_at(0.98, &config), None);
                }
            }
        }
    }
}
