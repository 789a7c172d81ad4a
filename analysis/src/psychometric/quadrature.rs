//! Integration of the posterior on a grid that closes in.
//!
//! Threshold and ln width lie on even grids, whose sums converge fast for a density that vanishes at both ends; the two
//! rates and η, which often pile up at zero, on Gauss–Legendre nodes.

use super::likelihood::Dispersion;
use super::marginal::Axis;
use super::posterior::{Point, Posterior};

/// Nodes in threshold, ln width, λ, γ and η, while the box closes in.
const COARSE: [usize; 5] = [20, 16, 5, 5, 4];
/// The same for the integral, with at most two of the three rates free.
const FINE: [usize; 5] = [44, 30, 10, 10, 8];
/// The same with all free.
const FINE_ALL: [usize; 5] = [36, 24, 8, 8, 8];
/// A threshold and width whose density is this much below the best in ln, at the first, middle and last node of each rate, are
/// passed over. The rates are correlated with both, so that the best node's own would not do.
const HOPELESS: f64 = 40.0;
/// The box closes in at most so often.
const MOST_PASSES: usize = 6;
/// Marginals below this share of their largest are left out of the box.
const NEGLIGIBLE: f64 = 1e-6;
/// The same for a rate, which has few nodes to spend on its tail.
const NEGLIGIBLE_RATE: f64 = 1e-5;

/// The posterior on a grid.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    /// Threshold, ln width, λ, γ, η.
    pub(super) axes: [Axis; 5],
    /// The mass of each (threshold, ln width, λ, γ), η summed over, in that order; summing to one.
    pub(super) mass: Vec<f64>,
    /// The node with the largest density.
    pub(super) best: Point,
}

/// Closes in on the posterior and sums it up.
pub(super) fn integrate(posterior: &Posterior) -> Grid {
    let mut ends = posterior.bounds();
    ends[1] = ends[1].map(f64::ln);
    for _ in 0..MOST_PASSES {
        let closer = Grid::evaluate(posterior, &ends, COARSE).closer(&ends);
        let shrunk = (0..5).any(|i| closer[i][1] - closer[i][0] < 0.8 * (ends[i][1] - ends[i][0]));
        ends = closer;
        if !shrunk {
            break;
        }
    }
    let free = ends[2..].iter().filter(|[low, high]| low < high).count();
    Grid::evaluate(posterior, &ends, if free > 2 { FINE_ALL } else { FINE })
}

