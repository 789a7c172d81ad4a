//! A threshold for every eccentricity, without the assumption of a line.
//!
//! Each eccentricity has its own threshold with a weak prior; width and lapse are shared. Given width and lapse the
//! thresholds are independent, so the joint posterior is integrated exactly by nested trapezoid rules: a small tensor of
//! (width, lapse) nodes and, for each eccentricity, a fine one-dimensional grid of ln threshold.

use super::data::{Data, Ring};
use super::elementary::{Exp, Ln, NormalCdf};
use super::posterior::{Posterior, cell_ln_likelihood};
use super::sampler::Sample;
use super::{LogNormal, MarFitConfig};
use crate::numerics::{ln_add_exp, ln_sum_exp};
use experiments::mar::WIDTH_SCALE;
use serde::{Deserialize, Serialize};

/// The threshold at one eccentricity: the omega of half the rise from guessing to lapsing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Threshold {
    /// Eccentricity, degrees.
    pub eccentricity_deg: f64,
    /// Posterior median, degrees per cycle; where `limited`, the display's finest MAR, which is an upper bound.
    pub mar_deg: f64,
    /// 95 % interval. Where `limited` it starts at 0, since nothing finer could be shown, and ends at the posterior's
    /// 97.5 % quantile or at the display's finest MAR, whichever is larger.
    pub ci95: [f64; 2],
    /// The threshold lies below what the display could show here: `mar_deg` is a limit and not a value.
    pub limited: bool,
    /// The finest MAR that the display could show here, where known.
    pub finest_mar_deg: Option<f64>,
    /// Trials at this eccentricity, shown or not.
    pub trials: usize,
}

/// ln grid points per threshold, and how far below its peak a density may be cut.
const GRID: usize = 97;
const CUT: f64 = 12.0;
/// Nodes per axis of (ln width, lapse), over ± `REACH` posterior standard deviations.
const NODES: usize = 9;
const REACH: f64 = 4.2;

/// A (width, lapse) node: probit scale, lapse, ln prior.
#[derive(Debug, Clone, Copy)]
struct Node {
    scale: f64,
    lapse: f64,
    ln_prior: f64,
}

/// Thresholds in ascending order of eccentricity.
pub(super) fn thresholds(
    data: &Data,
    target: &Posterior<'_>,
    sample: &Sample,
    config: &MarFitConfig,
) -> Vec<Threshold> {
    let nodes = nodes(target, sample);
    let rows: Vec<Row> = data.rings.iter().map(|ring| Row::new(ring, &nodes, target, config)).collect();

    // The weight of a node is its prior times the evidence of every eccentricity.
    let evidence: Vec<f64> =
        (0..nodes.len()).map(|j| nodes[j].ln_prior + rows.iter().map(|row| row.ln_evidence[j]).sum::<f64>()).collect();
    let total = ln_sum_exp(&evidence);
    let weights: Vec<f64> = evidence.iter().map(|e| (e - total).exp()).collect();

    data.rings
        .iter()
        .zip(&rows)
        .map(|(ring, row)| {
            let [low, middle, high] = row.quantiles(&weights, [0.025, 0.5, 0.975]).map(f64::exp);
            let finest = config.finest_mar_at(ring.eccentricity_deg);
            let limit = finest.filter(|&finest| middle < finest);
            Threshold {
                eccentricity_deg: ring.eccentricity_deg,
                mar_deg: limit.unwrap_or(middle),
                ci95: limit.map_or([low, high], |finest| [0.0, high.max(finest)]),
                limited: limit.is_some(),
                finest_mar_deg: finest,
                trials: ring.trials,
            }
        })
        .collect()
}

/// The weak prior of one threshold: the line through the prior medians, as wide as the wider of the two priors.
fn threshold_prior(ring: &Ring, target: &Posterior<'_>, config: &MarFitConfig) -> LogNormal {
    let ln_median = ln_add_exp(target.center[0] + ring.ln_e, target.center[1]);
    LogNormal { median: ln_median.exp(), sd_ln: config.priors.m.sd_ln.max(config.priors.omega0.sd_ln) }
}

fn nodes(target: &Posterior<'_>, sample: &Sample) -> Vec<Node> {
    // A bent line would widen the joint fit's width, so the nodes reach further than its posterior.
    let (width_mean, width_sd) = sample.moments(2);
    let (lapse_mean, lapse_sd) = sample.moments(3);
    let offset = |i: usize| REACH * (2.0 * i as f64 / (NODES - 1) as f64 - 1.0);
    let mut nodes = Vec::with_capacity(NODES * NODES);
    for i in 0..NODES {
        let x = width_mean + 1.25 * width_sd * offset(i);
        for j in 0..NODES {
            let z = lapse_mean + lapse_sd * offset(j);
            nodes.push(Node {
                scale: WIDTH_SCALE * (-(target.center[2] + target.spread[2] * x)).exp(),
                lapse: target.lapse(z),
                ln_prior: target.ln_z_prior(z) - 0.5 * x * x,
            });
        }
    }
    nodes
}

/// ln posterior of one threshold at every node and grid point.
#[derive(Debug)]
struct Row {
    grid: Vec<f64>,
    /// `ln_density[node * GRID + point]`, without common constants.
    ln_density: Vec<f64>,
    ln_evidence: Vec<f64>,
}

