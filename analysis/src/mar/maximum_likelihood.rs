//! Maximum likelihood, without priors, of binomial models whose thresholds follow any smooth curve over eccentricity.
//!
//! The likelihood-ratio tests of [`super::linearity`] and [`super::conditions`] stand on it. Fisher scoring with damping, in a
//! box: a parameter on its bound and pushed outwards is held there. It is not the posterior of the parent module.

use super::data::Data;
use super::elementary::{Ln, NormalCdf};
use super::posterior::cell_ln_likelihood;
use crate::numerics::normal_pdf;
use experiments::mar::WIDTH_SCALE;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// The largest lapse rate that maximum likelihood may choose: above it a psychometric function is flat enough to imitate
/// any curve.
pub const LARGEST_LAPSE: f64 = 0.25;
/// Bounds of ln width: 0.02 is a step between any two levels, 20 is flat.
pub(super) const LN_WIDTH: [f64; 2] = [-3.912_023_005_428_146, 2.995_732_273_553_991];

/// A family of threshold curves for one or more groups of trials. The last parameter is λ.
pub(super) trait Curves {
    /// Lower and upper bounds; their number is the number of parameters.
    fn bounds(&self) -> &[[f64; 2]];
    /// ln threshold of a group at an eccentricity; writes its derivatives into `gradient`, which comes zeroed.
    fn ln_threshold(&self, parameters: &[f64], group: usize, eccentricity_deg: f64, gradient: &mut [f64]) -> f64;
    /// Which parameter is the ln width of a group.
    fn width_index(&self, group: usize) -> usize;
}

/// A maximum.
#[derive(Debug, Clone)]
pub(super) struct Maximum {
    pub(super) parameters: Vec<f64>,
    pub(super) ln_likelihood: f64,
}

/// Size of a maximum-likelihood fit, for comparing models.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ModelSize {
    /// ln likelihood at its maximum, without binomial coefficients.
    pub ln_likelihood: f64,
    /// Free parameters, width and lapse rate among them.
    pub parameters: usize,
    /// Akaike's criterion, 2 p − 2 ln L.
    pub aic: f64,
    /// The Bayesian criterion, p ln n − 2 ln L, with n the trials in the likelihood.
    pub bic: f64,
}

impl ModelSize {
    pub(super) fn new(ln_likelihood: f64, parameters: usize, trials: usize) -> Self {
        let p = parameters as f64;
        Self {
            ln_likelihood,
            parameters,
            aic: 2.0 * p - 2.0 * ln_likelihood,
            bic: p * (trials.max(1) as f64).ln() - 2.0 * ln_likelihood,
        }
    }
}

/// P(χ²(df) ≥ x); 1 where nothing is tested.
pub(super) fn chi_square_p(x: f64, df: usize) -> f64 {
    if df == 0 || x <= 0.0 {
        return 1.0;
    }
    statrs::function::gamma::checked_gamma_ur(0.5 * df as f64, 0.5 * x).unwrap_or(0.0).clamp(0.0, 1.0)
}

struct Scored {
    value: f64,
    gradient: DVector<f64>,
    information: DMatrix<f64>,
}

