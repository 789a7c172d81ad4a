//! The joint posterior of one function: marginals, and any quantity that follows from the parameters.

use super::data::{Checked, checked};
use super::marginal::Marginal;
use super::maximum::maximise;
use super::posterior::{Posterior, point_of};
use super::quadrature::{Grid, integrate};
use super::{Count, Psychometric, PsychometricConfig, PsychometricError};
use crate::mar::Estimate;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Cells over which the distribution of a derived quantity is summed up.
const CELLS: usize = 4000;
/// Nodes that together hold less than this share of the posterior are left out of derived quantities.
const LEFT_OUT: f64 = 1e-6;

/// The posterior of one psychometric function, integrated over all its parameters.
///
/// [`super::fit_psychometric`] gives its summary; this gives what the summary does not have: marginal densities,
/// thresholds and slopes at any share of right answers, bands, draws.
///
/// ```
/// use analysis::psychometric::{Count, PsychometricConfig, PsychometricPosterior};
/// let counts: Vec<Count> = [19, 22, 27, 32, 37, 39, 39]
///     .iter()
///     .zip(1..)
///     .map(|(&k, level)| Count { level: f64::from(level), n: 40, k })
///     .collect();
/// let posterior = PsychometricPosterior::new(&counts, &PsychometricConfig::TWO_ALTERNATIVES)?;
/// let at_75 = posterior.threshold_at(0.75).expect("two alternatives pass through 75 %");
/// assert!(at_75.ci95[0] < at_75.estimate && at_75.estimate < at_75.ci95[1]);
/// # Ok::<(), analysis::psychometric::PsychometricError>(())
/// ```
#[derive(Debug, Clone)]
pub struct PsychometricPosterior {
    posterior: Posterior,
    data: Checked,
    grid: Grid,
    /// Of the threshold, in the axis's coordinate.
    pub threshold: Marginal,
    /// Of the natural logarithm of the width.
    pub ln_width: Marginal,
    /// Of the lapse rate.
    pub lapse: Marginal,
    /// Of the guess rate.
    pub guess: Marginal,
    /// Of η.
    pub overdispersion: Marginal,
    map: Psychometric,
    ln_density_at_map: f64,
}

impl PsychometricPosterior {
    /// Integrates the posterior of counts.
    ///
    /// # Errors
    /// When fewer than two levels have answers and no range is given, or a count, a rate or a prior is impossible.
    pub fn new(counts: &[Count], config: &PsychometricConfig) -> Result<Self, PsychometricError> {
        let data = checked(counts, config)?;
        let posterior = Posterior::new(&data, config);
        let grid = integrate(&posterior);
        let [threshold, ln_width] = [0, 1].map(|i| grid.axes[i].refined());
        let [lapse, own_guess, overdispersion] = [2, 3, 4].map(|i| grid.axes[i].dense());
        let guess = if posterior.tied() { lapse.clone() } else { own_guess };
        let (map, ln_density_at_map) = mode(&posterior, &grid, [&threshold, &ln_width]);
        Ok(Self { posterior, data, grid, threshold, ln_width, lapse, guess, overdispersion, map, ln_density_at_map })
    }

    /// The mode of the density over (threshold, width, λ, γ, η), threshold and width in the axis's coordinate.
    #[must_use]
    pub fn map(&self) -> Psychometric {
        self.map
    }

    /// The log density at the mode.
    #[must_use]
    pub fn ln_density_at_map(&self) -> f64 {
        self.ln_density_at_map
    }

    /// Posterior means. On a logarithmic axis the threshold is the exponential of the mean of its logarithm.
    #[must_use]
    pub fn mean(&self) -> Psychometric {
        Psychometric {
            threshold: self.config().scale.level(self.threshold.mean),
            width: self.grid.axes[1].mean_of(f64::exp),
            lapse: self.lapse.mean,
            guess: self.guess.mean,
            overdispersion: self.overdispersion.mean,
        }
    }

    /// The configuration.
    #[must_use]
    pub fn config(&self) -> &PsychometricConfig {
        &self.posterior.config
    }

    /// The priors as they were used, the standard ones written out.
    #[must_use]
    pub fn priors(&self) -> super::Priors {
        self.posterior.priors
    }

    /// The data, ascending in level.
    #[must_use]
    pub fn counts(&self) -> &[Count] {
        &self.data.counts
    }

    /// The log of the unnormalised density at a function, over (threshold, width, λ, γ, η); −∞ where a prior is zero.
    /// Binomial coefficients and the constants of the priors are left out.
    #[must_use]
    pub fn ln_density(&self, function: &Psychometric) -> f64 {
        self.posterior.ln_density(&self.posterior.point(function))
    }