impl Row {
    fn new(ring: &Ring, nodes: &[Node], target: &Posterior<'_>, config: &MarFitConfig) -> Self {
        let prior = threshold_prior(ring, target, config);
        let guess = config.guess;
        let (normal, ln, exp) = (NormalCdf::new(), Ln::new(), Exp::new());
        let ln_prior = |ln_t: f64| -0.5 * ((ln_t - prior.median.ln()) / prior.sd_ln).powi(2);
        let ln_posterior = |ln_t: f64, node: &Node| {
            let likelihood: f64 = ring
                .counts
                .iter()
                .map(|c| {
                    let cdf = normal.pair(node.scale * (c.ln_omega - ln_t));
                    cell_ln_likelihood(ln, c.correct, c.wrong, guess, node.lapse, cdf)
                })
                .sum();
            likelihood + ln_prior(ln_t)
        };
        // Zoom on where any of the corner and centre nodes has density.
        let corners: Vec<Node> =
            [0, NODES - 1, NODES * NODES / 2, NODES * (NODES - 1), NODES * NODES - 1].map(|i| nodes[i]).to_vec();
        let centre = prior.median.ln();
        let (mut low, mut high) = (centre - 8.0 * prior.sd_ln, centre + 8.0 * prior.sd_ln);
        for _ in 0..8 {
            let step = (high - low) / 32.0;
            let (mut first, mut last) = (32usize, 0usize);
            for node in &corners {
                let values: Vec<f64> = (0..=32).map(|i| ln_posterior(low + step * i as f64, node)).collect();
                let top = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                for (i, value) in values.iter().enumerate() {
                    if *value > top - CUT {
                        first = first.min(i);
                        last = last.max(i);
                    }
                }
            }
            let (from, to) = (first.saturating_sub(1), (last + 1).min(32));
            let done = to - from > 25;
            (low, high) = (low + step * from as f64, low + step * to as f64);
            if done {
                break;
            }
        }

        let grid: Vec<f64> = (0..GRID).map(|i| low + (high - low) * i as f64 / (GRID - 1) as f64).collect();
        let mut ln_density = vec![0.0; nodes.len() * GRID];
        let priors: Vec<f64> = grid.iter().map(|&t| ln_prior(t)).collect();
        for row in 0..NODES {
            let scale = nodes[row * NODES].scale;
            for (point, &ln_t) in grid.iter().enumerate() {
                // Φ depends on the width alone and is shared by all lapse nodes.
                let mut sums = [priors[point]; NODES];
                for c in &ring.counts {
                    let cdf = normal.pair(scale * (c.ln_omega - ln_t));
                    for (sum, node) in sums.iter_mut().zip(&nodes[row * NODES..]) {
                        *sum += cell_ln_likelihood(ln, c.correct, c.wrong, guess, node.lapse, cdf);
                    }
                }
                for (column, sum) in sums.iter().enumerate() {
                    ln_density[(row * NODES + column) * GRID + point] = *sum;
                }
            }
        }
        let ln_evidence = ln_density.chunks_exact(GRID).map(|row| exp.ln_sum(ln, row)).collect();
        Self { grid, ln_density, ln_evidence }
    }

    /// Quantiles of ln threshold under node weights: cumulative by Simpson-like cubic, inverted linearly in between.
    fn quantiles<const N: usize>(&self, weights: &[f64], probabilities: [f64; N]) -> [f64; N] {
        let mut density = vec![0.0; GRID];
        let exp = Exp::new();
        for ((values, weight), evidence) in self.ln_density.chunks_exact(GRID).zip(weights).zip(&self.ln_evidence) {
            for (sum, value) in density.iter_mut().zip(values) {
                *sum += weight * exp.of((value - evidence).min(0.0));
            }
        }
        let cumulative = cumulative(&density);
        let total = cumulative[GRID - 1];
        probabilities.map(|p| {
            let goal = p * total;
            let above = cumulative.partition_point(|&c| c < goal).clamp(1, GRID - 1);
            invert_cell(
                [self.grid[above - 1], self.grid[above]],
                [cumulative[above - 1], cumulative[above]],
                [density[above - 1], density[above]],
                goal,
            )
        })
    }
}

/// Running integral over a unit-spaced grid: trapezoids corrected by the end slopes of each cell (Hermite).
fn cumulative(density: &[f64]) -> Vec<f64> {
    let slope = |i: usize| {
        let (before, after) = (i.saturating_sub(1), (i + 1).min(density.len() - 1));
        (density[after] - density[before]) / (after - before).max(1) as f64
    };
    let mut sums = vec![0.0; density.len()];
    for i in 1..density.len() {
        let area = 0.5 * (density[i - 1] + density[i]) + (slope(i - 1) - slope(i)) / 12.0;
        sums[i] = sums[i - 1] + area.max(0.0);
    }
    sums
}

/// The place between two grid points where the running integral reaches `goal`, with the density linear in between.
fn invert_cell(grid: [f64; 2], cumulative: [f64; 2], density: [f64; 2], goal: f64) -> f64 {
    let area = cumulative[1] - cumulative[0];
    if area <= 0.0 {
        return grid[0];
    }
    // Solve d0 u + (d1 − d0) u²/2 = share · (d0 + d1)/2 for u in 0..1.
    let share = ((goal - cumulative[0]) / area).clamp(0.0, 1.0);
    let mean = 0.5 * (density[0] + density[1]);
    let bend = density[1] - density[0];
    let root = (density[0] * density[0] + 2.0 * bend * share * mean).max(0.0).sqrt();
    let u = if density[0] + root > 0.0 { 2.0 * share * mean / (density[0] + root) } else { share };
    grid[0] + (grid[1] - grid[0]) * u.clamp(0.0, 1.0)
}
