//! Markov chains over a population of observers: the exact posterior, for any number of pooled coordinates.
//!
//! An observer's coordinates are `D` numbers, of which the last is the working lapse z with its own fixed prior and the
//! others are normal in the population, independently of each other. One iteration (a) redraws every observer, by an
//! independence proposal from the normal approximation of their conditional posterior and by a random walk in its metric,
//! (b) redraws population SDs with the means integrated out, then the means, and (c) moves the means with the observers'
//! deviations held, and one SD with the standardised observers held (the ancillary half of an interweaving, Yu & Meng
//! 2011), without which chains stick where SDs are small against what single observers tell.

use super::super::posterior::Posterior;
use nalgebra::{Cholesky, Const, SMatrix, SVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// One observer's likelihood: one posterior target per condition, and where each condition lies between −½ and ½.
#[derive(Debug)]
pub(in super::super) struct Observer<'a> {
    /// (target, offset): a condition's θ is x[0..3] + offset · x[3..6]; with D = 4 the offset is 0.
    pub(in super::super) conditions: Vec<(Posterior<'a>, f64)>,
}

impl Observer<'_> {
    /// θ = (ln m, ln omega0, ln width, λ) in one condition.
    fn theta<const D: usize>(target: &Posterior<'_>, offset: f64, x: &SVector<f64, D>) -> nalgebra::Vector4<f64> {
        let mut theta = nalgebra::Vector4::new(x[0], x[1], x[2], target.lapse(x[D - 1].clamp(-37.0, 37.0)));
        if D > 4 {
            for axis in 0..3 {
                theta[axis] += offset * x[3 + axis];
            }
        }
        theta
    }

    fn ln_likelihood<const D: usize>(&self, x: &SVector<f64, D>) -> f64 {
        self.conditions.iter().map(|(target, offset)| target.ln_likelihood(&Self::theta(target, *offset, x))).sum()
    }

    fn ln_lapse_prior(&self, z: f64) -> f64 {
        self.conditions.first().map_or(-0.5 * z * z, |(target, _)| target.ln_z_prior(z))
    }

    /// Gradient and expected information of the likelihood.
    fn scored<const D: usize>(&self, x: &SVector<f64, D>) -> (SVector<f64, D>, SMatrix<f64, D, D>) {
        let mut gradient = SVector::<f64, D>::zeros();
        let mut information = SMatrix::<f64, D, D>::zeros();
        for (target, offset) in &self.conditions {
            let z = x[D - 1].clamp(-36.0, 36.0);
            let slope = (target.lapse(z + 1e-4) - target.lapse(z - 1e-4)) / 2e-4;
            let mut jacobian = SMatrix::<f64, 4, D>::zeros();
            for axis in 0..3 {
                jacobian[(axis, axis)] = 1.0;
                if D > 4 {
                    jacobian[(axis, 3 + axis)] = *offset;
                }
            }
            jacobian[(3, D - 1)] = slope;
            let scored = target.scored_likelihood(&Self::theta(target, *offset, x));
            gradient += jacobian.transpose() * scored.gradient;
            information += jacobian.transpose() * scored.information * jacobian;
        }
        (gradient, information)
    }
}

/// The population's priors: means are normal, SDs half-t; the last entry of each, the lapse's, is not used.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Population<const D: usize> {
    pub(in super::super) center: SVector<f64, D>,
    pub(in super::super) spread: SVector<f64, D>,
    pub(in super::super) sd_scale: SVector<f64, D>,
    pub(in super::super) sd_df: f64,
}

impl<const D: usize> Population<D> {
    fn ln_sd_prior(&self, axis: usize, sd: f64) -> f64 {
        let u = sd / self.sd_scale[axis];
        -0.5 * (self.sd_df + 1.0) * (u * u / self.sd_df).ln_1p()
    }

    fn ln_mean_prior(&self, axis: usize, mean: f64) -> f64 {
        -0.5 * ((mean - self.center[axis]) / self.spread[axis]).powi(2)
    }
}

/// How long chains run.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Length {
    pub(in super::super) warmup: usize,
    pub(in super::super) draws: usize,
}