    /// The level at which the share of right answers is `p`, with its 95 % interval; nothing if the posterior holds
    /// functions that never reach it (beyond one in a thousand).
    #[must_use]
    pub fn threshold_at(&self, p: f64) -> Option<Estimate> {
        let config = *self.config();
        let [low, middle, high] = self
            .quantiles(|f| f.level_at(p, &config).map(|level| config.scale.coordinate(level)), [0.025, 0.5, 0.975])?;
        let [low, middle, high] = [low, middle, high].map(|x| config.scale.level(x));
        Some(Estimate { estimate: middle, ci95: [low, high] })
    }

    /// The slope, right answers per unit of the level, where their share is `p`.
    #[must_use]
    pub fn slope_at(&self, p: f64) -> Option<Estimate> {
        let config = *self.config();
        let [low, middle, high] = self.quantiles(|f| f.slope_at(p, &config), [0.025, 0.5, 0.975])?;
        Some(Estimate { estimate: middle, ci95: [low, high] })
    }

    /// The share of right answers at a level: the median and the 95 % interval of the curve there.
    #[must_use]
    pub fn probability_at(&self, level: f64) -> Option<Estimate> {
        let config = *self.config();
        let quantiles = self.quantiles(|f| Some(f.probability(level, &config)), [0.025, 0.5, 0.975]);
        quantiles.map(|[low, middle, high]| Estimate { estimate: middle, ci95: [low, high] })
    }

    /// Quantiles of any quantity of the function, from the joint posterior.
    ///
    /// A quantity that is nothing for more than a thousandth of the posterior has none. Each node's mass is spread over
    /// what the quantity does within its cell, so that the result is smooth though the grid is not fine.
    #[must_use]
    pub fn quantiles<const N: usize>(
        &self,
        quantity: impl Fn(&Psychometric) -> Option<f64>,
        probabilities: [f64; N],
    ) -> Option<[f64; N]> {
        let spread = self.spread(quantity)?;
        let low = spread.iter().map(|(value, half, _)| value - half).fold(f64::INFINITY, f64::min);
        let high = spread.iter().map(|(value, half, _)| value + half).fold(f64::NEG_INFINITY, f64::max);
        if !(high - low).is_finite() {
            return None;
        }
        if high <= low {
            return Some([low; N]);
        }
        // A few far cells may stretch the range so much that the middle is coarse: look again where the mass is.
        let wide = histogram(&spread, [low, high]);
        let (near, far) = (wide.quantile(1e-4), wide.quantile(1.0 - 1e-4));
        let margin = (high - low) / CELLS as f64;
        let fine = histogram(&spread, [(near - margin).max(low), (far + margin).min(high)]);
        Some(probabilities.map(|p| fine.quantile(p)))
    }

    /// (value, half its spread within the cell, mass) at every node that counts.
    fn spread(&self, quantity: impl Fn(&Psychometric) -> Option<f64>) -> Option<Vec<(f64, f64, f64)>> {
        let [thresholds, ln_widths, lapses, guesses, _] = &self.grid.axes;
        let mut order: Vec<usize> = (0..self.grid.mass.len()).filter(|&i| self.grid.mass[i] > 0.0).collect();
        order.sort_unstable_by(|&a, &b| self.grid.mass[b].total_cmp(&self.grid.mass[a]));
        let (n_guesses, n_rates) = (guesses.nodes.len(), lapses.nodes.len() * guesses.nodes.len());
        let half = [0.5 * thresholds.weights[0], 0.5 * ln_widths.weights[0]];
        // Spreading a node's mass over its cell widens the whole by a twelfth of the cell's square; taking a twenty-fourth of
        // the second difference off beforehand makes up for it.
        let neighbours = |index: usize, stride: usize, place: usize, n: usize| {
            let below = if place > 0 { self.grid.mass[index - stride] } else { 0.0 };
            let above = if place + 1 < n { self.grid.mass[index + stride] } else { 0.0 };
            below + above
        };
        let n_widths = ln_widths.nodes.len();
        let (mut kept, mut without, mut spread) = (0.0, 0.0, Vec::new());
        for index in order {
            let own = self.grid.mass[index];
            let place = index / n_rates;
            let beside = neighbours(index, n_widths * n_rates, place / n_widths, thresholds.nodes.len())
                + neighbours(index, n_rates, place % n_widths, n_widths);
            let mass = (own - (beside - 4.0 * own) / 24.0).max(0.0);
            let (place, rate) = (index / n_rates, index % n_rates);
            let (threshold, ln_width) =
                (thresholds.nodes[place / ln_widths.nodes.len()], ln_widths.nodes[place % ln_widths.nodes.len()]);
            let (lapse, guess) = (lapses.nodes[rate / n_guesses], guesses.nodes[rate % n_guesses]);
            let at = |threshold: f64, ln_width: f64| {
                let function = self.posterior.function(&[threshold, ln_width.exp(), lapse, guess, 0.0]);
                quantity(&function).filter(|value| value.is_finite())
            };
            match at(threshold, ln_width) {
                Some(value) => {
                    let reach = |a: Option<f64>, b: Option<f64>| a.zip(b).map_or(0.0, |(a, b)| 0.5 * (b - a).abs());
                    let along_threshold = reach(at(threshold - half[0], ln_width), at(threshold + half[0], ln_width));
                    let along_width = reach(at(threshold, ln_width - half[1]), at(threshold, ln_width + half[1]));
                    spread.push((value, along_threshold.hypot(along_width), mass));
                }
                None => without += own,
            }
            kept += own;
            if without > 1e-3 || kept > 1.0 - LEFT_OUT {
                break;
            }
        }
        (without <= 1e-3 && !spread.is_empty()).then_some(spread)
    }

