//! The shapes that a psychometric function can have, each on the same two parameters.
//!
//! `u = (x − threshold)/width`: every shape is ½ at u = 0 and rises from 5 % to 95 % while u grows by 1, so that thresholds
//! and widths of different shapes can be compared (Schütt, Harmeling, Macke and Wichmann 2016, §2.1).

use crate::numerics::{normal_cdf_pair, normal_pdf, normal_quantile};
use experiments::mar::WIDTH_SCALE;
use serde::{Deserialize, Serialize};
use statrs::function::beta::{beta_reg, inv_beta_reg, ln_beta};
use std::f64::consts::{LN_2, PI};

/// 2 ln 19: a logistic function's width in its own unit.
const LOGISTIC_WIDTH: f64 = 5.888_877_958_332_881;
/// ln(−ln 0.05) − ln(−ln 0.95).
const GUMBEL_WIDTH: f64 = 4.067_383_949_407_112_5;
/// ln tan(0.95 π/2) − ln tan(0.05 π/2).
const SECANT_WIDTH: f64 = 5.084_180_872_121_112;

/// The shape of a psychometric function between its asymptotes.
///
/// On a logarithmic axis ([`super::Scale::Logarithmic`]) the shape holds in the natural logarithm of the level.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sigmoid {
    /// Φ(3.2897 u); on a logarithmic axis, the cumulative log-normal.
    #[default]
    CumulativeGauss,
    /// 1/(1 + exp(−5.8889 u)).
    Logistic,
    /// 1 − exp(−ln 2 · exp(4.0674 u)), which rises late and ends steeply; on a logarithmic axis, the Weibull function.
    Gumbel,
    /// exp(−ln 2 · exp(−4.0674 u)), which begins steeply and ends late.
    ReversedGumbel,
    /// 1 − exp(−ln 2 · (level/threshold)^β), for levels above zero on either axis.
    ///
    /// On a logarithmic axis it is [`Sigmoid::Gumbel`], β = 4.0674/width and the width is one of ln level. On a linear
    /// axis it is the same curve, but its width and all priors are in the level's own unit:
    /// width = threshold · ((ln 20/ln 2)^{1/β} − (ln(1/0.95)/ln 2)^{1/β}).
    Weibull,
    /// (2/π) arctan exp(5.0842 u).
    HyperbolicSecant,
    /// The cumulative distribution of Student's t, whose heavy tails give odd answers far from the threshold less weight.
    StudentT {
        /// Degrees of freedom, above zero; 1 is the Cauchy distribution.
        df: f64,
    },
}

/// A shape made ready to be evaluated often: constants that take time are taken once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    sigmoid: Sigmoid,
    /// u times this is the shape's own argument.
    scale: f64,
}

impl Sigmoid {
    /// The shape and its complement at u, each to full relative precision in its own tail.
    #[must_use]
    pub fn value(self, u: f64) -> (f64, f64) {
        Shape::new(self).value(u)
    }

    /// The slope dS/du.
    #[must_use]
    pub fn slope(self, u: f64) -> f64 {
        let shape = Shape::new(self);
        let x = shape.scale * u;
        shape.scale
            * match self {
                Self::CumulativeGauss => normal_pdf(x),
                Self::Logistic => {
                    let (seen, missed) = shape.value(u);
                    seen * missed
                }
                Self::Gumbel | Self::Weibull => (LN_2.ln() + x - LN_2 * x.exp()).exp(),
                Self::ReversedGumbel => (LN_2.ln() - x - LN_2 * (-x).exp()).exp(),
                Self::HyperbolicSecant => 1.0 / (PI * x.cosh()),
                Self::StudentT { df } => {
                    (-0.5 * (df + 1.0) * (x * x / df).ln_1p() - ln_beta(0.5 * df, 0.5)).exp() / df.sqrt()
                }
            }
    }

    /// The u at which the shape has a value strictly between 0 and 1.
    #[must_use]
    pub fn inverse(self, p: f64) -> f64 {
        own_quantile(self, p) / Shape::new(self).scale
    }

    /// Whether the shape needs levels above zero on any axis.
    pub(super) fn is_weibull(self) -> bool {
        self == Self::Weibull
    }
}

