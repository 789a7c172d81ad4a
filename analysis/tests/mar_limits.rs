//! What the display could not show is a limit and not a value.
#![allow(clippy::unwrap_used)]

mod common;

use analysis::mar::{MarFitConfig, MarTrial, fit_mar};
use common::{TRUTH, constant_stimuli};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const FINEST: f64 = 0.09;

/// Trials on a display whose finest MAR is `FINEST`: whatever is asked at or below it, nothing changes and the observer
/// guesses; above it the observer answers as the model says. At 1° the threshold is 0.043, below the limit.
fn on_a_coarse_display(seed: u64) -> Vec<MarTrial> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut trials = constant_stimuli(&TRUTH, &[8.0, 14.0, 20.0], 100, seed);
    for i in 0..140 {
        let mar_deg = FINEST * (0.25 * f64::from(i % 7) - 0.625).exp();
        let p = if mar_deg <= FINEST { 0.5 } else { TRUTH.probability_correct(1.0, mar_deg, 0.5) };
        trials.push(MarTrial { eccentricity_deg: 1.0, mar_deg, correct: rng.random::<f64>() < p });
    }
    trials
}

#[test]
fn a_threshold_below_the_display_is_an_upper_limit() {
    let trials = on_a_coarse_display(1);
    let config = MarFitConfig { finest_mar: vec![(0.0, FINEST), (30.0, FINEST)], ..MarFitConfig::default() };
    let fit = fit_mar(&trials, &config).unwrap();

    let near = fit.thresholds[0];
    assert!(near.limited, "{near:?}");
    assert_eq!((near.mar_deg, near.ci95[0]), (FINEST, 0.0));
    assert!(near.ci95[1] >= FINEST && near.ci95[1] < 1.5 * FINEST, "{near:?}");
    assert!(fit.thresholds[1..].iter().all(|t| !t.limited));
    assert!(fit.display_limited, "omega0 {:?} is below the display's finest", fit.omega0);
    let asked_in_vain = trials.iter().filter(|t| t.mar_deg <= FINEST).count();
    assert_eq!((fit.trials_not_shown, fit.trials), (asked_in_vain, 440));
    assert!(fit.support.is_supported(), "{:?}", fit.support);
    assert!(fit.warnings.iter().any(|w| w.contains("upper limit")));
    for (estimate, truth) in [(fit.m, TRUTH.m), (fit.omega0, TRUTH.omega0_deg)] {
        assert!(estimate.ci95[0] <= truth && truth <= estimate.ci95[1], "{estimate:?} misses {truth}");
    }
}

#[test]
fn guesses_below_the_display_would_pass_for_a_high_threshold() {
    let trials = on_a_coarse_display(1);
    let naive = fit_mar(&trials, &MarFitConfig::default()).unwrap();
    let near = naive.thresholds[0];
    assert!(!near.limited && near.ci95[0] > TRUTH.threshold_deg(1.0), "{near:?}");
}

#[test]
fn when_nothing_could_be_measured_the_fit_is_unsupported() {
    let trials: Vec<MarTrial> = on_a_coarse_display(1)
        .into_iter()
        .filter(|t| t.mar_deg > FINEST)
        .map(|t| MarTrial { correct: true, mar_deg: t.mar_deg * 3.0, ..t })
        .collect();
    let config = MarFitConfig { finest_mar: vec![(0.0, 3.0 * FINEST)], ..MarFitConfig::default() };
    let fit = fit_mar(&trials, &config).unwrap();
    assert!(!fit.support.is_supported());
}