    /// Draws from the posterior, equally weighted; the same seed gives the same draws.
    #[must_use]
    pub fn draws(&self, n: usize, seed: u64) -> Vec<Psychometric> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let [thresholds, ln_widths, lapses, guesses, _] = &self.grid.axes;
        let (n_guesses, n_rates) = (guesses.nodes.len(), lapses.nodes.len() * guesses.nodes.len());
        let mut running = Vec::with_capacity(self.grid.mass.len());
        let mut sum = 0.0;
        for mass in &self.grid.mass {
            sum += mass;
            running.push(sum);
        }
        (0..n)
            .map(|_| {
                let index = running.partition_point(|below| *below < sum * rng.random::<f64>()).min(running.len() - 1);
                let (place, rate) = (index / n_rates, index % n_rates);
                let mut within = |axis: &super::marginal::Axis, node: usize| {
                    axis.nodes[node]
                        + axis.weights[node] * (rng.random::<f64>() - 0.5) * f64::from(u8::from(!axis.is_fixed()))
                };
                let threshold = within(thresholds, place / ln_widths.nodes.len());
                let ln_width = within(ln_widths, place % ln_widths.nodes.len());
                let lapse = within(lapses, rate / n_guesses).max(0.0);
                let guess = within(guesses, rate % n_guesses).max(0.0);
                let eta = self.overdispersion.quantile(rng.random());
                self.posterior.function(&[threshold, ln_width.exp(), lapse, guess, eta])
            })
            .collect()
    }
}

/// The masses of a derived quantity on even cells.
fn histogram(spread: &[(f64, f64, f64)], [low, high]: [f64; 2]) -> Marginal {
    let mut mass = vec![0.0; CELLS];
    let per_cell = CELLS as f64 / (high - low);
    for &(value, half, weight) in spread {
        let from = ((value - half - low) * per_cell).clamp(0.0, CELLS as f64);
        let to = ((value + half - low) * per_cell).clamp(0.0, CELLS as f64);
        let (first, last) = ((from as usize).min(CELLS - 1), (to as usize).min(CELLS - 1));
        if first == last {
            mass[first] += weight;
            continue;
        }
        // Evenly between both ends; what lies beyond the ends is in the last cells.
        let share = weight / (to - from);
        mass[first] += share * (first as f64 + 1.0 - from);
        mass[last] += share * (to - last as f64);
        mass[first + 1..last].iter_mut().for_each(|cell| *cell += share);
    }
    let total: f64 = mass.iter().sum();
    mass.iter_mut().for_each(|cell| *cell /= total);
    Marginal { ends: [low, high], mass, mean: f64::NAN, sd: f64::NAN }
}

/// The highest point of the density, from the best node of the grid.
fn mode(posterior: &Posterior, grid: &Grid, [threshold, ln_width]: [&Marginal; 2]) -> (Psychometric, f64) {
    let mut bounds = posterior.bounds();
    bounds[1] = bounds[1].map(f64::ln);
    let scale = |sd: f64, i: usize| if sd > 0.0 { sd } else { (bounds[i][1] - bounds[i][0]).max(1e-9) };
    let rate = |i: usize| {
        let [low, high] = grid.axes[i].ends;
        if high > low { (0.25 * (high - low)).max(1e-6) } else { 1.0 }
    };
    let scales = [scale(threshold.sd, 0), scale(ln_width.sd, 1), rate(2), rate(3), rate(4)];
    let density = |x: &[f64]| posterior.ln_density(&point_of(x));
    let [t, w, lapse, guess, eta] = grid.best;
    let mut best = (vec![t, w.ln(), lapse, guess, eta], f64::NEG_INFINITY);
    // A start with rates at zero finds the corner where the mode often is.
    for start in [[t, w.ln(), lapse, guess, eta], [t, w.ln(), bounds[2][0], guess, bounds[4][0]]] {
        let found = maximise(density, &start, &bounds, &scales);
        if found.1 > best.1 {
            best = found;
        }
    }
    (posterior.function(&point_of(&best.0)), best.1)
}
