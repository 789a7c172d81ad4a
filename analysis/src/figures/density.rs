//! Kernel densities of draws, in one and two dimensions, and the contours that hold a share of their mass.
//!
//! Draws of two correlated quantities are smoothed in the coordinates in which they are uncorrelated, so that a narrow
//! slanted posterior stays narrow. Both quantities are positive: mass that a kernel puts below 0 is folded back.

/// Cells of the two-dimensional grid along each side.
const SIDE: usize = 96;
/// How far the grid reaches, in standard deviations.
const REACH: f64 = 5.0;

/// A density over the plane, sampled on a grid that is slanted with the draws.
pub(super) struct Density {
    mean: [f64; 2],
    /// Lower triangular factor of the covariance: a point is mean + L u.
    factor: [f64; 3],
    /// (SIDE + 2)² values, the border 0 so that every contour closes; row by row along u₁.
    values: Vec<f64>,
}

/// Normal reference rule in one dimension, with the smaller of standard deviation and scaled quartile range (Silverman
/// 1986, §3.4.2). 0 for draws without spread.
fn bandwidth(sorted: &[f64]) -> f64 {
    let n = sorted.len() as f64;
    let mean = sorted.iter().sum::<f64>() / n;
    let sd = (sorted.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0)).sqrt();
    let quartile = |q| crate::numerics::quantile_of_sorted(sorted, q).unwrap_or(mean);
    let robust = (quartile(0.75) - quartile(0.25)) / 1.349;
    let spread = if robust > 0.0 { sd.min(robust) } else { sd };
    0.9 * spread * n.powf(-0.2)
}

/// The density of positive draws at each place, by a Gaussian kernel; nothing for draws without spread.
pub(super) fn marginal(draws: &[f64], places: &[f64]) -> Option<Vec<f64>> {
    let sorted = crate::numerics::sorted_finite(draws.iter().copied());
    let width = bandwidth(&sorted);
    if sorted.len() < 2 || width <= 1e-9 * sorted.last()?.abs() {
        return None;
    }
    let scale = 1.0 / (sorted.len() as f64 * width * std::f64::consts::TAU.sqrt());
    let kernel_sum = |x: f64| -> f64 {
        let (from, to) = (x - 5.0 * width, x + 5.0 * width);
        let first = sorted.partition_point(|draw| *draw < from);
        sorted[first..]
            .iter()
            .take_while(|draw| **draw <= to)
            .map(|draw| (-0.5 * ((x - draw) / width).powi(2)).exp())
            .sum()
    };
    Some(places.iter().map(|&x| if x < 0.0 { 0.0 } else { scale * (kernel_sum(x) + kernel_sum(-x)) }).collect())
}

impl Density {
    /// The density of draws of two positive quantities; nothing for fewer than ten draws or draws along a line.
    pub(super) fn new(draws: &[[f64; 2]]) -> Option<Self> {
        let n = draws.len() as f64;
        if draws.len() < 10 {
            return None;
        }
        let mean = [0, 1].map(|i| draws.iter().map(|d| d[i]).sum::<f64>() / n);
        let covariance =
            |i: usize, j: usize| draws.iter().map(|d| (d[i] - mean[i]) * (d[j] - mean[j])).sum::<f64>() / (n - 1.0);
        let (xx, xy, yy) = (covariance(0, 0), covariance(0, 1), covariance(1, 1));
        let l11 = xx.sqrt();
        // A sum that overflowed is no spread either.
        if !l11.is_finite() || l11 <= 1e-9 * mean[0].abs() {
            return None;
        }
        let l21 = xy / l11;
        let rest = yy - l21 * l21;
        if !rest.is_finite() || rest <= 1e-9 * yy || yy.sqrt() <= 1e-9 * mean[1].abs() {
            return None;
        }
        let mut density = Self { mean, factor: [l11, l21, rest.sqrt()], values: Vec::new() };
        density.values = density.smoothed(draws, n);
        Some(density)
    }

