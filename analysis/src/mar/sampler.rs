//! Integration of a posterior by population Monte Carlo on quasi-random points.
//!
//! Each round draws from a mixture of normals, weights the points by posterior over proposal (deterministic mixture
//! weights over all rounds, as in adaptive multiple importance sampling; Cornuet et al. 2012), and refits the mixture to
//! them by one weighted EM step (Cappé et al. 2008). The prior, N(0, I) in working coordinates, always stays one component,
//! so weights are bounded by the likelihood and no data set can break the integration, only slow it down.

use super::MarFitConfig;
use super::elementary::{Exp, Ln};
use super::maximum::Mode;
use super::posterior::Posterior;
use crate::numerics::normal_quantile;
use nalgebra::{Matrix4, Vector4};

/// Weighted points that stand for the posterior; weights sum to one.
#[derive(Debug, Clone)]
pub(super) struct Sample {
    pub(super) points: Vec<Vector4<f64>>,
    pub(super) weights: Vec<f64>,
}

impl Sample {
    /// Kish's effective sample size, 1/Σw².
    pub(super) fn ess(&self) -> f64 {
        effective_size(&self.weights)
    }

    /// Mean and standard deviation of one working coordinate.
    pub(super) fn moments(&self, axis: usize) -> (f64, f64) {
        let mean: f64 = self.points.iter().zip(&self.weights).map(|(x, w)| w * x[axis]).sum();
        let square: f64 = self.points.iter().zip(&self.weights).map(|(x, w)| w * (x[axis] - mean).powi(2)).sum();
        (mean, square.sqrt())
    }

    /// Indices of `n` equally weighted draws, by systematic resampling.
    pub(super) fn resample(&self, n: usize) -> Vec<usize> {
        let mut picked = Vec::with_capacity(n);
        let (mut index, mut cumulative) = (0, self.weights[0]);
        for draw in 0..n {
            let at = (draw as f64 + 0.5) / n as f64;
            while cumulative < at && index + 1 < self.weights.len() {
                index += 1;
                cumulative += self.weights[index];
            }
            picked.push(index);
        }
        picked
    }
}

/// Below this effective size another round is drawn, while rounds last.
const ENOUGH_ESS: f64 = 1000.0;
/// The most evaluations, in units of the configured draws.
const MOST: usize = 6;

/// Integrate the posterior, starting from its modes.
pub(super) fn sample(target: &Posterior<'_>, modes: &[Mode], config: &MarFitConfig) -> Sample {
    let mut points: Vec<Vector4<f64>> = Vec::new();
    let mut densities: Vec<f64> = Vec::new();
    let mut rounds: Vec<Round> = Vec::new();
    let mut sequence = Sequence::new(config.seed);
    let mut mixture = Mixture::around(modes);
    let mut size = config.draws / 4;
    loop {
        let from = points.len();
        mixture.draw(size, &mut sequence, &mut points);
        densities.extend(points[from..].iter().map(|x| target.ln_density(x)));
        // Every round's mixture is asked once about every point.
        for round in &mut rounds {
            round.ln_density.extend(points[from..].iter().map(|x| round.mixture.ln_density(x)));
        }
        let ln_density = points.iter().map(|x| mixture.ln_density(x)).collect();
        rounds.push(Round { mixture: mixture.clone(), size: points.len() - from, ln_density });

        let ln_weights = ln_mixture_weights(&densities, &rounds);
        let weights = normalised(&ln_weights, 1.0);
        let ess = effective_size(&weights);
        let total = points.len();
        let goal = ENOUGH_ESS.min(0.25 * config.draws as f64);
        if (total >= config.draws && ess >= goal) || total + size > MOST * config.draws {
            return Sample { points, weights };
        }
        let adapting = tempered(&ln_weights, 200.0);
        mixture = mixture.refitted(&points, &adapting);
        size = if rounds.len() == 1 { config.draws / 4 } else { config.draws - config.draws / 4 * 2 };
    }
}

/// A proposal, how many points it gave, and its ln density at all points so far.
struct Round {
    mixture: Mixture,
    size: usize,
    ln_density: Vec<f64>,
}

