//! Simulations for single psychometric functions, shared by the example and by `tests/calibration_psychometric.rs`.
//!
//! Truths are drawn from the fit's own standard priors over fixed levels; answers are drawn from the truth, blocks of them
//! beta-binomially.
#![allow(dead_code, unreachable_pub, clippy::print_stdout, clippy::unwrap_used)]

use crate::ranks::{Calibration, print_table};
use analysis::psychometric::{
    Count, Guess, Overdispersion, Psychometric, PsychometricConfig, PsychometricPosterior, Scale, Sigmoid,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::PI;

pub const SEED: u64 = 2016;

/// One experiment: its levels, answers at each, and how it is fitted.
#[derive(Debug, Clone)]
pub struct Experiment {
    pub name: &'static str,
    pub levels: Vec<f64>,
    pub n: u32,
    pub config: PsychometricConfig,
}

pub fn experiments() -> Vec<Experiment> {
    let base = PsychometricConfig::TWO_ALTERNATIVES;
    let seven: Vec<f64> = (1..=7).map(f64::from).collect();
    vec![
        Experiment { name: "2AFC, Gauss, 7 × 40", levels: seven.clone(), n: 40, config: base },
        Experiment {
            name: "2AFC, Gauss, 7 × 40, overdispersion free",
            levels: seven.clone(),
            n: 40,
            config: PsychometricConfig { overdispersion: Overdispersion::Free, ..base },
        },
        Experiment {
            name: "yes/no, logistic, 7 × 20",
            levels: seven,
            n: 20,
            config: PsychometricConfig { sigmoid: Sigmoid::Logistic, guess: Guess::Free, ..base },
        },
        Experiment {
            name: "4AFC, Weibull on a logarithmic axis, 6 × 15",
            levels: [0.05, 0.1, 0.2, 0.4, 0.8, 1.6].to_vec(),
            n: 15,
            config: PsychometricConfig {
                sigmoid: Sigmoid::Weibull,
                scale: Scale::Logarithmic,
                guess: Guess::of_alternatives(4),
                ..base
            },
        },
    ]
}

/// A truth that does not come from the prior: an ordinary observer in the middle of the levels.
pub fn ordinary(experiment: &Experiment) -> Psychometric {
    let scale = experiment.config.scale;
    let ends =
        [experiment.levels[0], experiment.levels[experiment.levels.len() - 1]].map(|level| scale.coordinate(level));
    let guess = match experiment.config.guess {
        Guess::Fixed(guess) => guess,
        _ => 0.06,
    };
    Psychometric {
        threshold: scale.level(0.5 * (ends[0] + ends[1])),
        width: 0.6 * (ends[1] - ends[0]),
        lapse: 0.02,
        guess,
        overdispersion: 0.0,
    }
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

/// A draw by rejection from a density that is 1 at most.
fn drawn(rng: &mut ChaCha8Rng, [low, high]: [f64; 2], density: impl Fn(f64) -> f64) -> f64 {
    loop {
        let x = low + (high - low) * rng.random::<f64>();
        if rng.random::<f64>() < density(x) {
            return x;
        }
    }
}

/// A truth from the standard priors.
fn from_prior(experiment: &Experiment, rng: &mut ChaCha8Rng) -> Psychometric {
    let config = &experiment.config;
    let x: Vec<f64> = experiment.levels.iter().map(|&level| config.scale.coordinate(level)).collect();
    let (first, last) = (x[0], x[x.len() - 1]);
    let spread = last - first;
    let step = x.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let beta = |rng: &mut ChaCha8Rng, most: f64| drawn(rng, [0.0, most], |x| (1.0 - x).powi(9));
    Psychometric {
        threshold: config.scale.level(drawn(rng, [first - 0.5 * spread, last + 0.5 * spread], |t| {
            raised(t, [first - 0.5 * spread, first, last, last + 0.5 * spread])
        })),
        width: drawn(rng, [step, 3.0 * spread], |w| raised(w, [step, 2.0 * step, spread, 3.0 * spread])),
        lapse: beta(rng, 0.5),
        guess: match config.guess {
            Guess::Fixed(guess) => guess,
            _ => beta(rng, 0.5),
        },
        overdispersion: match config.overdispersion {
            Overdispersion::None => 0.0,
            Overdispersion::Free => beta(rng, 0.99),
        },
    }
}

/// Answers in blocks: each answer pulls those after it its way (Pólya's urn), which makes their number beta-binomial.
fn answers(experiment: &Experiment, truth: &Psychometric, rng: &mut ChaCha8Rng) -> Vec<Count> {
    let r = truth.overdispersion.powi(2) / (1.0 - truth.overdispersion.powi(2));
    experiment
        .levels
        .iter()
        .map(|&level| {
            let p = truth.probability(level, &experiment.config);
            let mut k = 0;
            for i in 0..experiment.n {
                k += u32::from(rng.random::<f64>() < (p + r * f64::from(k)) / (1.0 + r * f64::from(i)));
            }
            Count { level, n: experiment.n, k }
        })
        .collect()
}

/// Fits simulated observers and ranks their truths; `truth` fixes them, otherwise they are drawn from the priors.
pub fn simulate(experiment: &Experiment, fits: usize, seed: u64, truth: Option<Psychometric>) -> Vec<Calibration> {
    let results: Vec<Vec<(&'static str, f64)>> = (0..fits as u64)
        .into_par_iter()
        .map(|index| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(index);
            let truth = truth.unwrap_or_else(|| from_prior(experiment, &mut rng));
            let counts = answers(experiment, &truth, &mut rng);
            let posterior = PsychometricPosterior::new(&counts, &experiment.config).unwrap();
            let mut ranks = vec![
                ("threshold", posterior.threshold.cdf(experiment.config.scale.coordinate(truth.threshold))),
                ("width", posterior.ln_width.cdf(truth.width.ln())),
                ("lapse", posterior.lapse.cdf(truth.lapse)),
            ];
            if experiment.config.guess == Guess::Free {
                ranks.push(("guess", posterior.guess.cdf(truth.guess)));
            }
            if experiment.config.overdispersion == Overdispersion::Free {
                ranks.push(("overdispersion", posterior.overdispersion.cdf(truth.overdispersion)));
            }
            ranks
        })
        .collect();
    (0..results[0].len())
        .map(|parameter| {
            let ranks: Vec<f64> = results.iter().map(|ranks| ranks[parameter].1).collect();
            let covered = ranks.iter().filter(|rank| (0.025..=0.975).contains(*rank)).count();
            Calibration { name: results[0][parameter].0, ranks, covered }
        })
        .collect()
}

/// The table of `CALIBRATION.md`.
pub fn print(fits: usize) {
    for experiment in experiments() {
        let drawn = simulate(&experiment, fits, SEED, None);
        print_table(
            &format!("{}: truths drawn from the priors, {fits} fits, seed {SEED}", experiment.name),
            &drawn,
            true,
        );
        let fixed = simulate(&experiment, fits, SEED + 1, Some(ordinary(&experiment)));
        print_table(&format!("{}: one ordinary truth, {fits} fits, seed {}", experiment.name, SEED + 1), &fixed, false);
    }
}