fn scored(curves: &impl Curves, groups: &[&Data], guess: f64, parameters: &[f64]) -> Scored {
    let dims = parameters.len();
    let (ln, normal) = (Ln::new(), NormalCdf::new());
    let lapse = parameters[dims - 1];
    let rise = 1.0 - guess - lapse;
    let mut result = Scored { value: 0.0, gradient: DVector::zeros(dims), information: DMatrix::zeros(dims, dims) };
    let (mut curve, mut gradient) = (vec![0.0; dims], vec![0.0; dims]);
    for (group, data) in groups.iter().enumerate() {
        let width = curves.width_index(group);
        let scale = WIDTH_SCALE * (-parameters[width]).exp();
        for ring in &data.rings {
            curve.fill(0.0);
            let ln_threshold = curves.ln_threshold(parameters, group, ring.eccentricity_deg, &mut curve);
            for count in &ring.counts {
                let t = scale * (count.ln_omega - ln_threshold);
                let cdf = normal.pair(t);
                result.value += cell_ln_likelihood(ln, count.correct, count.wrong, guess, lapse, cdf);
                let slope = rise * normal_pdf(t);
                for (g, c) in gradient.iter_mut().zip(&curve) {
                    *g = -slope * scale * c;
                }
                gradient[width] -= if slope > 0.0 { slope * t } else { 0.0 };
                gradient[dims - 1] -= cdf.0;
                let right = (guess + rise * cdf.0).max(1e-100);
                let wrong = (lapse + rise * cdf.1).max(1e-100);
                let score = count.correct / right - count.wrong / wrong;
                let weight = (count.correct + count.wrong) / (right * wrong);
                for i in 0..dims {
                    if gradient[i] == 0.0 {
                        continue;
                    }
                    result.gradient[i] += gradient[i] * score;
                    for j in 0..=i {
                        result.information[(i, j)] += gradient[i] * gradient[j] * weight;
                    }
                }
            }
        }
    }
    for i in 0..dims {
        for j in 0..i {
            result.information[(j, i)] = result.information[(i, j)];
        }
    }
    result
}

/// The highest maximum reached from any of the starts.
pub(super) fn maximise(curves: &impl Curves, groups: &[&Data], guess: f64, starts: &[Vec<f64>]) -> Maximum {
    let mut best: Option<Maximum> = None;
    for start in starts {
        let end = climb(curves, groups, guess, start);
        if best.as_ref().is_none_or(|best| end.ln_likelihood > best.ln_likelihood) {
            best = Some(end);
        }
    }
    best.unwrap_or(Maximum { parameters: Vec::new(), ln_likelihood: 0.0 })
}

fn climb(curves: &impl Curves, groups: &[&Data], guess: f64, start: &[f64]) -> Maximum {
    let bounds = curves.bounds();
    let clamped = |x: f64, bound: &[f64; 2]| if x.is_finite() { x.clamp(bound[0], bound[1]) } else { bound[0] };
    let mut at: Vec<f64> = start.iter().zip(bounds).map(|(x, bound)| clamped(*x, bound)).collect();
    let mut current = scored(curves, groups, guess, &at);
    let mut damping = 1e-3;
    for _ in 0..400 {
        // On its bound and pushed outwards, a parameter is held.
        let mut damped = current.information.clone();
        let mut gradient = current.gradient.clone();
        for (i, bound) in bounds.iter().enumerate() {
            let held = (at[i] <= bound[0] && gradient[i] <= 0.0) || (at[i] >= bound[1] && gradient[i] >= 0.0);
            if held {
                gradient[i] = 0.0;
                damped.row_mut(i).fill(0.0);
                damped.column_mut(i).fill(0.0);
                damped[(i, i)] = 1.0;
            }
            damped[(i, i)] = damped[(i, i)] * (1.0 + damping) + 1e-9;
        }
        let Some(factor) = damped.cholesky() else { break };
        let direction = factor.solve(&gradient);
        let to: Vec<f64> =
            at.iter().zip(direction.iter()).zip(bounds).map(|((x, d), bound)| clamped(x + d, bound)).collect();
        let next = scored(curves, groups, guess, &to);
        if next.value.is_finite() && next.value >= current.value {
            let step = DVector::from_iterator(at.len(), to.iter().zip(&at).map(|(a, b)| a - b));
            let size = (&current.information * &step).dot(&step);
            let gain = next.value - current.value;
            (at, current) = (to, next);
            damping = (damping * 0.1).max(1e-12);
            if size < 1e-13 && gain < 1e-12 {
                break;
            }
        } else {
            damping = damping.max(1e-4) * 8.0;
            if damping > 1e14 {
                break;
            }
        }
    }
    Maximum { parameters: at, ln_likelihood: current.value }
}