/// The argument, in the shape's own unit, at which it has the value p.
fn own_quantile(sigmoid: Sigmoid, p: f64) -> f64 {
    match sigmoid {
        Sigmoid::CumulativeGauss => normal_quantile(p),
        Sigmoid::Logistic => p.ln() - (-p).ln_1p(),
        Sigmoid::Gumbel | Sigmoid::Weibull => (-(-p).ln_1p() / LN_2).ln(),
        Sigmoid::ReversedGumbel => -(-p.ln() / LN_2).ln(),
        Sigmoid::HyperbolicSecant => (0.5 * PI * p).tan().ln(),
        Sigmoid::StudentT { df } => student_quantile(df, p),
    }
}

impl Shape {
    pub(super) fn new(sigmoid: Sigmoid) -> Self {
        let scale = match sigmoid {
            Sigmoid::CumulativeGauss => WIDTH_SCALE,
            Sigmoid::Logistic => LOGISTIC_WIDTH,
            Sigmoid::Gumbel | Sigmoid::ReversedGumbel | Sigmoid::Weibull => GUMBEL_WIDTH,
            Sigmoid::HyperbolicSecant => SECANT_WIDTH,
            Sigmoid::StudentT { df } => 2.0 * student_quantile(df, 0.95),
        };
        Self { sigmoid, scale }
    }

    #[inline]
    pub(super) fn value(&self, u: f64) -> (f64, f64) {
        let x = self.scale * u;
        let gumbel = |x: f64| {
            let survival = -LN_2 * x.exp();
            (-survival.exp_m1(), survival.exp())
        };
        match self.sigmoid {
            Sigmoid::CumulativeGauss => normal_cdf_pair(x),
            Sigmoid::Logistic => (1.0 / (1.0 + (-x).exp()), 1.0 / (1.0 + x.exp())),
            Sigmoid::Gumbel | Sigmoid::Weibull => gumbel(x),
            Sigmoid::ReversedGumbel => {
                let (above, below) = gumbel(-x);
                (below, above)
            }
            Sigmoid::HyperbolicSecant => (2.0 / PI * x.exp().atan(), 2.0 / PI * (-x).exp().atan()),
            Sigmoid::StudentT { df } => student_pair(df, x),
        }
    }

    /// u per unit of ln level of a Weibull function with this threshold and width in the level's own unit.
    ///
    /// The width falls steadily with β, so that Newton's method on ln β from Gumbel's β cannot go astray for long.
    pub(super) fn weibull_steepness(threshold: f64, width: f64) -> f64 {
        let (ln_high, ln_low) = ((20f64.ln() / LN_2).ln(), (-(0.95f64).ln() / LN_2).ln());
        let goal = width / threshold;
        // For a narrow function the width is nearly threshold · 4.07/β; for a wide one its upper end counts.
        let mut ln_beta = if goal < 2.0 { (GUMBEL_WIDTH / goal).ln() } else { (ln_high / (1.0 + goal).ln()).ln() };
        for _ in 0..60 {
            let inverse = (-ln_beta).exp();
            let (high, low) = ((ln_high * inverse).exp(), (ln_low * inverse).exp());
            let error = (high - low).ln() - goal.ln();
            let slope = -inverse * (ln_high * high - ln_low * low) / (high - low);
            let step = (error / slope).clamp(-1.0, 1.0);
            ln_beta -= step;
            if step.abs() < 1e-14 {
                break;
            }
        }
        ln_beta.exp() / GUMBEL_WIDTH
    }
}

/// Student's t in both tails.
fn student_pair(df: f64, t: f64) -> (f64, f64) {
    // The two families with closed forms are the ones that are used most.
    let tail = if df == 1.0 {
        (1.0f64).atan2(t.abs()) / PI
    } else if t == 0.0 {
        0.5
    } else {
        let square = t * t;
        // Whichever argument is away from one keeps its digits.
        if square < df {
            0.5 - 0.5 * beta_reg(0.5, 0.5 * df, square / (df + square))
        } else {
            0.5 * beta_reg(0.5 * df, 0.5, df / (df + square))
        }
    };
    if t >= 0.0 { (1.0 - tail, tail) } else { (tail, 1.0 - tail) }
}

