//! The marginal posterior of one parameter, as a density on even cells.

use serde::{Deserialize, Serialize};

/// A density on even cells between two ends, with the moments of the sum that it comes from.
///
/// A threshold's and a width's are in the axis's coordinate and in its natural logarithm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Marginal {
    /// The ends of the axis.
    pub ends: [f64; 2],
    /// The mass in each cell, summing to one.
    pub mass: Vec<f64>,
    /// Posterior mean.
    pub mean: f64,
    /// Posterior standard deviation.
    pub sd: f64,
}

impl Marginal {
    /// A parameter that is known.
    pub(super) fn certain(value: f64) -> Self {
        Self { ends: [value, value], mass: vec![1.0], mean: value, sd: 0.0 }
    }

    /// The value below which a share `p` of the posterior lies.
    #[must_use]
    pub fn quantile(&self, p: f64) -> f64 {
        let step = self.step();
        let mut sum = 0.0;
        for (index, mass) in self.mass.iter().enumerate() {
            if p <= sum + mass && *mass > 0.0 {
                return self.ends[0] + step * (index as f64 + ((p - sum) / mass).clamp(0.0, 1.0));
            }
            sum += mass;
        }
        self.ends[1]
    }

    /// The share of the posterior below a value.
    #[must_use]
    pub fn cdf(&self, value: f64) -> f64 {
        let step = self.step();
        if step <= 0.0 {
            return if value >= self.ends[0] { 1.0 } else { 0.0 };
        }
        let place = ((value - self.ends[0]) / step).clamp(0.0, self.mass.len() as f64);
        let whole = place.floor() as usize;
        let below: f64 = self.mass[..whole.min(self.mass.len())].iter().sum();
        let part = self.mass.get(whole).map_or(0.0, |mass| mass * (place - whole as f64));
        (below + part).clamp(0.0, 1.0)
    }

    /// The 2.5 %, 50 % and 97.5 % quantiles.
    pub(super) fn interval(&self) -> [f64; 3] {
        [0.025, 0.5, 0.975].map(|p| self.quantile(p))
    }

    fn step(&self) -> f64 {
        (self.ends[1] - self.ends[0]) / self.mass.len() as f64
    }
}

/// The nodes of one axis of a quadrature, what each stands for, and the mass that was found there.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    pub(super) ends: [f64; 2],
    pub(super) nodes: Vec<f64>,
    pub(super) weights: Vec<f64>,
    /// Mass at each node, summing to one.
    pub(super) mass: Vec<f64>,
}

/// Cells of a marginal on Gauss–Legendre nodes.
const DENSE: usize = 400;
/// An even axis's cells are split into so many.
const SPLIT: usize = 8;

impl Axis {
    /// Middles of even cells.
    pub(super) fn even(ends: [f64; 2], n: usize) -> Self {
        let step = (ends[1] - ends[0]) / n as f64;
        let nodes = (0..n).map(|i| ends[0] + (i as f64 + 0.5) * step).collect();
        Self { ends, nodes, weights: vec![step; n], mass: vec![0.0; n] }
    }

