//! Integration of the posterior on a grid that closes in, and the search for its mode.
//!
//! Threshold and ln width lie on even grids, whose sums converge fast for a density that vanishes at both ends; the two
//! rates, which often pile up at zero, on Gauss–Legendre nodes.

use super::Psychometric;
use super::posterior::Posterior;
use std::f64::consts::PI;

/// Nodes in threshold, ln width, and each rate, while the box closes in.
const COARSE: [usize; 4] = [24, 16, 5, 5];
/// The same for the integral, with γ fixed.
const FINE: [usize; 4] = [64, 40, 8, 1];
/// The same with γ free.
const FINE_FREE: [usize; 4] = [44, 28, 6, 8];
/// A threshold and width whose density is this much below the best in ln, at the best node's rates, are passed over.
const HOPELESS: f64 = 60.0;
/// Cells of a rate's marginal for its quantiles.
const DENSE: usize = 301;
/// The box closes in at most so often.
const MOST_PASSES: usize = 5;
/// Marginals below this share of their largest are left out of the box.
const NEGLIGIBLE: f64 = 1e-6;
/// The same for a rate, which has few nodes to spend on its tail.
const NEGLIGIBLE_RATE: f64 = 1e-4;

/// What the integral gives: 2.5 %, 50 % and 97.5 % of each parameter, and the mode, in the axis's rising coordinate.
#[derive(Debug)]
pub(super) struct Integrated {
    pub(super) threshold: [f64; 3],
    pub(super) width: [f64; 3],
    pub(super) lapse: [f64; 3],
    pub(super) guess: [f64; 3],
    pub(super) mode: Psychometric,
}

pub(super) fn integrate(posterior: &Posterior) -> Integrated {
    let mut ends = [posterior.thresholds(), posterior.widths().map(f64::ln), posterior.lapses(), posterior.guesses()];
    for _ in 0..MOST_PASSES {
        let closer = Grid::evaluate(posterior, &ends, COARSE).closer(&ends);
        let shrunk = (0..4).any(|i| closer[i][1] - closer[i][0] < 0.8 * (ends[i][1] - ends[i][0]));
        ends = closer;
        if !shrunk {
            break;
        }
    }
    let grid = Grid::evaluate(posterior, &ends, if posterior.guess_is_free() { FINE_FREE } else { FINE });
    let quantiles = [0.025, 0.5, 0.975];
    let guess =
        if posterior.guess_is_free() { grid.axes[3].dense().quantiles(quantiles) } else { [posterior.guesses()[0]; 3] };
    Integrated {
        threshold: grid.axes[0].refined().quantiles(quantiles),
        width: grid.axes[1].refined().quantiles(quantiles).map(f64::exp),
        lapse: grid.axes[2].dense().quantiles(quantiles),
        guess,
        mode: mode(posterior, grid.best, &ends),
    }
}

/// One parameter: its nodes, what each stands for, and the marginal density there.
#[derive(Debug)]
struct Marginal {
    ends: [f64; 2],
    nodes: Vec<f64>,
    weights: Vec<f64>,
    /// Mass at each node, summing to one.
    mass: Vec<f64>,
}

impl Marginal {
    /// Middles of even cells.
    fn even(ends: [f64; 2], n: usize) -> Self {
        let step = (ends[1] - ends[0]) / n as f64;
        let nodes = (0..n).map(|i| ends[0] + (i as f64 + 0.5) * step).collect();
        Self { ends, nodes, weights: vec![step; n], mass: vec![0.0; n] }
    }

    /// Gauss–Legendre nodes; one node for a fixed value.
    fn gauss(ends: [f64; 2], n: usize) -> Self {
        let half = 0.5 * (ends[1] - ends[0]);
        if half <= 0.0 {
            return Self { ends, nodes: vec![ends[0]], weights: vec![1.0], mass: vec![0.0] };
        }
        let (nodes, weights) = legendre(n);
        Self {
            ends,
            nodes: nodes.iter().map(|x| ends[0] + half * (1.0 + x)).collect(),
            weights: weights.iter().map(|w| half * w).collect(),
            mass: vec![0.0; n],
        }
    }

    /// The ends beyond which the density is negligible, one node to spare.
    fn closer(&self, negligible: f64) -> [f64; 2] {
        let density: Vec<f64> = self.mass.iter().zip(&self.weights).map(|(mass, weight)| mass / weight).collect();
        let least = negligible * density.iter().copied().fold(0.0, f64::max);
        let first = density.iter().position(|&d| d > least).unwrap_or(0);
        let last = density.iter().rposition(|&d| d > least).unwrap_or(density.len() - 1);
        [
            if first == 0 { self.ends[0] } else { self.nodes[first - 1] },
            self.nodes.get(last + 1).copied().unwrap_or(self.ends[1]),
        ]
    }

