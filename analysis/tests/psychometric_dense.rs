//! Posteriors against plain sums over dense grids that share no code with the crate's own quadrature, and three changes to the
//! sums that must be found out: intervals shifted by half a step, a prior taken twice, guess and lapse rates swapped.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

use analysis::mar::Estimate;
use analysis::psychometric::{
    Count, Guess, Overdispersion, PsychometricConfig, PsychometricFit, Scale, Sigmoid, fit_psychometric,
};
use statrs::function::erf::erf;
use statrs::function::gamma::ln_gamma;
use std::f64::consts::{LN_2, PI, SQRT_2};

/// How the dense sum is made wrong on purpose.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    None,
    HalfStep,
    DoubledPrior,
    SwappedRates,
}

/// 2.5 %, 50 % and 97.5 % of threshold, width, λ, γ and η.
type Dense = [[f64; 3]; 5];

fn shape(sigmoid: Sigmoid, u: f64) -> f64 {
    match sigmoid {
        Sigmoid::CumulativeGauss => 0.5 + 0.5 * erf(3.289_707_253_902_945 * u / SQRT_2),
        Sigmoid::Gumbel => 1.0 - (-LN_2 * (4.067_383_949_407_112 * u).exp()).exp(),
        other => panic!("{other:?}"),
    }
}

fn ln_beta_binomial(k: f64, n: f64, p: f64, eta: f64) -> f64 {
    if eta < 1e-6 {
        let term = |count: f64, p: f64| if count > 0.0 { count * p.ln() } else { 0.0 };
        return term(k, p) + term(n - k, 1.0 - p);
    }
    let v = 1.0 / (eta * eta) - 1.0;
    ln_gamma(k + p * v) + ln_gamma(n - k + (1.0 - p) * v) - ln_gamma(n + v) - ln_gamma(p * v) - ln_gamma((1.0 - p) * v)
        + ln_gamma(v)
}

fn raised(x: f64, [from, flat_from, flat_to, to]: [f64; 4]) -> f64 {
    if x <= from || x >= to {
        0.0
    } else if x < flat_from {
        0.5 - 0.5 * (PI * (x - from) / (flat_from - from)).cos()
    } else if x <= flat_to {
        1.0
    } else {
        0.5 + 0.5 * (PI * (x - flat_to) / (to - flat_to)).cos()
    }
}

/// One axis of the dense grid.
struct Axis {
    nodes: Vec<f64>,
}

impl Axis {
    fn new([low, high]: [f64; 2], n: usize) -> Self {
        let step = (high - low) / n as f64;
        Self { nodes: (0..n).map(|i| low + (i as f64 + 0.5) * step).collect() }
    }

    fn quantiles(&self, mass: &[f64], fault: Fault) -> [f64; 3] {
        let total: f64 = mass.iter().sum();
        let step = if self.nodes.len() > 1 { self.nodes[1] - self.nodes[0] } else { 0.0 };
        [0.025, 0.5, 0.975].map(|p| {
            let mut sum = 0.0;
            for (node, mass) in self.nodes.iter().zip(mass) {
                if sum + mass >= p * total {
                    let within = (p * total - sum) / mass - 0.5;
                    let shift = if fault == Fault::HalfStep { -0.5 } else { 0.0 };
                    return node + step * (within + shift);
                }
                sum += mass;
            }
            self.nodes[self.nodes.len() - 1]
        })
    }
}

/// The box and the nodes of each axis: threshold, width, λ, γ, η; one node fixes a value.
struct Grid {
    ends: [[f64; 2]; 5],
    n: [usize; 5],
}

fn dense(counts: &[Count], config: &PsychometricConfig, grid: &Grid, fault: Fault) -> Dense {
    let x: Vec<f64> =
        counts.iter().map(|count| if config.scale == Scale::Linear { count.level } else { count.level.ln() }).collect();
    let (first, last) = (x[0], x[x.len() - 1]);
    let spread = last - first;
    let step = x.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let axes: Vec<Axis> = grid.ends.iter().zip(grid.n).map(|(&ends, n)| Axis::new(ends, n)).collect();
    let free: Vec<bool> = grid.n.iter().map(|&n| n > 1).collect();
    let power = if fault == Fault::DoubledPrior { 18.0 } else { 9.0 };
    let mut mass: Vec<Vec<f64>> = axes.iter().map(|axis| vec![0.0; axis.nodes.len()]).collect();
    let top = (0..counts.len())
        .map(|i| {
            let (k, n) = (f64::from(counts[i].k), f64::from(counts[i].n));
            let p = (k / n).clamp(1e-9, 1.0 - 1e-9);
            k * p.ln() + (n - k) * (1.0 - p).ln()
        })
        .sum::<f64>();
    for (it, &t) in axes[0].nodes.iter().enumerate() {
        let prior_t = raised(t, [first - 0.5 * spread, first, last, last + 0.5 * spread]);
        for (iw, &w) in axes[1].nodes.iter().enumerate() {
            let prior = prior_t * raised(w, [step, 2.0 * step, spread, 3.0 * spread]);
            if prior == 0.0 {
                continue;
            }
            let seen: Vec<f64> = x.iter().map(|x| shape(config.sigmoid, (x - t) / w)).collect();
            for (il, &lapse) in axes[2].nodes.iter().enumerate() {
                for (ig, &guess) in axes[3].nodes.iter().enumerate() {
                    let guess_rate = if config.guess == Guess::EqualToLapse { lapse } else { guess };
                    let (low, high) =
                        if fault == Fault::SwappedRates { (lapse, guess_rate) } else { (guess_rate, lapse) };
                    let p: Vec<f64> = seen.iter().map(|seen| low + (1.0 - low - high) * seen).collect();
                    let mut ln_rates = power * (1.0 - lapse).ln();
                    if free[3] {
                        ln_rates += power * (1.0 - guess).ln();
                    }
                    for (ie, &eta) in axes[4].nodes.iter().enumerate() {
                        let ln: f64 = counts
                            .iter()
                            .zip(&p)
                            .map(|(count, &p)| ln_beta_binomial(f64::from(count.k), f64::from(count.n), p, eta))
                            .sum();
                        let of_eta = if free[4] { 9.0 * (1.0 - eta).ln() } else { 0.0 };
                        let value = prior * (ln + ln_rates + of_eta - top).exp();
                        for (axis, index) in [it, iw, il, ig, ie].into_iter().enumerate() {
                            mass[axis][index] += value;
                        }
                    }
                }
            }
        }
    }
    std::array::from_fn(|i| axes[i].quantiles(&mass[i], fault))
}