/// What one chain kept: per draw the population and every observer.
#[derive(Debug, Clone)]
pub(in super::super) struct Chain<const D: usize> {
    pub(in super::super) mean: Vec<SVector<f64, D>>,
    pub(in super::super) sd: Vec<SVector<f64, D>>,
    /// `[draw][observer]`
    pub(in super::super) observers: Vec<Vec<SVector<f64, D>>>,
}

/// Normal approximation of one observer's likelihood: exp(linear·x − ½ xᵀ information x), and the running mean on which
/// it is centred anew during warm-up.
struct Approximation<const D: usize> {
    linear: SVector<f64, D>,
    information: SMatrix<f64, D, D>,
    sum: SVector<f64, D>,
    count: f64,
}

impl<const D: usize> Approximation<D> {
    fn at(observer: &Observer<'_>, x: &SVector<f64, D>) -> Self {
        let (gradient, information) = observer.scored(x);
        let linear = gradient + information * x;
        let sound = linear.iter().chain(information.iter()).all(|v| v.is_finite() && v.abs() < 1e15);
        let (linear, information) = if sound { (linear, information) } else { (SVector::zeros(), SMatrix::zeros()) };
        Self { linear, information, sum: SVector::zeros(), count: 0.0 }
    }
}

/// Degrees of freedom of the independence proposal: its tails must be heavier than the posterior's.
const PROPOSAL_DF: usize = 4;

struct Walker<'a, const D: usize> {
    observers: &'a [Observer<'a>],
    population: &'a Population<D>,
    rng: ChaCha8Rng,
    spare: Option<f64>,
    x: Vec<SVector<f64, D>>,
    ln_likelihood: Vec<f64>,
    mean: SVector<f64, D>,
    sd: SVector<f64, D>,
    approximations: Vec<Approximation<D>>,
    /// ln of the step of an SD's logarithm, per coordinate.
    ln_step: SVector<f64, D>,
}

