//! MAR fits: one observer, a group, a test of linearity.

use analysis::mar::hierarchical::{HierarchicalConfig, ObserverTrials, fit_hierarchical};
use analysis::mar::linearity::{LinearityConfig, test_linearity};
use analysis::mar::{MarFitConfig, MarTrial, fit_mar};
use criterion::Criterion;
use experiments::mar::MarModel;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::hint::black_box;

/// Five eccentricities, seven levels each.
fn trials(truth: &MarModel, per_level: usize, seed: u64) -> Vec<MarTrial> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut trials = Vec::new();
    for eccentricity_deg in [0.0, 5.0, 10.0, 15.0, 20.0] {
        for step in 0..7 {
            let mar_deg = (0.022 * eccentricity_deg + 0.021) * (0.25 * f64::from(step) - 0.75).exp();
            let p = truth.probability_correct(eccentricity_deg, mar_deg, 0.5);
            trials.extend((0..per_level).map(|_| MarTrial {
                eccentricity_deg,
                mar_deg,
                correct: rng.random::<f64>() < p,
            }));
        }
    }
    trials
}

const TRUTH: MarModel = MarModel { m: 0.022, omega0_deg: 1.0 / 48.0, width: 0.8, lapse: 0.02 };

/// The joint fit: at most 20 ms on one thread; 12 observers × 245 trials about a second on one thread.
pub(crate) fn bench(criterion: &mut Criterion) {
    let data = trials(&TRUTH, 20, 1);
    let config = MarFitConfig::default();
    criterion.bench_function("joint MAR fit of 700 trials", |bencher| {
        bencher.iter(|| fit_mar(black_box(&data), &config));
    });
    let group: Vec<ObserverTrials> = (0..12)
        .map(|who| {
            let own = MarModel { m: TRUTH.m * (0.04 * f64::from(who) - 0.22).exp(), ..TRUTH };
            ObserverTrials {
                id: format!("P{who:02}"),
                trials: trials(&own, 7, 10 + who as u64),
                finest_mar: Vec::new(),
            }
        })
        .collect();
    criterion.bench_function("hierarchical MAR fit of 12 observers with 245 trials", |bencher| {
        bencher.iter(|| fit_hierarchical(black_box(&group), &HierarchicalConfig::default()));
    });
    criterion.bench_function("linearity of 700 trials, 99 simulations", |bencher| {
        let config = LinearityConfig { simulations: 99, ..LinearityConfig::default() };
        bencher.iter(|| test_linearity(black_box(&data), &config));
    });
}
