//! The log posterior of a MAR fit, its gradient and its Fisher information.
//!
//! Two parametrisations meet here. *Natural*: θ = (ln m, ln omega0, ln width, λ), in which the likelihood is written.
//! *Working*: x ∈ ℝ⁴ without bounds and with a prior of about N(0, I): logarithms standardised by their priors, and
//! λ = (1 − γ)(1 − Q(z)^{1/b'}) with Q the upper tail of the normal, which turns Beta(1, b) into a standard normal.

use super::MarFitConfig;
use super::data::{Data, Ring};
use super::elementary::{Ln, NormalCdf};
use crate::numerics::{LN_SQRT_TAU, ln_add_exp, normal_pdf};
use experiments::mar::{MarModel, WIDTH_SCALE};
use nalgebra::{Matrix4, Vector4};

/// Smallest probability whose logarithm is taken; below it a cell is as impossible as a float can say.
const FLOOR: f64 = f64::MIN_POSITIVE;

/// ln ψ and ln(1 − ψ) of one cell weigh the counts; both stay finite.
#[inline]
pub(super) fn cell_ln_likelihood(ln: Ln, correct: f64, wrong: f64, guess: f64, lapse: f64, cdf: (f64, f64)) -> f64 {
    let rise = 1.0 - guess - lapse;
    let mut sum = 0.0;
    if correct > 0.0 {
        sum += correct * ln.of((guess + rise * cdf.0).max(FLOOR));
    }
    if wrong > 0.0 {
        sum += wrong * ln.of((lapse + rise * cdf.1).max(FLOOR));
    }
    sum
}

/// A log likelihood or posterior with its gradient and expected information.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scored {
    pub(super) value: f64,
    pub(super) gradient: Vector4<f64>,
    pub(super) information: Matrix4<f64>,
}

/// The posterior of one data set.
#[derive(Debug)]
pub(super) struct Posterior<'a> {
    pub(super) rings: &'a [Ring],
    pub(super) guess: f64,
    /// Prior means and standard deviations of ln m, ln omega0, ln width.
    pub(super) center: [f64; 3],
    pub(super) spread: [f64; 3],
    pub(super) lapse_beta: [f64; 2],
    lapse_power: f64,
    ln_slope_scale: f64,
    normal: NormalCdf,
    ln: Ln,
}

impl<'a> Posterior<'a> {
    pub(super) fn new(data: &'a Data, config: &MarFitConfig) -> Self {
        let priors = [config.priors.m, config.priors.omega0, config.priors.width];
        Self {
            rings: &data.rings,
            guess: config.guess,
            center: priors.map(|p| p.median.ln()),
            spread: priors.map(|p| p.sd_ln),
            lapse_beta: config.priors.lapse_beta,
            lapse_power: config.priors.lapse_beta[1] * (1.0 - config.guess),
            ln_slope_scale: -config.priors.lapse_beta[1].ln(),
            normal: NormalCdf::new(),
            ln: Ln::new(),
        }
    }

    /// θ of a working point.
    pub(super) fn natural(&self, x: &Vector4<f64>) -> Vector4<f64> {
        Vector4::new(
            self.center[0] + self.spread[0] * x[0],
            self.center[1] + self.spread[1] * x[1],
            self.center[2] + self.spread[2] * x[2],
            self.lapse(x[3]),
        )
    }

    /// The model of a working point.
    pub(super) fn model(&self, x: &Vector4<f64>) -> MarModel {
        model_from_natural(&self.natural(x))
    }

    /// λ of a working coordinate z.
    pub(super) fn lapse(&self, z: f64) -> f64 {
        self.lapse_at(self.ln_upper_tail(z))
    }

    fn lapse_at(&self, ln_q: f64) -> f64 {
        -(1.0 - self.guess) * (ln_q / self.lapse_power).exp_m1()
    }