    /// A marginal on Gauss–Legendre nodes on even cells. The logarithm of the density is interpolated, which is nearly a
    /// parabola and cannot ripple below zero (Berrut and Trefethen 2004, Eq. 5.4 for the weights).
    fn dense(&self) -> Self {
        let n = self.nodes.len();
        let half = 0.5 * (self.ends[1] - self.ends[0]);
        let middle = 0.5 * (self.ends[1] + self.ends[0]);
        let barycentric: Vec<f64> = (0..n)
            .map(|i| {
                let x = (self.nodes[i] - middle) / half;
                let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
                sign * ((1.0 - x * x) * self.weights[i]).sqrt()
            })
            .collect();
        let densities: Vec<f64> = self.mass.iter().zip(&self.weights).map(|(mass, weight)| mass / weight).collect();
        let top = densities.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let ln: Vec<f64> = densities.iter().map(|density| (density / top).max(1e-30).ln()).collect();
        let mut dense = Self::even(self.ends, DENSE);
        for (mass, &x) in dense.mass.iter_mut().zip(&dense.nodes) {
            let (mut above, mut below) = (0.0, 0.0);
            for i in 0..n {
                let share = barycentric[i] / (x - self.nodes[i]);
                above += share * ln[i];
                below += share;
            }
            // A cell's middle may be a node, where the quotient is not defined.
            let at_node = self.nodes.iter().position(|node| (x - node).abs() < 1e-12).map(|i| ln[i]);
            *mass = at_node.unwrap_or(above / below).min(3.0).exp();
        }
        let total: f64 = dense.mass.iter().sum();
        dense.mass.iter_mut().for_each(|mass| *mass /= total);
        dense
    }

    /// A marginal on even cells, each split into eight along the slope to its neighbours.
    fn refined(&self) -> Self {
        const SPLIT: usize = 8;
        let mut refined = Self::even(self.ends, SPLIT * self.nodes.len());
        for (index, mass) in refined.mass.iter_mut().enumerate() {
            let (cell, part) = (index / SPLIT, index % SPLIT);
            let at = |i: Option<usize>| i.and_then(|i| self.mass.get(i)).copied().unwrap_or(self.mass[cell]);
            let slope = 0.5 * (at(Some(cell + 1)) - at(cell.checked_sub(1)));
            let offset = (part as f64 + 0.5) / SPLIT as f64 - 0.5;
            // Beside a cell that is far larger the slope would go below zero.
            *mass = (self.mass[cell] + slope * offset).max(0.0) / SPLIT as f64;
        }
        let total: f64 = refined.mass.iter().sum();
        refined.mass.iter_mut().for_each(|mass| *mass /= total);
        refined
    }

    /// Quantiles of the marginal; the mass of a node is spread evenly over its share of the axis.
    fn quantiles<const N: usize>(&self, probabilities: [f64; N]) -> [f64; N] {
        // The running sum of weights reaches the far end exactly, so that shares tile the axis.
        let mut result = [self.ends[1]; N];
        let (mut edge, mut sum, mut next) = (self.ends[0], 0.0, 0);
        for (mass, weight) in self.mass.iter().zip(&self.weights) {
            while next < N && probabilities[next] <= sum + mass && *mass > 0.0 {
                result[next] = edge + weight * (probabilities[next] - sum) / mass;
                next += 1;
            }
            edge += weight;
            sum += mass;
        }
        result
    }
}

/// The posterior on a grid, as the marginals of its four parameters.
#[derive(Debug)]
struct Grid {
    axes: [Marginal; 4],
    /// The node with the largest density.
    best: Psychometric,
}

impl Grid {
    fn evaluate(posterior: &Posterior, ends: &[[f64; 2]; 4], n: [usize; 4]) -> Self {
        let mut axes = [
            Marginal::even(ends[0], n[0]),
            Marginal::even(ends[1], n[1]),
            Marginal::gauss(ends[2], n[2]),
            Marginal::gauss(ends[3], n[3]),
        ];
        let rates = axes[2].nodes.len() * axes[3].nodes.len();
        let mut ln_rates = Vec::with_capacity(rates);
        for (lapse, w) in axes[2].nodes.iter().zip(&axes[2].weights) {
            for (guess, v) in axes[3].nodes.iter().zip(&axes[3].weights) {
                ln_rates.push((*lapse, *guess, posterior.ln_prior_rates(*lapse, *guess), (w * v).ln()));
            }
        }

        // Log mass of every node, with the Jacobian of ln width.
        let mut ln_mass = Vec::with_capacity(axes[0].nodes.len() * axes[1].nodes.len() * rates);
        let mut seen = Vec::new();
        let (lapse, guess) = (axes[2].nodes[0], axes[3].nodes[0]);
        let mut best = (f64::NEG_INFINITY, Psychometric { threshold: 0.0, width: 1.0, lapse, guess });
        let mut top = f64::NEG_INFINITY;
        for &threshold in &axes[0].nodes {
            for &ln_width in &axes[1].nodes {
                let width = ln_width.exp();
                let prior = posterior.ln_prior_place(threshold, width);
                posterior.fill_seen(threshold, width, &mut seen);
                // Most of the grid is far from the peak, which the rates of the best node so far tell at once.
                let probe = prior + posterior.ln_likelihood(&seen, best.1.lapse, best.1.guess);
                if probe < best.0 - HOPELESS {
                    ln_mass.extend(std::iter::repeat_n(f64::NEG_INFINITY, rates));
                    continue;
                }
                for &(lapse, guess, ln_prior, ln_weight) in &ln_rates {
                    let density = prior + ln_prior + posterior.ln_likelihood(&seen, lapse, guess);
                    if density > best.0 {
                        best = (density, Psychometric { threshold, width, lapse, guess });
                    }
                    let mass = density + ln_width + ln_weight;
                    top = top.max(mass);
                    ln_mass.push(mass);
                }
            }
        }

        let total: f64 = ln_mass.iter().map(|mass| (mass - top).exp()).sum();
        let guesses = axes[3].nodes.len();
        let widths = axes[1].nodes.len();
        for (index, mass) in ln_mass.iter().enumerate() {
            let mass = (mass - top).exp() / total;
            let (place, rate) = (index / rates, index % rates);
            axes[0].mass[place / widths] += mass;
            axes[1].mass[place % widths] += mass;
            axes[2].mass[rate / guesses] += mass;
            axes[3].mass[rate % guesses] += mass;
        }
        Self { axes, best: best.1 }
    }

