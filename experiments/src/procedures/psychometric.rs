//! The shapes of psychometric functions, as procedures use them.
//!
//! Every shape is a function of u = (x − threshold) / width: ½ at threshold, and one width from 5 % to 95 %. That is the
//! parametrisation of psignifit (Schütt et al. 2016), so that thresholds and widths mean the same under each.

use crate::mar::{WIDTH_SCALE, standard_normal_cdf};
use crate::study::plan::Function;
use std::f64::consts::{FRAC_2_PI, LN_2};

/// 2 ln 19: from 5 % to 95 % of the logistic function.
const LOGISTIC_SCALE: f64 = 5.888_877_958_332_88;
/// ln(ln 0.05 / ln 0.95): from 5 % to 95 % of the Gumbel function.
const GUMBEL_SCALE: f64 = 4.067_383_949_407_112;
/// 2 ln tan(0.475 π): from 5 % to 95 % of the cumulative hyperbolic secant.
const SECANT_SCALE: f64 = 5.084_180_872_121_112;

/// The unscaled function at `u` widths above threshold, 0–1.
#[must_use]
pub fn unscaled(function: Function, u: f64) -> f64 {
    match function {
        Function::CumulativeGauss => standard_normal_cdf(WIDTH_SCALE * u),
        Function::Logistic => 1.0 / (1.0 + (-LOGISTIC_SCALE * u).exp()),
        Function::Weibull | Function::Gumbel => -(-LN_2 * (GUMBEL_SCALE * u).exp()).exp_m1(),
        Function::HyperbolicSecant => FRAC_2_PI * (SECANT_SCALE * u).exp().atan(),
    }
}

/// The width of a cumulative Gauss Φ(s (x − t)) or logistic 1 / (1 + exp(−s (x − t))) of slope s.
#[must_use]
pub fn width_from_slope(function: Function, slope: f64) -> f64 {
    let scale = match function {
        Function::CumulativeGauss => WIDTH_SCALE,
        Function::Logistic => LOGISTIC_SCALE,
        Function::Weibull | Function::Gumbel => GUMBEL_SCALE,
        Function::HyperbolicSecant => SECANT_SCALE,
    };
    scale / slope
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Function; 5] = [
        Function::CumulativeGauss,
        Function::Logistic,
        Function::Weibull,
        Function::Gumbel,
        Function::HyperbolicSecant,
    ];

    /// Half at threshold, one width from 5 % to 95 %, rising all the way.
    #[test]
    fn every_shape_has_its_threshold_and_width() {
        for function in ALL {
            assert!((unscaled(function, 0.0) - 0.5).abs() < 1e-12, "{function:?}");
            let crossing = |goal: f64| {
                let (mut low, mut high) = (-2.0, 2.0);
                for _ in 0..100 {
                    let middle = 0.5 * (low + high);
                    if unscaled(function, middle) < goal { low = middle } else { high = middle }
                }
                low
            };
            let width = crossing(0.95) - crossing(0.05);
            assert!((width - 1.0).abs() < 1e-9, "{function:?}: {width}");
            let values: Vec<f64> = (-40..=40).map(|i| unscaled(function, f64::from(i) / 20.0)).collect();
            assert!(values.windows(2).all(|pair| pair[0] <= pair[1]), "{function:?}");
            assert!(values.iter().all(|value| (0.0..=1.0).contains(value)), "{function:?}");
        }
    }

    #[test]
    fn slopes_are_those_of_the_textbook_forms() {
        let (slope, x): (f64, f64) = (2.5, 0.3);
        let at = |function| unscaled(function, x / width_from_slope(function, slope));
        assert!((at(Function::CumulativeGauss) - standard_normal_cdf(slope * x)).abs() < 1e-12);
        assert!((at(Function::Logistic) - 1.0 / (1.0 + (-slope * x).exp())).abs() < 1e-12);
    }
}