    fn whitened(&self, point: [f64; 2]) -> [f64; 2] {
        let [l11, l21, l22] = self.factor;
        let u = (point[0] - self.mean[0]) / l11;
        [u, (point[1] - self.mean[1] - l21 * u) / l22]
    }

    /// The point of a place on the grid, whose cells' centres are at whole numbers from 1 to SIDE.
    fn point(&self, column: f64, row: f64) -> [f64; 2] {
        let [l11, l21, l22] = self.factor;
        let [u, v] = [column, row].map(|i| ((i - 0.5) / SIDE as f64 * 2.0 - 1.0) * REACH);
        [self.mean[0] + l11 * u, self.mean[1] + l21 * u + l22 * v]
    }

    fn smoothed(&self, draws: &[[f64; 2]], n: f64) -> Vec<f64> {
        let wide = SIDE + 2;
        let mut counts = vec![0.0; wide * wide];
        for &[x, y] in draws {
            // A draw and its reflections at both axes; reflections far from an axis fall off the grid.
            for image in [[x, y], [-x, y], [x, -y]] {
                let [column, row] = self.whitened(image).map(|u| (u / REACH + 1.0) * 0.5 * SIDE as f64);
                if (0.0..SIDE as f64).contains(&column) && (0.0..SIDE as f64).contains(&row) {
                    counts[(row as usize + 1) * wide + column as usize + 1] += 1.0;
                }
            }
        }
        // Scott's rule for two dimensions, in cells; whitened draws have a standard deviation of one.
        let sd = n.powf(-1.0 / 6.0) * SIDE as f64 / (2.0 * REACH);
        let reach = (3.5 * sd).ceil() as usize;
        let kernel: Vec<f64> = (0..=reach).map(|i| (-0.5 * (i as f64 / sd).powi(2)).exp()).collect();
        let blur = |from: &[f64], stride: usize, across: usize| {
            let mut to = vec![0.0; from.len()];
            for line in 1..=SIDE {
                for i in 1..=SIDE {
                    let at = |i: usize| from[line * across + i * stride];
                    let mut sum = kernel[0] * at(i);
                    for (distance, weight) in kernel.iter().enumerate().skip(1) {
                        sum += weight * if i > distance { at(i - distance) } else { 0.0 };
                        sum += weight * if i + distance <= SIDE { at(i + distance) } else { 0.0 };
                    }
                    to[line * across + i * stride] = sum;
                }
            }
            to
        };
        blur(&blur(&counts, 1, wide), wide, 1)
    }

    /// Closed rings in the draws' coordinates around the smallest region that holds a share of the mass.
    pub(super) fn contour(&self, share: f64) -> Vec<Vec<[f64; 2]>> {
        let wide = SIDE + 2;
        let positive = |index: usize| {
            let [x, y] = self.point((index % wide) as f64, (index / wide) as f64);
            x >= 0.0 && y >= 0.0
        };
        let mut masses: Vec<f64> =
            self.values.iter().enumerate().filter(|(i, v)| **v > 0.0 && positive(*i)).map(|(_, v)| *v).collect();
        masses.sort_by(|a, b| b.total_cmp(a));
        let wanted = share * masses.iter().sum::<f64>();
        let mut sum = 0.0;
        let level = masses.iter().find(|mass| {
            sum += **mass;
            sum >= wanted
        });
        let Some(&level) = level else { return Vec::new() };
        rings(&self.values, wide, level)
            .into_iter()
            .map(|ring| ring.into_iter().map(|[column, row]| self.point(column, row)).collect())
            .collect()
    }
}