/// Run one chain from `starts` (one point per observer); `index` spreads the starting SDs.
pub(in super::super) fn run_chain<const D: usize>(
    observers: &[Observer<'_>],
    population: &Population<D>,
    starts: &[SVector<f64, D>],
    length: Length,
    seed: u64,
    index: usize,
) -> Chain<D> {
    let mut walker = Walker::new(observers, population, starts, seed, index);
    let mut chain = Chain { mean: Vec::new(), sd: Vec::new(), observers: Vec::new() };
    for iteration in 0..length.warmup + length.draws {
        let warming = iteration < length.warmup;
        walker.redraw_observers(iteration, warming);
        walker.redraw_population();
        if iteration.is_multiple_of(2) {
            walker.move_means();
        } else {
            walker.nudge_mean(iteration / 2 % (D - 1));
        }
        for axis in [iteration % (D - 1), (iteration + 1) % (D - 1)] {
            walker.scale_deviations(axis, warming.then_some(iteration));
        }
        if warming && [length.warmup / 5, length.warmup / 2].contains(&iteration) {
            walker.recentre();
        }
        if !warming {
            chain.mean.push(walker.mean);
            chain.sd.push(walker.sd);
            chain.observers.push(walker.x.clone());
        }
    }
    chain
}

impl<'a, const D: usize> Walker<'a, D> {
    fn new(
        observers: &'a [Observer<'a>],
        population: &'a Population<D>,
        starts: &[SVector<f64, D>],
        seed: u64,
        index: usize,
    ) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(index as u64 + 1);
        let x = starts.to_vec();
        let n = x.len().max(1) as f64;
        let mean = x.iter().sum::<SVector<f64, D>>() / n;
        let mut sd = SVector::<f64, D>::repeat(1.0);
        for axis in 0..D - 1 {
            let square = x.iter().map(|x| (x[axis] - mean[axis]).powi(2)).sum::<f64>() / n;
            sd[axis] = (0.5 * square.sqrt() + 0.25 * population.sd_scale[axis]) * [0.5, 1.0, 1.5, 2.0][index % 4];
        }
        Self {
            ln_likelihood: observers.iter().zip(&x).map(|(o, x)| o.ln_likelihood(x)).collect(),
            approximations: observers.iter().zip(&x).map(|(o, x)| Approximation::at(o, x)).collect(),
            ln_step: SVector::repeat(-1.0),
            spare: None,
            observers,
            population,
            rng,
            x,
            mean,
            sd,
        }
    }

    /// A standard normal number (Marsaglia's polar method).
    fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        loop {
            let (a, b) = (2.0 * self.rng.random::<f64>() - 1.0, 2.0 * self.rng.random::<f64>() - 1.0);
            let square = a * a + b * b;
            if square > 0.0 && square < 1.0 {
                let scale = (-2.0 * square.ln() / square).sqrt();
                self.spare = Some(b * scale);
                return a * scale;
            }
        }
    }

    fn accepts(&mut self, ln_ratio: f64) -> bool {
        // A NaN is never accepted.
        ln_ratio >= 0.0 || self.rng.random::<f64>() < ln_ratio.exp()
    }

    /// ln prior of one observer's coordinates given the population.
    fn ln_prior(&self, observer: usize, x: &SVector<f64, D>) -> f64 {
        let mut sum = self.observers[observer].ln_lapse_prior(x[D - 1]);
        for axis in 0..D - 1 {
            sum -= 0.5 * ((x[axis] - self.mean[axis]) / self.sd[axis]).powi(2);
        }
        sum
    }

    fn redraw_observers(&mut self, iteration: usize, warming: bool) {
        let mut precision = SVector::<f64, D>::repeat(1.0);
        for axis in 0..D - 1 {
            precision[axis] = self.sd[axis].powi(-2);
        }
        let pull = precision.component_mul(&self.mean);
        for observer in 0..self.x.len() {
            let approximation = &self.approximations[observer];
            let mut linear = approximation.linear + pull;
            linear[D - 1] = approximation.linear[D - 1];
            let Some(factor) = (approximation.information + SMatrix::from_diagonal(&precision)).cholesky() else {
                continue;
            };
            let center = factor.solve(&linear);
            let mut ln_prior = self.ln_prior(observer, &self.x[observer]);

            // Independence: from the approximation itself, with Student's tails.
            let from = self.x[observer];
            let (to, ln_ratio) = self.propose(&factor, &center, &from, D);
            self.try_move(observer, to, &mut ln_prior, ln_ratio);

            // Random walk now and then: where the likelihood is far from normal it still moves.
            if (iteration + observer).is_multiple_of(2) {
                let size = 2.0 / (D as f64).sqrt() * (0.7 * self.normal()).exp();
                let to = self.x[observer] + self.step(&factor) * size;
                self.try_move(observer, to, &mut ln_prior, 0.0);
            }

            if warming {
                let x = self.x[observer];
                self.approximations[observer].sum += x;
                self.approximations[observer].count += 1.0;
            }
        }
    }

    /// A normal step with the inverse of the factored matrix as covariance.
    fn step(&mut self, factor: &Cholesky<f64, Const<D>>) -> SVector<f64, D> {
        let noise = SVector::<f64, D>::from_fn(|_, _| self.normal());
        factor.l_dirty().tr_solve_lower_triangular(&noise).unwrap_or_else(SVector::zeros)
    }

    /// Metropolis–Hastings; `ln_proposal` is ln q(to) − ln q(from).
    fn try_move(&mut self, observer: usize, to: SVector<f64, D>, ln_prior: &mut f64, ln_proposal: f64) {
        let prior = self.ln_prior(observer, &to);
        if prior == f64::NEG_INFINITY {
            return;
        }
        let likelihood = self.observers[observer].ln_likelihood(&to);
        let ratio = likelihood + prior - self.ln_likelihood[observer] - *ln_prior - ln_proposal;
        if self.accepts(ratio) {
            self.x[observer] = to;
            self.ln_likelihood[observer] = likelihood;
            *ln_prior = prior;
        }
    }

    /// Centre every approximation on the observer's mean so far.
    fn recentre(&mut self) {
        for (approximation, observer) in self.approximations.iter_mut().zip(self.observers) {
            let at = approximation.sum / approximation.count.max(1.0);
            *approximation = Approximation::at(observer, &at);
        }
    }

    /// SDs by slice sampling of ln SD with the mean integrated out; then the means, normal.
    fn redraw_population(&mut self) {
        let n = self.x.len() as f64;
        for axis in 0..D - 1 {
            let average = self.x.iter().map(|x| x[axis]).sum::<f64>() / n;
            let square = self.x.iter().map(|x| (x[axis] - average).powi(2)).sum::<f64>();
            let (center, spread) = (self.population.center[axis], self.population.spread[axis]);
            let population = *self.population;
            let ln_density = |ln_sd: f64| {
                let sd = ln_sd.exp();
                let around = spread * spread + sd * sd / n;
                population.ln_sd_prior(axis, sd) + ln_sd
                    - (n - 1.0) * ln_sd
                    - 0.5 * square / (sd * sd)
                    - 0.5 * (average - center).powi(2) / around
                    - 0.5 * around.ln()
            };
            let ln_sd = self.slice(self.sd[axis].ln(), ln_density);
            self.sd[axis] = ln_sd.exp();
            let precision = n * (-2.0 * ln_sd).exp() + spread.powi(-2);
            let mean = (average * n * (-2.0 * ln_sd).exp() + center * spread.powi(-2)) / precision;
            self.mean[axis] = mean + self.normal() / precision.sqrt();
        }
    }

    /// One slice-sampling update with stepping out (Neal 2003), within ln SD of −14 … 7.
    fn slice(&mut self, from: f64, ln_density: impl Fn(f64) -> f64) -> f64 {
        const WIDTH: f64 = 1.0;
        let (least, most) = (-14.0, 7.0);
        let from = from.clamp(least, most);
        let level = ln_density(from) + (1.0 - self.rng.random::<f64>()).ln();
        let mut low = from - WIDTH * self.rng.random::<f64>();
        let mut high = low + WIDTH;
        for _ in 0..24 {
            if low <= least || ln_density(low) <= level {
                break;
            }
            low -= WIDTH;
        }
        for _ in 0..24 {
            if high >= most || ln_density(high) <= level {
                break;
            }
            high += WIDTH;
        }
        (low, high) = (low.max(least), high.min(most));
        for _ in 0..200 {
            let at = low + (high - low) * self.rng.random::<f64>();
            if ln_density(at) > level {
                return at;
            }
            if at < from {
                low = at;
            } else {
                high = at;
            }
        }
        from
    }

    /// Move all means at once with the observers' deviations from them held: x' = mean' + (x − mean).
    ///
    /// In (mean, deviations) coordinates the observers' prior does not change, so that only the likelihood and the means'
    /// priors decide. The proposal is the sum of the observers' normal approximations.
    fn move_means(&mut self) {
        let mut precision = SMatrix::<f64, D, D>::zeros();
        let mut linear = SVector::<f64, D>::zeros();
        let mut mean = self.mean;
        mean[D - 1] = 0.0;
        for (approximation, x) in self.approximations.iter().zip(&self.x) {
            precision += approximation.information;
            linear += approximation.linear - approximation.information * (x - mean);
        }
        for axis in 0..D - 1 {
            precision[(axis, axis)] += self.population.spread[axis].powi(-2);
            linear[axis] += self.population.center[axis] * self.population.spread[axis].powi(-2);
        }
        // The lapses stay.
        precision.row_mut(D - 1).fill(0.0);
        precision.column_mut(D - 1).fill(0.0);
        precision[(D - 1, D - 1)] = 1.0;
        linear[D - 1] = 0.0;
        let Some(factor) = precision.cholesky() else { return };
        let center = factor.solve(&linear);
        let (mut to, ln_ratio) = self.propose(&factor, &center, &mean, D - 1);
        let moved: Vec<SVector<f64, D>> = self.x.iter().map(|x| x - mean + to).collect();
        let ln_prior = |mean: &SVector<f64, D>| {
            (0..D - 1).map(|axis| self.population.ln_mean_prior(axis, mean[axis])).sum::<f64>()
        };
        let prior = ln_prior(&to) - ln_prior(&mean);
        if let Some(likelihoods) = self.accepted(&moved, prior - ln_ratio).0 {
            self.x = moved;
            self.ln_likelihood = likelihoods;
            to[D - 1] = self.mean[D - 1];
            self.mean = to;
        }
    }

    /// Move one mean by a random walk of many step sizes, deviations held: the normal approximations end where a parameter
    /// hardly matters any more, as omega0 does far below every level.
    fn nudge_mean(&mut self, axis: usize) {
        let unit =
            self.population.sd_scale[axis].max(0.3 * self.population.spread[axis]) / (self.x.len() as f64).sqrt();
        let step = unit * self.normal().exp() * self.normal();
        let mut moved = self.x.clone();
        for x in &mut moved {
            x[axis] += step;
        }
        let mean = self.mean[axis];
        let prior = self.population.ln_mean_prior(axis, mean + step) - self.population.ln_mean_prior(axis, mean);
        if let Some(likelihoods) = self.accepted(&moved, prior).0 {
            self.x = moved;
            self.ln_likelihood = likelihoods;
            self.mean[axis] += step;
        }
    }

    /// Move one coordinate's SD with the *standardised* observers held: x' = mean + sd' (x − mean)/sd; the Jacobian is that
    /// of ln SD.
    fn scale_deviations(&mut self, axis: usize, adapting: Option<usize>) {
        // Steps of many sizes: an SD near 0 may move far in its logarithm, a large one may not.
        let step = (self.ln_step[axis] + self.normal()).exp() * self.normal();
        let (mean, from) = (self.mean[axis], self.sd[axis]);
        let sd = from * step.clamp(-20.0, 20.0).exp();
        let mut ratio = f64::NEG_INFINITY;
        if (1e-7..1e3).contains(&sd) {
            let mut moved = self.x.clone();
            for x in &mut moved {
                x[axis] = mean + sd * (x[axis] - mean) / from;
            }
            let prior =
                self.population.ln_sd_prior(axis, sd) - self.population.ln_sd_prior(axis, from) + (sd / from).ln();
            let (likelihoods, at) = self.accepted(&moved, prior);
            ratio = at;
            if let Some(likelihoods) = likelihoods {
                self.x = moved;
                self.ln_likelihood = likelihoods;
                self.sd[axis] = sd;
            }
        }
        if let Some(iteration) = adapting {
            let rate = if ratio.is_finite() { ratio.min(0.0).exp() } else { 0.0 };
            let gain = 2.0 / (1.0 + iteration as f64 / 10.0).sqrt();
            self.ln_step[axis] = (self.ln_step[axis] + gain * (rate - 0.4)).clamp(-6.0, 2.0);
        }
    }

    /// The likelihoods of all observers at `moved`, if the move is accepted, and the ln ratio; `ln_other` is the ratio's
    /// part beside the likelihood.
    fn accepted(&mut self, moved: &[SVector<f64, D>], ln_other: f64) -> (Option<Vec<f64>>, f64) {
        let likelihoods: Vec<f64> =
            self.observers.iter().zip(moved).map(|(observer, x)| observer.ln_likelihood(x)).collect();
        let gain: f64 = likelihoods.iter().zip(&self.ln_likelihood).map(|(new, old)| new - old).sum();
        let ratio = gain + ln_other;
        (self.accepts(ratio).then_some(likelihoods), ratio)
    }

    /// A Student step around `center` with the inverse of the factored matrix as scale, and ln q(to) − ln q(from). Only the
    /// first `dims` coordinates move; the others, on which the matrix must be diagonal, stay at the centre.
    fn propose(
        &mut self,
        factor: &Cholesky<f64, Const<D>>,
        center: &SVector<f64, D>,
        from: &SVector<f64, D>,
        dims: usize,
    ) -> (SVector<f64, D>, f64) {
        let chi_square: f64 = (0..PROPOSAL_DF).map(|_| self.normal().powi(2)).sum();
        let df = PROPOSAL_DF as f64;
        let mut to = center + self.step(factor) * (df / chi_square.max(1e-12)).sqrt();
        for axis in dims..D {
            to[axis] = center[axis];
        }
        let lower = factor.l();
        let ln_density = |x: &SVector<f64, D>| {
            let distance = lower.tr_mul(&(x - center)).norm_squared();
            -0.5 * (df + dims as f64) * (distance / df).ln_1p()
        };
        (to, ln_density(&to) - ln_density(from))
    }
}