    /// ln(dλ/dz).
    fn ln_lapse_slope(&self, z: f64, ln_q: f64) -> f64 {
        self.ln_slope_scale + ln_q / self.lapse_power - 0.5 * z * z - LN_SQRT_TAU - ln_q
    }

    /// ln(1 − Φ(z)), for |z| ≤ 37.
    fn ln_upper_tail(&self, z: f64) -> f64 {
        let (lower, upper) = self.normal.pair(z);
        if z < 0.0 { (-lower).ln_1p() } else { self.ln.of(upper.max(FLOOR)) }
    }

    /// ln prior density of λ, without its constant.
    pub(super) fn ln_lapse_prior(&self, lapse: f64) -> f64 {
        let [a, b] = self.lapse_beta;
        let rise = if a > 1.0 { (a - 1.0) * lapse.max(FLOOR).ln() } else { 0.0 };
        rise + (b - 1.0) * (-lapse).ln_1p().max(-1e4)
    }

    /// ln prior density of z, without its constant; −∞ beyond 37 standard deviations.
    pub(super) fn ln_z_prior(&self, z: f64) -> f64 {
        if z.abs() > 37.0 {
            return f64::NEG_INFINITY;
        }
        let ln_q = self.ln_upper_tail(z);
        self.ln_lapse_prior(self.lapse_at(ln_q)) + self.ln_lapse_slope(z, ln_q)
    }