    /// Gauss–Legendre nodes; one node for a fixed value.
    pub(super) fn gauss(ends: [f64; 2], n: usize) -> Self {
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

    pub(super) fn is_fixed(&self) -> bool {
        self.ends[0] >= self.ends[1]
    }

    /// The ends beyond which the density is negligible, one node to spare.
    pub(super) fn closer(&self, negligible: f64) -> [f64; 2] {
        let density: Vec<f64> = self.mass.iter().zip(&self.weights).map(|(mass, weight)| mass / weight).collect();
        let least = negligible * density.iter().copied().fold(0.0, f64::max);
        let first = density.iter().position(|&d| d > least).unwrap_or(0);
        let last = density.iter().rposition(|&d| d > least).unwrap_or(density.len() - 1);
        [
            if first == 0 { self.ends[0] } else { self.nodes[first - 1] },
            self.nodes.get(last + 1).copied().unwrap_or(self.ends[1]),
        ]
    }

    /// The mean and standard deviation of a function of the parameter.
    fn moments(&self, of: impl Fn(f64) -> f64) -> (f64, f64) {
        let mean: f64 = self.mass.iter().zip(&self.nodes).map(|(mass, node)| mass * of(*node)).sum();
        let square: f64 = self.mass.iter().zip(&self.nodes).map(|(mass, node)| mass * (of(*node) - mean).powi(2)).sum();
        (mean, square.max(0.0).sqrt())
    }

    /// The mean of a function of the parameter.
    pub(super) fn mean_of(&self, of: impl Fn(f64) -> f64) -> f64 {
        self.moments(of).0
    }

    /// The mass within each even cell. A node's mass is its density times the cell's length; over the cell the density bends,
    /// which differences of second and fourth order make good (the midpoint rule's error terms).
    fn integrated(&self) -> Vec<f64> {
        let at = |i: usize, offset: isize| {
            i.checked_add_signed(offset).and_then(|i| self.mass.get(i)).copied().unwrap_or(0.0)
        };
        (0..self.mass.len())
            .map(|i| {
                let second = at(i, -1) - 2.0 * at(i, 0) + at(i, 1);
                let fourth = at(i, -2) - 4.0 * at(i, -1) + 6.0 * at(i, 0) - 4.0 * at(i, 1) + at(i, 2);
                let whole = at(i, 0) + second / 24.0 - 17.0 / 5760.0 * fourth;
                // Beside a density that stops at its end the differences would go too far.
                whole.clamp(0.5 * at(i, 0), 2.0 * at(i, 0) + 1e-300)
            })
            .collect()
    }

    /// A marginal on even cells, each split into eight by a cubic through the running sums, which keeps every cell's mass.
    pub(super) fn refined(&self) -> Marginal {
        let (mean, sd) = self.moments(|x| x);
        let n = self.mass.len();
        let cells = self.integrated();
        // Running sums at the cells' edges and their slopes, limited so that no part of a cell is below zero (Fritsch and
        // Carlson 1980).
        let slope_at = |edge: usize| {
            // A density that does not vanish at an end of its axis goes on there as it came.
            let beyond = |end: usize, next: usize| 1.5 * cells[end] - 0.5 * cells[next];
            let (slope, least) = match edge {
                0 => (beyond(0, 1), cells[0]),
                _ if edge == n => (beyond(n - 1, n - 2), cells[n - 1]),
                _ => {
                    let (before, after) = (cells[edge - 1], cells[edge]);
                    // The cubic through four cells' sums, or the mean of two beside an end.
                    let beyond =
                        if edge >= 2 && edge + 1 < n { Some((cells[edge - 2], cells[edge + 1])) } else { None };
                    let slope = beyond
                        .map_or(0.5 * (before + after), |(first, last)| (7.0 * (before + after) - first - last) / 12.0);
                    (slope, before.min(after))
                }
            };
            slope.clamp(0.0, 3.0 * least)
        };
        let mut mass = Vec::with_capacity(SPLIT * n);
        for (cell, &total) in cells.iter().enumerate() {
            let (from, to) = (slope_at(cell), slope_at(cell + 1));
            let sum = |t: f64| {
                let (t2, t3) = (t * t, t * t * t);
                (t3 - 2.0 * t2 + t) * from + (3.0 * t2 - 2.0 * t3) * total + (t3 - t2) * to
            };
            for part in 0..SPLIT {
                let (low, high) = (part as f64 / SPLIT as f64, (part + 1) as f64 / SPLIT as f64);
                mass.push((sum(high) - sum(low)).max(0.0));
            }
        }
        Marginal { ends: self.ends, mass: normalised(mass), mean, sd }
    }

    /// A marginal on Gauss–Legendre nodes on even cells. The logarithm of the density is interpolated, which is nearly a
    /// parabola and cannot ripple below zero (Berrut and Trefethen 2004, Eq. 5.4 for the weights).
    pub(super) fn dense(&self) -> Marginal {
        if self.is_fixed() {
            return Marginal::certain(self.ends[0]);
        }
        let (mean, sd) = self.moments(|x| x);
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
        let cells = Self::even(self.ends, DENSE);
        let mass = cells
            .nodes
            .iter()
            .map(|&x| {
                let (mut above, mut below) = (0.0, 0.0);
                for i in 0..n {
                    let share = barycentric[i] / (x - self.nodes[i]);
                    above += share * ln[i];
                    below += share;
                }
                // A cell's middle may be a node, where the quotient is not defined.
                let at_node = self.nodes.iter().position(|node| (x - node).abs() < 1e-12).map(|i| ln[i]);
                at_node.unwrap_or(above / below).min(3.0).exp()
            })
            .collect();
        Marginal { ends: self.ends, mass: normalised(mass), mean, sd }
    }
}

fn normalised(mut mass: Vec<f64>) -> Vec<f64> {
    let total: f64 = mass.iter().sum();
    mass.iter_mut().for_each(|mass| *mass /= total);
    mass
}

/// Nodes and weights of Gauss–Legendre quadrature on −1 … 1, ascending (Newton's method on the Legendre polynomial).
fn legendre(n: usize) -> (Vec<f64>, Vec<f64>) {
    let count = n as f64;
    (1..=n)
        .rev()
        .map(|i| {
            let mut x = (std::f64::consts::PI * (i as f64 - 0.25) / (count + 0.5)).cos();
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

    /// A normal density on 24 cells between ±5 SD: its quantiles to a thousandth of a SD.
    #[test]
    fn a_normal_density_has_its_own_quantiles() {
        let mut axis = Axis::even([-5.0, 5.0], 24);
        axis.mass = normalised(axis.nodes.iter().map(|x| (-0.5 * x * x).exp()).collect());
        let marginal = axis.refined();
        for (p, expected) in [(0.025, -1.959_964), (0.25, -0.674_490), (0.5, 0.0), (0.975, 1.959_964)] {
            assert!((marginal.quantile(p) - expected).abs() < 2e-3, "{p}: {}", marginal.quantile(p));
            assert!((marginal.cdf(marginal.quantile(p)) - p).abs() < 1e-12);
        }
        assert!(marginal.mean.abs() < 1e-12 && (marginal.sd - 1.0).abs() < 1e-4);
        assert_eq!((marginal.cdf(-9.0), marginal.cdf(9.0)), (0.0, 1.0));
    }

    /// Beta(1, 10) on ten Gauss–Legendre nodes: quantiles 1 − (1 − p)^{1/10} and mean 1/11.
    #[test]
    fn a_beta_density_on_few_nodes_has_its_own_quantiles() {
        let mut axis = Axis::gauss([0.0, 0.8], 12);
        axis.mass = normalised(axis.nodes.iter().zip(&axis.weights).map(|(x, w)| w * (1.0 - x).powi(9)).collect());
        let marginal = axis.dense();
        for p in [0.025f64, 0.5, 0.975] {
            let expected = 1.0 - (1.0 - p).powf(0.1);
            assert!((marginal.quantile(p) - expected).abs() < 1e-3, "{p}: {} {expected}", marginal.quantile(p));
        }
        assert!((marginal.mean - 1.0 / 11.0).abs() < 1e-5);
    }
}