    fn closer(&self, ends: &[[f64; 2]; 4]) -> [[f64; 2]; 4] {
        let mut closer = *ends;
        let negligible = [NEGLIGIBLE, NEGLIGIBLE, NEGLIGIBLE_RATE, NEGLIGIBLE_RATE];
        for ((ends, axis), negligible) in closer.iter_mut().zip(&self.axes).zip(negligible) {
            if axis.nodes.len() > 1 {
                *ends = axis.closer(negligible);
            }
        }
        closer
    }
}

/// Nodes and weights of Gauss–Legendre quadrature on −1 … 1, ascending (Newton's method on the Legendre polynomial).
fn legendre(n: usize) -> (Vec<f64>, Vec<f64>) {
    let count = n as f64;
    (1..=n)
        .rev()
        .map(|i| {
            let mut x = (PI * (i as f64 - 0.25) / (count + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..20 {
                let (mut before, mut value) = (1.0, x);
                for k in 2..=n {
                    let k = k as f64;
                    (before, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
                }
                slope = count * (x * value - before) / (x * x - 1.0);
                x -= value / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .unzip()
}

/// The mode of the density over (threshold, width, λ, γ), by the direct search of Hooke and Jeeves (1961).
fn mode(posterior: &Posterior, start: Psychometric, ends: &[[f64; 2]; 4]) -> Psychometric {
    let at = |x: &[f64; 4]| Psychometric { threshold: x[0], width: x[1].exp(), lapse: x[2], guess: x[3] };
    let density = |x: &[f64; 4]| posterior.ln_density(&at(x));
    let explore = |from: [f64; 4], value: f64, steps: &[f64; 4]| {
        let (mut x, mut best) = (from, value);
        for i in 0..4 {
            for step in [steps[i], -steps[i]] {
                let mut tried = x;
                tried[i] += step;
                // The rates end at zero, where the mode often is.
                if i >= 2 {
                    tried[i] = tried[i].max(0.0);
                }
                let value = density(&tried);
                if value > best {
                    (x, best) = (tried, value);
                    break;
                }
            }
        }
        (x, best)
    };
    let mut x = [start.threshold, start.width.ln(), start.lapse, start.guess];
    let mut value = density(&x);
    let mut steps = [0, 1, 2, 3].map(|i| 0.03 * (ends[i][1] - ends[i][0]));
    let smallest = 1e-7;
    let first = steps;
    while (0..4).any(|i| steps[i] > smallest * first[i].max(1e-12)) {
        let (mut found, mut best) = explore(x, value, &steps);
        if best <= value {
            steps = steps.map(|step| 0.5 * step);
            continue;
        }
        // As long as going on the same way helps, go on.
        loop {
            let ahead: [f64; 4] = std::array::from_fn(|i| {
                let to = 2.0 * found[i] - x[i];
                if i >= 2 { to.max(0.0) } else { to }
            });
            (x, value) = (found, best);
            let (next, next_value) = explore(ahead, density(&ahead), &steps);
            if next_value <= best {
                break;
            }
            (found, best) = (next, next_value);
        }
    }
    at(&x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exact for polynomials up to degree 2 n − 1: ∫ x⁶ over −1 … 1 is 2/7 with four nodes.
    #[test]
    fn gauss_legendre_is_exact_for_polynomials() {
        let (nodes, weights) = legendre(4);
        let integral: f64 = nodes.iter().zip(&weights).map(|(x, w)| w * x.powi(6)).sum();
        assert!((integral - 2.0 / 7.0).abs() < 1e-14, "{integral}");
        assert!(nodes.windows(2).all(|pair| pair[0] < pair[1]));
        // Abramowitz and Stegun, table 25.4: n = 3 has ±0.774596669241483 with weight 5/9.
        let (nodes, weights) = legendre(3);
        assert!((nodes[2] - 0.774_596_669_241_483).abs() < 1e-14 && (weights[2] - 5.0 / 9.0).abs() < 1e-14);
    }
}