    /// ln posterior density over the working coordinates, without its constant.
    pub(super) fn ln_density(&self, x: &Vector4<f64>) -> f64 {
        let z = x[3];
        if z.abs() > 37.0 {
            return f64::NEG_INFINITY;
        }
        let ln_q = self.ln_upper_tail(z);
        let lapse = self.lapse_at(ln_q);
        let prior =
            self.ln_lapse_prior(lapse) + self.ln_lapse_slope(z, ln_q) - 0.5 * (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
        let theta = Vector4::new(
            self.center[0] + self.spread[0] * x[0],
            self.center[1] + self.spread[1] * x[1],
            self.center[2] + self.spread[2] * x[2],
            lapse,
        );
        prior + self.ln_likelihood(&theta)
    }

    /// ln likelihood of θ.
    pub(super) fn ln_likelihood(&self, theta: &Vector4<f64>) -> f64 {
        let (guess, lapse, ln, normal) = (self.guess, theta[3], self.ln, self.normal);
        let scale = WIDTH_SCALE * (-theta[2]).exp();
        let mut sum = 0.0;
        for ring in self.rings {
            let ln_threshold = ln_add_exp(theta[0] + ring.ln_e, theta[1]);
            for count in &ring.counts {
                let cdf = normal.pair(scale * (count.ln_omega - ln_threshold));
                sum += cell_ln_likelihood(ln, count.correct, count.wrong, guess, lapse, cdf);
            }
        }
        sum
    }

    /// ln likelihood of θ with its gradient and expected information in θ.
    pub(super) fn scored_likelihood(&self, theta: &Vector4<f64>) -> Scored {
        let (guess, lapse, ln, normal) = (self.guess, theta[3], self.ln, self.normal);
        let rise = 1.0 - guess - lapse;
        let scale = WIDTH_SCALE * (-theta[2]).exp();
        let mut scored = Scored { value: 0.0, gradient: Vector4::zeros(), information: Matrix4::zeros() };
        for ring in self.rings {
            let ln_threshold = ln_add_exp(theta[0] + ring.ln_e, theta[1]);
            let share_m = (theta[0] + ring.ln_e - ln_threshold).exp();
            let share_omega0 = (theta[1] - ln_threshold).exp();
            for count in &ring.counts {
                let t = scale * (count.ln_omega - ln_threshold);
                let cdf = normal.pair(t);
                scored.value += cell_ln_likelihood(ln, count.correct, count.wrong, guess, lapse, cdf);

                // dψ/dθ, then the binomial score (k − nψ)/(ψ(1 − ψ)) and information n/(ψ(1 − ψ)).
                let slope = rise * normal_pdf(t);
                let t_slope = if slope > 0.0 { slope * t } else { 0.0 };
                let gradient = Vector4::new(-slope * scale * share_m, -slope * scale * share_omega0, -t_slope, -cdf.0);
                let right = (guess + rise * cdf.0).max(1e-100);
                let wrong = (lapse + rise * cdf.1).max(1e-100);
                scored.gradient += gradient * (count.correct / right - count.wrong / wrong);
                let weight = (count.correct + count.wrong) / (right * wrong);
                scored.information += gradient * gradient.transpose() * weight;
            }
        }
        scored
    }
}

pub(super) fn model_from_natural(theta: &Vector4<f64>) -> MarModel {
    MarModel { m: theta[0].exp(), omega0_deg: theta[1].exp(), width: theta[2].exp(), lapse: theta[3] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mar::MarTrial;

    fn data() -> (Data, MarFitConfig) {
        let config = MarFitConfig::default();
        let trials: Vec<MarTrial> = (0..90)
            .map(|i| MarTrial {
                eccentricity_deg: f64::from(i % 3) * 7.0,
                mar_deg: 0.02 * 1.4f64.powi(i / 9),
                correct: i % 4 != 1,
            })
            .collect();
        (Data::new(&trials, &config).expect("the trials are valid"), config)
    }

    #[test]
    fn the_likelihood_is_the_shared_models() {
        let (data, config) = data();
        let posterior = Posterior::new(&data, &config);
        let model = MarModel { m: 0.03, omega0_deg: 0.015, width: 0.9, lapse: 0.02 };
        let theta = Vector4::new(model.m.ln(), model.omega0_deg.ln(), model.width.ln(), model.lapse);
        let direct: f64 = data
            .cells
            .iter()
            .map(|cell| {
                let p = model.probability_correct(cell.eccentricity_deg, cell.mar_deg, 0.5);
                f64::from(cell.k) * p.ln() + f64::from(cell.n - cell.k) * (1.0 - p).ln()
            })
            .sum();
        assert!((posterior.ln_likelihood(&theta) - direct).abs() < 1e-9);
        assert!((posterior.scored_likelihood(&theta).value - direct).abs() < 1e-9);
    }

    #[test]
    fn the_gradient_is_the_numerical_one() {
        let (data, config) = data();
        let posterior = Posterior::new(&data, &config);
        let theta = Vector4::new(0.03f64.ln(), 0.015f64.ln(), 0.9f64.ln(), 0.02);
        let gradient = posterior.scored_likelihood(&theta).gradient;
        for i in 0..4 {
            let (mut up, mut down) = (theta, theta);
            up[i] += 1e-6;
            down[i] -= 1e-6;
            let numerical = (posterior.ln_likelihood(&up) - posterior.ln_likelihood(&down)) / 2e-6;
            assert!((gradient[i] - numerical).abs() < 1e-5 * (1.0 + numerical.abs()), "component {i}");
        }
    }

    #[test]
    fn the_working_prior_of_the_lapse_is_its_beta_density() {
        // P(λ < x) = 1 − (1 − x)^10 for Beta(1, 10), up to the cut at 1 − γ = ½ (mass 0.001).
        let (data, config) = data();
        let posterior = Posterior::new(&data, &config);
        let (mut below, mut all) = (0.0, 0.0);
        for step in -8000..8000 {
            let z = f64::from(step) * 1e-3;
            let density = posterior.ln_z_prior(z).exp();
            all += density;
            if posterior.lapse(z) < 0.07 {
                below += density;
            }
        }
        let expected = (1.0 - 0.93f64.powi(10)) / (1.0 - 0.5f64.powi(10));
        assert!((below / all - expected).abs() < 1e-3, "{} against {expected}", below / all);
    }
}