fn ours(fit: &PsychometricFit) -> Dense {
    let of = |e: &Estimate| [e.ci95[0], e.estimate, e.ci95[1]];
    [of(&fit.threshold), of(&fit.width), of(&fit.lapse), of(&fit.guess), of(&fit.overdispersion)]
}

/// The largest distance of ends and median, as a share of the interval, over parameters that are free.
fn distance(name: &str, ours: &Dense, dense: &Dense, n: &[usize; 5]) -> f64 {
    let names = ["threshold", "width", "lapse", "guess", "overdispersion"];
    let mut worst = 0.0f64;
    for i in 0..5 {
        if n[i] == 1 {
            continue;
        }
        let [low, _, high] = dense[i];
        let off = (0..3).map(|j| (ours[i][j] - dense[i][j]).abs() / (high - low)).fold(0.0, f64::max);
        println!("{name} {}: {:?} against {:?}, {:.2} %", names[i], ours[i], dense[i], 100.0 * off);
        worst = worst.max(off);
    }
    worst
}

fn counts(levels: &[f64], n: u32, k: &[u32]) -> Vec<Count> {
    levels.iter().zip(k).map(|(&level, &k)| Count { level, n, k }).collect()
}

/// Data, configuration and a box that holds the posterior.
fn cases() -> Vec<(&'static str, Vec<Count>, PsychometricConfig, Grid)> {
    let base = PsychometricConfig::TWO_ALTERNATIVES;
    let seven = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    vec![
        (
            "2AFC with overdispersion",
            counts(&seven, 40, &[19, 22, 27, 32, 37, 39, 39]),
            PsychometricConfig { overdispersion: Overdispersion::Free, ..base },
            Grid { ends: [[0.5, 5.6], [1.0, 14.0], [0.0, 0.2], [0.5, 0.5], [0.0, 0.45]], n: [52, 52, 24, 1, 24] },
        ),
        (
            "yes/no, Gumbel",
            counts(&seven, 30, &[2, 3, 6, 12, 22, 27, 28]),
            PsychometricConfig { sigmoid: Sigmoid::Gumbel, guess: Guess::Free, ..base },
            Grid { ends: [[2.5, 6.0], [1.0, 11.0], [0.0, 0.32], [0.0, 0.32], [0.0, 0.0]], n: [70, 70, 40, 40, 1] },
        ),
        (
            "equal rates on a logarithmic axis",
            counts(&[0.1, 0.2, 0.4, 0.8, 1.6], 24, &[1, 4, 11, 20, 23]),
            PsychometricConfig { guess: Guess::EqualToLapse, scale: Scale::Logarithmic, ..base },
            Grid { ends: [[-1.6, 0.1], [LN_2, 6.0], [0.0, 0.25], [0.0, 0.0], [0.0, 0.0]], n: [150, 150, 80, 1, 1] },
        ),
    ]
}

fn fitted(counts: &[Count], config: &PsychometricConfig) -> Dense {
    let fit = fit_psychometric(counts, config).unwrap();
    let mut ours = ours(&fit);
    if config.scale == Scale::Logarithmic {
        ours[0] = ours[0].map(f64::ln);
    }
    ours
}

#[test]
fn intervals_are_those_of_dense_sums_within_a_hundredth() {
    for (name, counts, config, grid) in cases() {
        let dense = dense(&counts, &config, &grid, Fault::None);
        let worst = distance(name, &fitted(&counts, &config), &dense, &grid.n);
        assert!(worst < 0.01, "{name}: {worst}");
    }
}

/// The comparison above must be able to fail.
#[test]
fn wrong_sums_are_found_out() {
    let cases = cases();
    for (case, fault, least) in [
        (0, Fault::HalfStep, 0.01),
        (0, Fault::DoubledPrior, 0.05),
        (1, Fault::DoubledPrior, 0.05),
        (1, Fault::SwappedRates, 0.05),
        (2, Fault::DoubledPrior, 0.05),
    ] {
        let (name, counts, config, grid) = &cases[case];
        let wrong = dense(counts, config, grid, fault);
        let worst = distance(&format!("{name}, {fault:?}"), &fitted(counts, config), &wrong, &grid.n);
        assert!(worst > least, "{name}, {fault:?}: {worst}");
    }
}