/// Closed rings around where a grid's values exceed a level, by marching squares; places in columns and rows.
///
/// The grid's border must lie below the level. At a saddle the high corners are kept apart.
fn rings(values: &[f64], wide: usize, level: f64) -> Vec<Vec<[f64; 2]>> {
    use std::collections::BTreeMap;
    // An edge of the grid: its first node, and whether it goes down instead of right.
    type Edge = (usize, bool);
    let mut next: BTreeMap<Edge, Edge> = BTreeMap::new();
    let high = |node: usize| values[node] > level;
    for row in 0..wide - 1 {
        for column in 0..wide - 1 {
            let node = row * wide + column;
            let corners = [node, node + 1, node + wide + 1, node + wide];
            let edges: [Edge; 4] = [(node, false), (node + 1, true), (node + wide, false), (node, true)];
            // Going round the cell, a contour leaves through the edge where values fall and came in where they rise.
            for i in 0..4 {
                if high(corners[i]) && !high(corners[(i + 1) % 4]) {
                    let mut j = i;
                    while high(corners[j]) {
                        j = (j + 3) % 4;
                    }
                    next.insert(edges[j], edges[i]);
                }
            }
        }
    }
    let place = |(node, down): Edge| {
        let other = if down { node + wide } else { node + 1 };
        let (a, b) = (values[node], values[other]);
        let share = if (b - a).abs() > 0.0 { (level - a) / (b - a) } else { 0.5 };
        let [column, row] = [(node % wide) as f64, (node / wide) as f64];
        if down { [column, row + share] } else { [column + share, row] }
    };
    let mut rings = Vec::new();
    while let Some((&first, _)) = next.first_key_value() {
        let mut ring = Vec::new();
        let mut edge = first;
        while let Some(to) = next.remove(&edge) {
            ring.push(place(edge));
            edge = to;
        }
        rings.push(ring);
    }
    rings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::normal_quantile;

    /// Draws of a normal distribution by a rank-1 lattice, correlated by −0.9.
    fn normal_draws(n: usize) -> Vec<[f64; 2]> {
        (0..n)
            .map(|i| {
                let [u, v] = [0.754_877_666_246_693, 0.569_840_290_998_053]
                    .map(|a| normal_quantile((0.5 + a * i as f64).fract()));
                [10.0 + u, 20.0 + 2.0 * (-0.9 * u + (1.0f64 - 0.81).sqrt() * v)]
            })
            .collect()
    }

    /// The ellipse that holds a share p of a bivariate normal has the area 2π √|Σ| (−ln(1 − p)); the kernel widens both
    /// axes by √(1 + h²), h = n^(−1/6).
    #[test]
    fn contours_of_a_normal_are_its_ellipses() {
        let draws = normal_draws(4000);
        let density = Density::new(&draws).unwrap();
        let widened = 1.0 + 4000f64.powf(-1.0 / 3.0);
        for share in [0.5f64, 0.95] {
            let rings = density.contour(share);
            assert_eq!(rings.len(), 1, "{share}");
            let ring = &rings[0];
            let area: f64 = (0..ring.len())
                .map(|i| {
                    let ([x0, y0], [x1, y1]) = (ring[i], ring[(i + 1) % ring.len()]);
                    0.5 * (x0 * y1 - x1 * y0)
                })
                .sum();
            let expected = std::f64::consts::TAU * 2.0 * (1.0f64 - 0.81).sqrt() * -(1.0 - share).ln() * widened;
            assert!((area.abs() / expected - 1.0).abs() < 0.04, "{share}: {area} against {expected}");
        }
    }

    #[test]
    fn marginals_integrate_to_one_also_at_zero() {
        let draws: Vec<f64> = (0..2000).map(|i| -((i as f64 + 0.5) / 2000.0).ln()).collect();
        let places: Vec<f64> = (0..4000).map(|i| (i as f64 + 0.5) * 0.005).collect();
        let mass: f64 = marginal(&draws, &places).unwrap().iter().sum::<f64>() * 0.005;
        assert!((mass - 1.0).abs() < 2e-3, "{mass}");
    }

    #[test]
    fn draws_without_spread_have_no_density() {
        assert!(Density::new(&[[1.0, 2.0]; 50]).is_none());
        let line: Vec<[f64; 2]> = (0..50).map(|i| [f64::from(i), 3.0 * f64::from(i)]).collect();
        assert!(Density::new(&line).is_none());
        assert!(marginal(&[1.0; 9], &[1.0]).is_none());
    }
}