/// Weights of all points so far against the pooled proposal of all rounds.
fn ln_mixture_weights(densities: &[f64], rounds: &[Round]) -> Vec<f64> {
    let total = densities.len() as f64;
    let shares: Vec<f64> = rounds.iter().map(|round| (round.size as f64 / total).ln()).collect();
    let mut terms = vec![0.0; rounds.len()];
    let (exp, ln) = (Exp::new(), Ln::new());
    densities
        .iter()
        .enumerate()
        .map(|(index, density)| {
            for ((term, round), share) in terms.iter_mut().zip(rounds).zip(&shares) {
                *term = share + round.ln_density[index];
            }
            density - exp.ln_sum(ln, &terms)
        })
        .collect()
}

/// Kish's effective sample size, 1/Σw².
fn effective_size(weights: &[f64]) -> f64 {
    1.0 / weights.iter().map(|w| w * w).sum::<f64>()
}

/// exp(power · ln w), normalised; uniform if nothing has weight.
fn normalised(ln_weights: &[f64], power: f64) -> Vec<f64> {
    let top = ln_weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !top.is_finite() {
        return vec![1.0 / ln_weights.len() as f64; ln_weights.len()];
    }
    let mut weights: Vec<f64> = ln_weights.iter().map(|w| (power * (w - top)).exp()).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|w| *w /= sum);
    weights
}

/// Weights flattened just enough that the mixture is refitted to at least `ess` effective points.
fn tempered(ln_weights: &[f64], ess: f64) -> Vec<f64> {
    let mut power = 1.0;
    loop {
        let weights = normalised(ln_weights, power);
        if power < 0.01 || effective_size(&weights) >= ess.min(0.2 * weights.len() as f64) {
            return weights;
        }
        power *= 0.7;
    }
}

/// One normal component.
#[derive(Debug, Clone)]
struct Component {
    share: f64,
    ln_share: f64,
    mean: Vector4<f64>,
    factor: Matrix4<f64>,
    inverse: Matrix4<f64>,
    ln_scale: f64,
}

impl Component {
    fn new(share: f64, mean: Vector4<f64>, covariance: Matrix4<f64>) -> Option<Self> {
        let cholesky = covariance.cholesky()?;
        let factor = cholesky.l();
        let inverse = factor.try_inverse()?;
        let ln_scale = -(0..4).map(|i| factor[(i, i)].ln()).sum::<f64>();
        let finite = mean.iter().chain(inverse.iter()).all(|v| v.is_finite()) && ln_scale.is_finite();
        finite.then_some(Self { share, ln_share: share.ln(), mean, factor, inverse, ln_scale })
    }

    fn prior(share: f64) -> Self {
        let (factor, inverse) = (Matrix4::identity(), Matrix4::identity());
        Self { share, ln_share: share.ln(), mean: Vector4::zeros(), factor, inverse, ln_scale: 0.0 }
    }

    /// ln(share · density), without the constant 2 ln 2π that all share.
    fn ln_density(&self, x: &Vector4<f64>) -> f64 {
        let u = self.inverse * (x - self.mean);
        self.ln_share + self.ln_scale - 0.5 * u.norm_squared()
    }
}

/// A proposal: normals and, first, the prior.
#[derive(Debug, Clone)]
struct Mixture(Vec<Component>);

impl Mixture {
    /// Around the modes: one wide normal on each and two moved along its longest axis.
    fn around(modes: &[Mode]) -> Self {
        let mut components = vec![Component::prior(0.2)];
        for mode in modes {
            let eigen = mode.covariance.symmetric_eigen();
            let longest = eigen.eigenvalues.imax();
            let axis = eigen.eigenvectors.column(longest) * eigen.eigenvalues[longest].max(0.0).sqrt();
            let share = 0.8 / modes.len() as f64;
            for (part, offset, inflation) in [(0.5, 0.0, 1.5), (0.25, 1.5, 1.2), (0.25, -1.5, 1.2)] {
                let mean = mode.at + axis * offset;
                components.extend(Component::new(share * part, mean, mode.covariance * inflation));
            }
        }
        Self(components).with_shares_summing_to_one()
    }