fn student_quantile(df: f64, p: f64) -> f64 {
    let tail = p.min(1.0 - p);
    if tail >= 0.5 {
        return 0.0;
    }
    let x = inv_beta_reg(0.5 * df, 0.5, 2.0 * tail).clamp(1e-300, 1.0);
    let mut t = (df * (1.0 - x) / x).sqrt();
    // The inverse beta function is good to about eight digits; Newton's method adds the others.
    for _ in 0..4 {
        let (_, above) = student_pair(df, t);
        let density = (-0.5 * (df + 1.0) * (t * t / df).ln_1p() - ln_beta(0.5 * df, 0.5)).exp() / df.sqrt();
        let step = (above - tail) / density;
        if step.is_finite() && density > 0.0 {
            t = (t + step).max(0.0);
        }
    }
    if p < 0.5 { -t } else { t }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Sigmoid; 9] = [
        Sigmoid::CumulativeGauss,
        Sigmoid::Logistic,
        Sigmoid::Gumbel,
        Sigmoid::ReversedGumbel,
        Sigmoid::Weibull,
        Sigmoid::HyperbolicSecant,
        Sigmoid::StudentT { df: 1.0 },
        Sigmoid::StudentT { df: 2.5 },
        Sigmoid::StudentT { df: 30.0 },
    ];

    #[test]
    fn every_shape_is_half_at_its_threshold_and_as_wide_as_its_width() {
        for shape in ALL {
            let at = |u| shape.value(u).0;
            assert!((at(0.0) - 0.5).abs() < 1e-12, "{shape:?}");
            let (low, high) = (shape.inverse(0.05), shape.inverse(0.95));
            assert!((high - low - 1.0).abs() < 1e-9, "{shape:?}: {low} … {high}");
            assert!((at(low) - 0.05).abs() < 1e-10 && (at(high) - 0.95).abs() < 1e-10, "{shape:?}");
        }
    }

    #[test]
    fn inverse_undoes_value_and_slopes_are_slopes() {
        for shape in ALL {
            for i in 1..100 {
                let p = f64::from(i) / 100.0;
                let u = shape.inverse(p);
                let (seen, missed) = shape.value(u);
                assert!((seen - p).abs() < 1e-10 && (seen + missed - 1.0).abs() < 1e-12, "{shape:?} at {p}: {seen}");
                let h = 1e-5;
                let numeric = (shape.value(u + h).0 - shape.value(u - h).0) / (2.0 * h);
                assert!((shape.slope(u) - numeric).abs() < 1e-7, "{shape:?} at {p}: {} {numeric}", shape.slope(u));
            }
        }
    }

    /// Both tails to full precision: the complement of one is the other's mirror image where a shape is symmetric, and
    /// Gumbel's is the reversed one's.
    #[test]
    fn tails_keep_their_precision() {
        for shape in ALL {
            let (seen, missed) = shape.value(0.8);
            let (mirrored_seen, mirrored_missed) = match shape {
                Sigmoid::Gumbel | Sigmoid::Weibull => Sigmoid::ReversedGumbel.value(-0.8),
                Sigmoid::ReversedGumbel => Sigmoid::Gumbel.value(-0.8),
                _ => shape.value(-0.8),
            };
            assert!((missed / mirrored_seen - 1.0).abs() < 1e-12, "{shape:?}");
            assert!((seen / mirrored_missed - 1.0).abs() < 1e-12, "{shape:?}");
        }
    }

    /// Student's t: t(0.95; 5) = 2.015048373, t(0.95; 30) = 1.697260887 (any table); t(0.95; 1) = tan(0.45 π).
    #[test]
    fn students_quantiles_are_the_tables() {
        for (df, expected) in [(5.0, 2.015_048_373), (30.0, 1.697_260_887), (1.0, (0.45 * PI).tan())] {
            assert!((student_quantile(df, 0.95) - expected).abs() < 1e-8, "{df}: {}", student_quantile(df, 0.95));
        }
    }

    #[test]
    fn a_linear_weibull_is_as_wide_as_it_says() {
        for (threshold, width) in [(3.0, 0.01), (3.0, 1.0), (3.0, 4.0), (0.2, 5.0), (0.2, 500.0)] {
            let steepness = Shape::weibull_steepness(threshold, width);
            let level = |p: f64| threshold * (Sigmoid::Weibull.inverse(p) / steepness).exp();
            let found = level(0.95) - level(0.05);
            assert!((found / width - 1.0).abs() < 1e-9, "{threshold}, {width}: {found}");
        }
    }

    #[test]
    fn far_arguments_are_certain_and_never_undefined() {
        for shape in ALL {
            for u in [-1e6, -50.0, 50.0, 1e6] {
                let (seen, missed) = shape.value(u);
                assert!((0.0..=1.0).contains(&seen) && (0.0..=1.0).contains(&missed), "{shape:?} at {u}");
                assert!(shape.slope(u) >= 0.0, "{shape:?} at {u}");
            }
        }
    }
}