impl Grid {
    fn evaluate(posterior: &Posterior, ends: &[[f64; 2]; 5], n: [usize; 5]) -> Self {
        let mut axes = [
            Axis::even(ends[0], n[0]),
            Axis::even(ends[1], n[1]),
            Axis::gauss(ends[2], n[2]),
            Axis::gauss(ends[3], n[3]),
            Axis::gauss(ends[4], n[4]),
        ];
        let likelihood = &posterior.likelihood;
        // What depends on rates or on η alone, once.
        let mut rates = Vec::with_capacity(axes[2].nodes.len() * axes[3].nodes.len());
        for (&lapse, w) in axes[2].nodes.iter().zip(&axes[2].weights) {
            for (&guess, v) in axes[3].nodes.iter().zip(&axes[3].weights) {
                let guess = posterior.guess(lapse, guess);
                rates.push((lapse, guess, posterior.ln_prior_rates(lapse, guess), (w * v).ln()));
            }
        }
        let etas: Vec<(f64, f64)> = axes[4]
            .nodes
            .iter()
            .zip(&axes[4].weights)
            .map(|(&eta, w)| (posterior.ln_prior_overdispersion(eta), w.ln()))
            .collect();
        let dispersions: Vec<Dispersion> = axes[4].nodes.iter().map(|&eta| likelihood.dispersion(eta)).collect();

        let some_of = |n: usize| if n > 2 { vec![0, n / 2, n - 1] } else { (0..n).collect() };
        let guesses = axes[3].nodes.len();
        let probes: Vec<usize> = some_of(axes[2].nodes.len())
            .into_iter()
            .flat_map(|lapse| some_of(guesses).into_iter().map(move |guess| lapse * guesses + guess))
            .collect();

        // Log mass of every node, with the Jacobian of ln width.
        let (n_rates, n_etas) = (rates.len(), etas.len());
        let mut ln_mass = Vec::with_capacity(n[0] * n[1] * n_rates * n_etas);
        let mut lanes = vec![0.0; n_etas];
        let mut seen = Vec::new();
        let mut best: (f64, Point, usize) = (f64::NEG_INFINITY, [0.0, 1.0, 0.0, 0.0, 0.0], 0);
        let mut top = f64::NEG_INFINITY;
        for &threshold in &axes[0].nodes {
            for &ln_width in &axes[1].nodes {
                let width = ln_width.exp();
                let prior = posterior.ln_prior_place(threshold, width);
                if prior == f64::NEG_INFINITY {
                    ln_mass.extend(std::iter::repeat_n(f64::NEG_INFINITY, n_rates * n_etas));
                    continue;
                }
                likelihood.fill_seen(threshold, width, &mut seen);
                // Most of the grid is far from the peak, which a few of the rates tell at once.
                if best.0 > f64::NEG_INFINITY {
                    let dispersion = &dispersions[best.2..=best.2];
                    let highest = probes.iter().fold(f64::NEG_INFINITY, |highest: f64, &rate| {
                        let (lapse, guess, ..) = rates[rate];
                        let mut probe = [0.0];
                        likelihood.ln_likelihoods(&seen, lapse, guess, dispersion, &mut probe);
                        highest.max(probe[0])
                    });
                    if prior + highest < best.0 - HOPELESS {
                        ln_mass.extend(std::iter::repeat_n(f64::NEG_INFINITY, n_rates * n_etas));
                        continue;
                    }
                }
                for &(lapse, guess, ln_prior_rates, ln_weight) in &rates {
                    likelihood.ln_likelihoods(&seen, lapse, guess, &dispersions, &mut lanes);
                    for (index, (lane, (ln_prior_eta, ln_weight_eta))) in lanes.iter().zip(&etas).enumerate() {
                        let density = prior + ln_prior_rates + ln_prior_eta + lane;
                        if density > best.0 {
                            best = (density, [threshold, width, lapse, guess, axes[4].nodes[index]], index);
                        }
                        let mass = density + ln_width + ln_weight + ln_weight_eta;
                        top = top.max(mass);
                        ln_mass.push(mass);
                    }
                }
            }
        }
        let mass = sum_up(&mut axes, &ln_mass, top);
        Self { axes, mass, best: best.1 }
    }

    fn closer(&self, ends: &[[f64; 2]; 5]) -> [[f64; 2]; 5] {
        let negligible = [NEGLIGIBLE, NEGLIGIBLE, NEGLIGIBLE_RATE, NEGLIGIBLE_RATE, NEGLIGIBLE_RATE];
        let mut closer = *ends;
        for ((ends, axis), negligible) in closer.iter_mut().zip(&self.axes).zip(negligible) {
            if !axis.is_fixed() {
                *ends = axis.closer(negligible);
            }
        }
        closer
    }
}

/// The marginals, into the axes, and the mass of each node with η summed over.
fn sum_up(axes: &mut [Axis; 5], ln_mass: &[f64], top: f64) -> Vec<f64> {
    let [_, widths, lapses, guesses, etas] = [0, 1, 2, 3, 4].map(|i| axes[i].nodes.len());
    let mut joint = Vec::with_capacity(ln_mass.len() / etas);
    for node in ln_mass.chunks_exact(etas) {
        let mut sum = 0.0;
        for (index, ln) in node.iter().enumerate() {
            // Far nodes are passed over, and e^−40 is nothing beside the others.
            if *ln > top - 40.0 {
                let mass = (ln - top).exp();
                axes[4].mass[index] += mass;
                sum += mass;
            }
        }
        joint.push(sum);
    }
    let total: f64 = joint.iter().sum();
    for (index, mass) in joint.iter_mut().enumerate() {
        *mass /= total;
        let (place, rate) = (index / (lapses * guesses), index % (lapses * guesses));
        axes[0].mass[place / widths] += *mass;
        axes[1].mass[place % widths] += *mass;
        axes[2].mass[rate / guesses] += *mass;
        axes[3].mass[rate % guesses] += *mass;
    }
    axes[4].mass.iter_mut().for_each(|mass| *mass /= total);
    joint
}