    fn with_shares_summing_to_one(mut self) -> Self {
        let sum: f64 = self.0.iter().map(|c| c.share).sum();
        for component in &mut self.0 {
            component.share /= sum;
            component.ln_share = component.share.ln();
        }
        self
    }

    fn ln_density(&self, x: &Vector4<f64>) -> f64 {
        let mut terms = [f64::NEG_INFINITY; 16];
        for (term, component) in terms.iter_mut().zip(&self.0) {
            *term = component.ln_density(x);
        }
        Exp::new().ln_sum(Ln::new(), &terms[..self.0.len().min(16)])
    }

    /// Append `n` points, each component in proportion to its share.
    fn draw(&self, n: usize, sequence: &mut Sequence, points: &mut Vec<Vector4<f64>>) {
        let start = points.len();
        let mut cumulative = 0.0;
        for component in &self.0 {
            cumulative += component.share;
            let upto = start + (cumulative * n as f64).round() as usize;
            while points.len() < upto {
                points.push(component.mean + component.factor * sequence.next_normal());
            }
        }
    }

    /// One weighted EM step, with a floor under every covariance, and a smaller share for the prior.
    fn refitted(&self, points: &[Vector4<f64>], weights: &[f64]) -> Self {
        let (mean, covariance) = moments(points, weights);
        let mut components = vec![Component::prior(0.05)];
        let mut responsibilities = vec![vec![0.0; points.len()]; self.0.len()];
        for (index, (x, weight)) in points.iter().zip(weights).enumerate() {
            let total = self.ln_density(x);
            for (row, component) in responsibilities.iter_mut().zip(&self.0).skip(1) {
                row[index] = weight * (component.ln_density(x) - total).exp();
            }
        }
        // The prior component is kept as it is and not refitted.
        for row in responsibilities.iter().skip(1) {
            let share: f64 = row.iter().sum();
            if share < 0.01 {
                continue;
            }
            let own: Vec<f64> = row.iter().map(|r| r / share).collect();
            let (own_mean, own_covariance) = moments(points, &own);
            let floored = own_covariance * 1.1 + covariance * 0.03 + Matrix4::identity() * 1e-12;
            components.extend(Component::new(share, own_mean, floored));
        }
        // A wide copy of the whole posterior covers the tails.
        components.extend(Component::new(0.15, mean, covariance * 2.5 + Matrix4::identity() * 1e-12));
        components.truncate(16);
        Self(components).with_shares_summing_to_one()
    }
}

fn moments(points: &[Vector4<f64>], weights: &[f64]) -> (Vector4<f64>, Matrix4<f64>) {
    let mut mean = Vector4::zeros();
    for (x, w) in points.iter().zip(weights) {
        mean += x * *w;
    }
    let mut covariance = Matrix4::zeros();
    for (x, w) in points.iter().zip(weights) {
        if *w > 0.0 {
            let d = x - mean;
            covariance += d * d.transpose() * *w;
        }
    }
    (mean, covariance)
}

/// A shifted Kronecker sequence in four dimensions with the generalised golden ratio (Roberts 2018), as normals.
#[derive(Debug)]
struct Sequence {
    index: u64,
    shift: [f64; 4],
    step: [f64; 4],
}

impl Sequence {
    fn new(seed: u64) -> Self {
        // The positive root of x⁵ = x + 1.
        let root: f64 = 1.167_303_978_261_418_7;
        let mut state = seed;
        Self {
            index: 0,
            shift: std::array::from_fn(|_| uniform_from_splitmix(&mut state)),
            step: std::array::from_fn(|i| root.powi(-(i as i32) - 1)),
        }
    }

    fn next_normal(&mut self) -> Vector4<f64> {
        self.index += 1;
        let n = self.index as f64;
        Vector4::from_fn(|i, _| {
            let u = (self.shift[i] + n * self.step[i]).fract();
            normal_quantile(u.clamp(1e-12, 1.0 - 1e-12))
        })
    }
}

/// SplitMix64 (Steele et al. 2014), as a number in 0..1.
fn uniform_from_splitmix(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut x = *state;
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^= x >> 31;
    (x >> 11) as f64 / (1u64 << 53) as f64
}
